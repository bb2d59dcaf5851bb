"""Student's t distribution, two-sided."""

import math
from functools import lru_cache
from statistics import NormalDist
from typing import Final

import numpy as np
import numpy.typing as npt

_Array = npt.NDArray[np.float64]

CONFIDENCES: Final = 1 - np.geomspace(1, 1e-6, 300)[1:]
"""The confidences of `quantiles`, from the least to the greatest."""

_FEW: Final = 30
"""Up to so many degrees of freedom t is solved for; with more, an expansion has six digits of it."""


def quantile(degrees: float | _Array) -> _Array:
    """Return the t that a Student-distributed number stays under, in magnitude, with a probability of 95 %.

    Args:
        degrees: of freedom, of whatever shape and at least 1; between whole numbers t goes on as 1 / degrees does.

    >>> float(quantile(2).round(3))
    4.303
    """
    inverse = 1 / np.asarray(degrees, dtype=np.float64)
    few = np.interp(inverse, 1 / np.arange(_FEW, 0, -1), _of_few_at_95_percent()[::-1])
    return np.where(inverse < 1 / _FEW, _expansion(np.array(NormalDist().inv_cdf(0.975)), inverse), few)


def quantiles(degrees: float) -> _Array:
    """Return t likewise of one number of degrees, with each probability of `CONFIDENCES`."""
    if degrees > _FEW:
        return _expansion(_normal_quantiles(), np.array(1 / degrees))
    below, above = math.floor(degrees), math.ceil(degrees)
    if below == above:
        return _of_few(below)
    share = (1 / below - 1 / degrees) / (1 / below - 1 / above)
    return (1 - share) * _of_few(below) + share * _of_few(above)


def _expansion(x: _Array, inverse: _Array) -> _Array:
    """Return t of the normal distribution's quantile x.

    Source: Abramowitz and Stegun, Handbook of Mathematical Functions, 26.7.5.
    """
    terms = (
        (x**3 + x) / 4,
        (5 * x**5 + 16 * x**3 + 3 * x) / 96,
        (3 * x**7 + 19 * x**5 + 17 * x**3 - 15 * x) / 384,
        (79 * x**9 + 776 * x**7 + 1482 * x**5 - 1920 * x**3 - 945 * x) / 92160,
    )
    return np.asarray(x + sum(term * inverse**power for power, term in enumerate(terms, 1)))


@lru_cache(maxsize=1)
def _normal_quantiles() -> _Array:
    normal = NormalDist()
    return np.array([normal.inv_cdf((1 + confidence) / 2) for confidence in CONFIDENCES.tolist()])


@lru_cache(maxsize=1)
def _of_few_at_95_percent() -> _Array:
    return np.concatenate([_solved(np.array([0.95]), degrees) for degrees in range(1, _FEW + 1)])


@lru_cache(maxsize=_FEW)
def _of_few(degrees: int) -> _Array:
    return _solved(CONFIDENCES, degrees)


def _solved(confidences: _Array, degrees: int) -> _Array:
    """Return t with each probability, by halving."""
    low, high = np.zeros_like(confidences), np.full_like(confidences, 1e6)
    for _ in range(60):
        middle = (low + high) / 2
        falls_short = _within(middle, degrees) < confidences
        low, high = np.where(falls_short, middle, low), np.where(falls_short, high, middle)
    return high


def _within(t: _Array, degrees: int) -> _Array:
    """Return the probabilities of magnitudes up to each t.

    Source: Abramowitz and Stegun, Handbook of Mathematical Functions, 26.7.3 and 26.7.4.
    """
    angle = np.arctan2(t, math.sqrt(degrees))
    square = np.cos(angle) ** 2
    odd = degrees % 2
    term = np.cos(angle) if odd else np.ones_like(angle)
    total = np.zeros_like(angle) if degrees == 1 else term
    for k in range(1 + odd, degrees - 1, 2):
        term = term * (k / (k + 1) * square)
        total = total + term
    found = 2 / math.pi * (angle + np.sin(angle) * total) if odd else np.sin(angle) * total
    return np.asarray(found, dtype=np.float64)
