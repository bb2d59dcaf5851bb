"""The one door for random numbers: every generator of the project is made here."""

import hashlib

import numpy as np

from sunset.common.errors import InvalidInputError
from sunset.common.texts import shown

MAX_SEED = 2**32 - 1
"""The largest seed that is accepted; the smallest is 0."""


def check_seed(seed: int) -> int:
    """Return `seed` unchanged if it is a whole number in [0, 2³² − 1].

    Raises:
        InvalidInputError: it is anything else.
    """
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed <= MAX_SEED:
        raise InvalidInputError(f"A seed must be a whole number from 0 to {MAX_SEED}, got {shown(seed)}.")
    return seed


def generator(seed: int, *path: str | int) -> np.random.Generator:
    """Return an independent random generator for one purpose.

    Generators of different paths are statistically independent of each other, and the same
    `(seed, path)` gives the same stream in any process, on any platform.

    Args:
        seed: a whole number in [0, 2³² − 1].
        path: names the purpose, such as `("depth", "noise", 17)`; strings and whole numbers.

    Raises:
        InvalidInputError: the seed is out of range.

    >>> a, b = generator(1, "noise", 3), generator(1, "noise", 3)
    >>> bool(a.integers(1000) == b.integers(1000))
    True
    """
    text = "/".join([str(check_seed(seed)), *(f"{type(part).__name__}:{part}" for part in path)])
    words = np.frombuffer(hashlib.sha256(text.encode()).digest(), dtype=np.uint32)
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([int(word) for word in words])))


def drawn_seed(seed: int, *path: str | int) -> int:
    """Return a seed in [0, 2³¹) that is drawn from another one, for whoever must not know that.

    Raises:
        InvalidInputError: the seed is out of range.

    >>> drawn_seed(1, "manager") == drawn_seed(1, "manager") != drawn_seed(2, "manager")
    True
    """
    return int(generator(seed, *path).integers(2**31))
