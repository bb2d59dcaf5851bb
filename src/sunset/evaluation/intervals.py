"""Confidence intervals of figures: crossed random effects.

`docs/metrics.md` has the formula, under *How sure a figure is*: V are the mean squares of factors, and R is the mean
square of the rest.

Sources: Searle, Casella and McCulloch, Variance Components (1992), for crossed random effects without interactions;
Satterthwaite, An approximate distribution of estimates of variance components, Biometrics Bulletin 2 (1946), for the
degrees of freedom, as of min F': Clark, The language-as-fixed-effect fallacy, Journal of Verbal Learning
and Verbal Behavior 12 (1973); Cameron, Gelbach and Miller, Robust inference with multiway clustering, Journal of
Business and Economic Statistics 29 (2011), for the clusters' sums, which serve ratios and unequal numbers of runs, too.
"""

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from sunset.evaluation.students_t import quantile, within

_Array = npt.NDArray[np.float64]
_Codes = npt.NDArray[np.intp]
_Factors = tuple[int, ...]

LEAST_LEVELS: Final = 3
"""The fewest seeds for an interval, and the fewest degradations or flights for an interval about others."""

_LEAST_P: Final = 1e-6
_SEED: Final = 2


class Cluster(NamedTuple):
    """The levels of a run: the degradations of its scenario (else its outages), its flight and its seed."""

    alike: Hashable
    flight: Hashable
    seed: Hashable


class Design(NamedTuple):
    """The size of a campaign: its numbers of degradations, flights and seeds."""

    alike: int
    flights: int
    repetitions: int


@dataclass(frozen=True, slots=True)
class Spread:
    """The variances of a figure between campaigns of the same size.

    A factor of fewer than three levels is fixed, and does not vary.

    Attributes:
        parts: factors, by place in `Cluster` → the variance between their levels; for several factors, of their
            interaction. The variance of seeds is below 0 where they differ less than the rest.
        sizes: the number of levels of each factor of `Cluster`.
    """

    parts: Mapping[_Factors, float]
    sizes: Design

    @property
    def error(self) -> float:
        """The figure's standard error."""
        return math.sqrt(math.fsum(max(0.0, variance) for variance in self._moving().values()))

    @property
    def degrees(self) -> float:
        """The degrees of freedom of the standard error, at least 2."""
        moving = self._moving()
        squares = {
            place: max(0.0, math.fsum(variance for factors, variance in moving.items() if place in factors))
            for place in sorted({place for factors in moving for place in factors})
        }
        scale = math.fsum(square**2 / (self.sizes[place] - 1) for place, square in squares.items())
        return math.fsum(squares.values()) ** 2 / scale if scale else LEAST_LEVELS - 1

    @property
    def half_width(self) -> float:
        """Half the width of the 95 % confidence interval."""
        return self.error * quantile(0.95, self.degrees) if self.error else 0.0

    def p_value(self, distance: float) -> float:
        """Return the p, at least 10⁻⁶, at which half the width of the interval of confidence 1 - p is the distance."""
        if not distance:  # the width may be 0, too
            return 1.0
        t = abs(distance) / self.error if self.error else math.inf
        return max(_LEAST_P, 1 - within(t, self.degrees))

    def _moving(self) -> dict[_Factors, float]:
        """Return the parts of the figure's variance, by the factors that vary."""
        moving: dict[_Factors, float] = {}
        for factors, variance in self.parts.items():
            free = tuple(place for place in factors if self.sizes[place] >= LEAST_LEVELS)
            if free:
                share = variance / math.prod(self.sizes[place] for place in factors)
                moving[free] = moving.get(free, 0.0) + share
        return moving


def spread(top: Sequence[float], bottom: Sequence[float], clusters: Sequence[Cluster]) -> Spread | None:
    """Return the variances of Σ top / Σ bottom; None for fewer than three seeds, which do not show their variance.

    A seed with less than half as many runs as another seed does not count.

    Args:
        top: a number for each run.
        bottom: likewise; 1 for each run if the figure is a mean.
        clusters: likewise.
    """
    codes = [_codes([cluster[place] for cluster in clusters]) for place in range(len(Cluster._fields))]
    runs = np.bincount(codes[_SEED])
    if np.count_nonzero(2 * runs >= runs.max(initial=0)) < LEAST_LEVELS:
        return None
    sizes = Design(*(int(code.max()) + 1 for code in codes))
    whole = math.fsum(bottom)
    apart = (np.asarray(top, float) - math.fsum(top) / whole * np.asarray(bottom, float)) / whole
    places = _outer([place for place, size in enumerate(sizes) if size >= LEAST_LEVELS], codes, sizes)
    counts = tuple(sizes[place] for place in places)
    cells, cell = np.unique(
        np.ravel_multi_index([codes[place] for place in places], counts), return_inverse=True
    )
    levels = dict(zip(places, np.unravel_index(cells, counts), strict=True))
    squares, rest = _mean_squares(np.bincount(cell, apart).astype(np.float64), levels)
    return Spread(MappingProxyType(_parts(squares, rest, sizes)), sizes)


def _codes(levels: Sequence[Hashable]) -> _Codes:
    """Return the number of each level, independent of the order of runs."""
    numbers = {level: number for number, level in enumerate(sorted(set(levels), key=repr))}
    return np.array([numbers[level] for level in levels], dtype=np.intp)


def _outer(places: Sequence[int], codes: Sequence[_Codes], sizes: Sequence[int]) -> list[int]:
    """Return the factors without factors that are nested in another factor."""
    kept = list(places)
    for inner in reversed(places):
        pairs = (codes[inner] * sizes[outer] + codes[outer] for outer in kept if outer != inner)
        if any(len(np.unique(pair)) == sizes[inner] for pair in pairs):
            kept.remove(inner)
    return kept


def _mean_squares(apart: _Array, levels: Mapping[int, _Codes]) -> tuple[dict[int, float], float]:
    """Return the mean square of each factor and of the rest, over the number of cells.

    Args:
        apart: the effect of each cell on the figure.
        levels: factor → the level of each cell.
    """
    squares, unexplained, left = dict[int, float](), float(apart @ apart), len(apart) - 1
    for place, level in levels.items():
        sums, cells = np.bincount(level, apart), np.bincount(level)
        squares[place] = len(sums) / (len(sums) - 1) * float(sums @ sums)
        unexplained -= float((sums**2 / cells).sum())
        left -= len(sums) - 1
    return squares, max(0.0, unexplained) * len(apart) / left if left > 0 else 0.0


def _parts(squares: Mapping[int, float], rest: float, sizes: Sequence[int]) -> dict[_Factors, float]:
    """Return the variances between levels.

    The part of the rest above the variance of seeds does not shrink with repetitions. With a single factor beside the
    seeds, all of the rest does.
    """
    places = tuple(squares)
    still = tuple(place for place in places if place != _SEED)
    fresh = min(rest, squares.get(_SEED, rest)) if len(still) > 1 else rest
    parts = dict.fromkeys([*((place,) for place in places), still, places], 0.0)
    parts |= {
        (place,): square - fresh if place == _SEED else max(0.0, square - rest)
        for place, square in squares.items()
    }
    parts[still] += rest - fresh
    parts[places] += fresh
    return {
        factors: variance * math.prod(sizes[place] for place in factors)
        for factors, variance in parts.items()
        if factors
    }
