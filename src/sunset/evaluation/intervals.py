"""How sure a figure of many runs is: crossed random effects.

`docs/metrics.md` has the formula, under *How sure a figure is*: V are the mean squares of factors, and R is that of the
rest.

Sources: Searle, Casella and McCulloch, Variance Components (1992), for crossed random effects without interactions;
Satterthwaite, An approximate distribution of estimates of variance components, Biometrics Bulletin 2 (1946), for the
degrees of freedom, which are those of min F': Clark, The language-as-fixed-effect fallacy, Journal of Verbal Learning
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
"""An interval speaks of these degradations or flights only where there are fewer, and needs as many seeds."""

_LEAST_P: Final = 1e-6
_SEED: Final = 2


class Cluster(NamedTuple):
    """What a run has in common with others.

    Attributes:
        alike: the degradations of its scenario; where there are none, its outages.
        flight: what it is run on.
        seed: of its repetition.
    """

    alike: Hashable
    flight: Hashable
    seed: Hashable


class Design(NamedTuple):
    """The size of a campaign.

    Attributes:
        alike: of how many different degradations its scenarios are.
        flights: on how many each is run.
        repetitions: how often, with as many seeds.
    """

    alike: int
    flights: int
    repetitions: int


@dataclass(frozen=True, slots=True)
class Spread:
    """How much a figure varies between campaigns of one size.

    A factor of fewer than three levels is held as it is, and does not vary.

    Attributes:
        parts: factors, by place in `Cluster` → the variance between their levels; that of several factors is what they
            bring about together only. That of seeds is below 0 where they differ less than the rest does.
        sizes: of the campaigns: how many levels each factor of `Cluster` has.
    """

    parts: Mapping[_Factors, float]
    sizes: Design

    @property
    def error(self) -> float:
        """The figure's standard error."""
        return math.sqrt(math.fsum(max(0.0, variance) for variance in self._moving().values()))

    @property
    def degrees(self) -> float:
        """The degrees of freedom with which the standard error is known, at least 2."""
        moving = self._moving()
        squares = {
            place: max(0.0, math.fsum(variance for factors, variance in moving.items() if place in factors))
            for place in sorted({place for factors in moving for place in factors})
        }
        known = math.fsum(square**2 / (self.sizes[place] - 1) for place, square in squares.items())
        return math.fsum(squares.values()) ** 2 / known if known else LEAST_LEVELS - 1

    @property
    def half_width(self) -> float:
        """Half the width of the 95 % confidence interval."""
        return self.error * quantile(0.95, self.degrees) if self.error else 0.0

    def p_value(self, distance: float) -> float:
        """Return the p at which the interval with confidence 1 - p is as wide on each side as the distance.

        It is at least 10⁻⁶, and 1 for a distance of 0.
        """
        if not distance:  # whose interval may have no width either
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
    """Return how sure Σ top / Σ bottom is; None where an interval would not hold.

    A factor of fewer than three levels is held as it is: the spread is that of other campaigns with the same
    degradations, or on the same flights. With fewer than three seeds there is none, since
    nothing then says how much repetitions differ; one with less than half as many runs as another does not count.

    Args:
        top: a number a run.
        bottom: of the same length; 1 for each run gives the spread of the mean.
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
    """Return the number of each level, in an order that does not depend on that of the runs."""
    numbers = {level: number for number, level in enumerate(sorted(set(levels), key=repr))}
    return np.array([numbers[level] for level in levels], dtype=np.intp)


def _outer(places: Sequence[int], codes: Sequence[_Codes], sizes: Sequence[int]) -> list[int]:
    """Return the factors, less those of which each level lies within one level of another."""
    kept = list(places)
    for inner in reversed(places):
        pairs = (codes[inner] * sizes[outer] + codes[outer] for outer in kept if outer != inner)
        if any(len(np.unique(pair)) == sizes[inner] for pair in pairs):
            kept.remove(inner)
    return kept


def _mean_squares(apart: _Array, levels: Mapping[int, _Codes]) -> tuple[dict[int, float], float]:
    """Return the mean square of each factor and of the rest, over the number of cells.

    Args:
        apart: how much each cell moves the figure.
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

    Of the rest, that which exceeds the scatter between seeds is no repetition's: it stays, however many there are. But
    where one factor alone is beside the seeds, the rest is of both, and is a repetition's as a whole.
    """
    places = tuple(squares)
    still = tuple(place for place in places if place != _SEED)
    fresh = min(rest, squares.get(_SEED, rest)) if len(still) > 1 else rest
    found = dict.fromkeys([*((place,) for place in places), still, places], 0.0)
    found |= {
        (place,): square - fresh if place == _SEED else max(0.0, square - rest)
        for place, square in squares.items()
    }
    found[still] += rest - fresh
    found[places] += fresh
    return {
        factors: variance * math.prod(sizes[place] for place in factors)
        for factors, variance in found.items()
        if factors
    }
