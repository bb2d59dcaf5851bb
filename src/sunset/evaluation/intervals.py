"""Figures of several runs: mean, standard deviation and confidence interval, for crossed random effects.

`docs/metrics.md` has the formula, under *How sure a figure is*: V are the mean squares of factors, and R is the mean
square of the rest.

Sources: Searle, Casella and McCulloch, Variance Components (1992), for crossed random effects without interactions;
Satterthwaite, An approximate distribution of estimates of variance components, Biometrics Bulletin 2 (1946), for the
degrees of freedom, as in min F': Clark, The language-as-fixed-effect fallacy, Journal of Verbal Learning
and Verbal Behavior 12 (1973); Cameron, Gelbach and Miller, Robust inference with multiway clustering, Journal of
Business and Economic Statistics 29 (2011), for the clusters' sums, which serve ratios and unequal numbers of runs, too.
"""

import math
import statistics
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

_Array = npt.NDArray[np.float64]
_Codes = npt.NDArray[np.intp]
_Factors = tuple[int, ...]

LEAST_LEVELS: Final = 3
"""The fewest seeds for an interval, and the fewest degradations or flights for an interval about others."""

DEVIATIONS: Final = "±: the sample standard deviation over runs."
INTERVALS: Final = (
    "In brackets: the 95 % confidence interval of the mean, that of crossed random effects (Searle, Casella and "
    "McCulloch 1992) with degrees of freedom after Satterthwaite (1946). Runs with the same degradations, on the same "
    "flight, and of the same seed are correlated; without degradations, those with the same failures. Where at least "
    f"{LEAST_LEVELS} degradations or flights were run, the interval holds for others, too; else for these only."
)
"""Notes for tables with deviations and intervals."""

NO_INTERVAL: Final = (
    f"Figures of fewer than {LEAST_LEVELS} seeds have no confidence interval: nothing says how much repetitions "
    "differ. A seed with less than half as many runs as another does not count."
)
"""A note for tables with such figures."""

_LEAST_P: Final = 1e-6
_SEED: Final = 2
_MOST_T: Final = 1e6
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(100)


def within(t: float, degrees: float) -> float:
    """Return the probability that a number of Student's t distribution with degrees ≥ 2 is within ± t, for t ≥ 0.

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
    low, high = 0.0, _MOST_T
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if within(middle, degrees) < confidence else (low, middle)
    return high


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

    Factors, by their places in `Cluster`, have the variance between their levels; several factors that of their
    interaction. A factor of fewer than three levels is fixed, and does not vary. The variance of seeds is below 0 where
    they differ less than the rest.
    """

    parts: Mapping[_Factors, float]
    sizes: Design  # the number of levels of each factor

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

    There is a top, a bottom and a cluster for each run; if the figure is a mean, the bottoms are 1. A seed with less
    than half as many runs as another seed does not count.
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
    return Spread(_parts(squares, rest, sizes), sizes)


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

    `apart` is the effect of each cell on the figure, and `levels` has the level of each cell by factor.
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


@dataclass(frozen=True, slots=True)
class Estimate:
    """A figure of several runs."""

    mean: float  # over the runs that have the figure
    std: float | None  # their sample standard deviation (division by n - 1); None for a single run or a ratio
    low: float | None  # the lower end of the mean's 95 % interval; None for fewer than three seeds
    high: float | None
    runs: int  # the number of runs that have the figure
    spread: Spread | None = field(default=None, repr=False, compare=False)  # None without an interval

    @property
    def interval(self) -> tuple[float, float] | None:
        """The ends of the interval, or None."""
        return None if self.low is None or self.high is None else (self.low, self.high)

    @property
    def lacks_interval(self) -> bool:
        """Whether several runs have too few seeds for an interval."""
        return self.runs > 1 and self.low is None

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        return {"mean": self.mean, "std": self.std, "ci95": self.interval, "runs": self.runs}


def estimate(values: Sequence[float | None], clusters: Sequence[Cluster]) -> Estimate | None:
    """Return the mean of the runs' values that are not None, with its interval; None without a value.

    >>> estimate([1.0, None], [Cluster("noise", "town", 1)] * 2)
    Estimate(mean=1.0, std=None, low=None, high=None, runs=1)
    """
    known = [(value, cluster) for value, cluster in zip(values, clusters, strict=True) if value is not None]
    tops = [value for value, _ in known]
    mean = estimate_ratio(tops, [1.0] * len(tops), [cluster for _, cluster in known])
    return replace(mean, std=statistics.stdev(tops)) if mean and len(tops) > 1 else mean


def estimate_ratio(
    tops: Sequence[float], bottoms: Sequence[float], clusters: Sequence[Cluster]
) -> Estimate | None:
    """Return the mean of the runs' tops over that of their bottoms, above 0, with its interval; None without runs."""
    if not tops:
        return None
    figure = math.fsum(tops) / math.fsum(bottoms)
    variances = spread(tops, bottoms, clusters)
    if variances is None:
        return Estimate(figure, None, None, None, len(tops))
    half = variances.half_width
    return Estimate(figure, None, figure - half, figure + half, len(tops), variances)
