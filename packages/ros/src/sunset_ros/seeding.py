"""Random generators: all generators of the library and of SUNSET are made here."""

import hashlib
from typing import TYPE_CHECKING

from sunset_ros.errors import InvalidInputError
from sunset_ros.texts import shown

if TYPE_CHECKING:
    import numpy as np

MAX_SEED = 2**32 - 1
"""The largest seed; the smallest is 0."""


def check_seed(seed: int) -> int:
    """Return a seed, if it is a whole number in [0, 2³² − 1]."""
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed <= MAX_SEED:
        raise InvalidInputError(f"A seed must be a whole number from 0 to {MAX_SEED}, got {shown(seed)}.")
    return seed


def generator(seed: int, *path: str | int) -> "np.random.Generator":
    """Return a random generator for a purpose, statistically independent of the generators of other paths.

    The same seed and path give the same stream in any process, on any platform.

    Args:
        seed: a whole number in [0, 2³² − 1].
        path: the purpose, such as `("depth", "noise", 17)`.

    >>> a, b = generator(1, "noise", 3), generator(1, "noise", 3)
    >>> bool(a.integers(1000) == b.integers(1000))
    True
    """
    import numpy as np  # noqa: PLC0415  slow, and not needed to list scenarios

    text = "/".join([str(check_seed(seed)), *(f"{type(part).__name__}:{part}" for part in path)])
    words = np.frombuffer(hashlib.sha256(text.encode()).digest(), dtype=np.uint32)
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([int(word) for word in words])))


def drawn_seed(seed: int, *path: str | int) -> int:
    """Return a seed in [0, 2³¹) that is drawn from another seed, for code that must not know the other.

    >>> drawn_seed(1, "manager") == drawn_seed(1, "manager") != drawn_seed(2, "manager")
    True
    """
    return int(generator(seed, *path).integers(2**31))
