"""The source of random numbers: the same seed and purpose give the same stream on every platform."""

import hashlib

import numpy as np

from sunset_town.errors import TownError

MAX_SEED = 2**32 - 1


def check_seed(seed: int) -> None:
    """Check that a seed is a whole number in [0, 2³² − 1].

    Raises:
        TownError: it is anything else.
    """
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed <= MAX_SEED:
        raise TownError(f"A seed must be a whole number from 0 to {MAX_SEED}, got {seed!r}.")


def generator(seed: int, *path: str | int) -> np.random.Generator:
    """Return an independent random generator for the purpose that a path names, such as `("town", "plan")`.

    Raises:
        TownError: the seed is out of range.

    >>> a, b = generator(1, "noise", 3), generator(1, "noise", 3)
    >>> bool(a.integers(1000) == b.integers(1000))
    True
    """
    check_seed(seed)
    text = "/".join([str(seed), *(f"{type(part).__name__}:{part}" for part in path)])
    words = np.frombuffer(hashlib.sha256(text.encode()).digest(), dtype=np.uint32)
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([int(word) for word in words])))
