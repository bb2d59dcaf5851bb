"""Student's t distribution, two-sided."""

import math
from functools import lru_cache
from typing import Final

import numpy as np

_MOST: Final = 1e6
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(100)


def within(t: float, degrees: float) -> float:
    """Return the probability that the magnitude of a Student-distributed number is under t.

    Args:
        t: at least 0.
        degrees: of freedom, at least 2; also fractions.

    Source: the density in the angle whose tangent is t / √degrees is a power of its cosine (Abramowitz and Stegun,
    Handbook of Mathematical Functions, 26.7), which is integrated after Gauss and Legendre.

    >>> round(within(4.303, 2), 4)
    0.95
    """
    angle = math.atan2(t, math.sqrt(degrees))
    powers = np.cos(angle * (_POINTS + 1) / 2) ** (degrees - 1)
    scale = math.exp(math.lgamma((degrees + 1) / 2) - math.lgamma(degrees / 2)) / math.sqrt(math.pi)
    return min(1.0, float(_WEIGHTS @ powers) * angle * scale)


@lru_cache(maxsize=1024)
def quantile(confidence: float, degrees: float) -> float:
    """Return the t with `within(t, degrees) = confidence`, which is at least 0 and less than 1.

    >>> round(quantile(0.95, 2), 3)
    4.303
    """
    low, high = 0.0, _MOST
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if within(middle, degrees) < confidence else (low, middle)
    return high
