"""How sure a figure of many runs is: the crossed cluster bootstrap.

Runs are not independent. Those with the same degradations are alike, whatever outage comes with them; so are those on
one flight, and those with one seed. A resample draws the degradations with replacement from those that were run, and
likewise the flights and the seeds; a run counts as often as the product of the three says (the pigeonhole bootstrap).

The variance of such resamples is not the figure's: it counts the scatter within cells several times, and with three
seeds it is too small by a third of what they bring about. So each resample is taken apart into what every factor brings
about alone, and what they bring about together. The variances of these parts, with n / (n - 1) for each factor of n
levels, are the mean squares of an analysis of variance, and give the variance components V, each with its degrees of
freedom.

Of the two usual intervals, Satterthwaite's (t of the degrees that the sum of the components has, times the root of the
sum) is too narrow where there are few seeds, and Banerjee's (half² = Σ t² V, each component with its own t) too
wide. The squares of half the width are averaged. `benchmarks/coverage.py` prints how often such intervals hold.

Sources: Owen, The pigeonhole bootstrap, Annals of Applied Statistics 1 (2007); Owen and Eckles, Bootstrapping data
arrays of arbitrary order, ibid. 6 (2012); Banerjee, Approximate confidence interval for linear functions of means of k
populations when the population variances are not equal, Sankhyā 22 (1960); Satterthwaite, An approximate
distribution of estimates of variance components, Biometrics Bulletin 2 (1946).
"""

import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from sunset.evaluation.students_t import CONFIDENCES, quantile, quantiles
from sunset.seeding import generator

_Array = npt.NDArray[np.float64]

LEAST_LEVELS: Final = 3
"""With fewer degradations or flights, an interval says nothing of others; with fewer seeds there is none."""

_RESAMPLES: Final = 2000
_SEED: Final = 0


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


class Component(NamedTuple):
    """A part of a figure's variance.

    Attributes:
        factors: what brings it about, by place in `Cluster`; several of them together.
        variance: of the figure.
        degrees: of freedom, with which it is known.
    """

    factors: tuple[int, ...]
    variance: float
    degrees: int


@dataclass(frozen=True, slots=True)
class Spread:
    """How much a figure would vary in other campaigns of the same size.

    Attributes:
        components: the parts of its variance.
        sizes: how many levels each factor of `Cluster` has.
    """

    components: tuple[Component, ...]
    sizes: tuple[int, ...]

    @property
    def half_width(self) -> float:
        """Half the width of the 95 % confidence interval."""
        return math.sqrt(float(self._half_squares(quantile)))

    def p_value(self, distance: float) -> float:
        """Return the p at which the half-width of the interval with confidence 1 - p equals the distance.

        It is at least 10⁻⁶, and 1 for a distance of 0.
        """
        if not distance:  # whose interval may have no width either
            return 1.0
        halves = np.sqrt(self._half_squares(quantiles))
        return float(1 - np.interp(abs(distance), halves, CONFIDENCES, left=0.0))

    def _half_squares(self, t: Callable[[float], _Array]) -> _Array:
        parts = [np.array(part.variance) for part in self.components]
        return half_squares(parts, [part.degrees for part in self.components], t)


def half_squares(parts: Sequence[_Array], degrees: Sequence[int], t: Callable[..., _Array]) -> _Array:
    """Return the squares of half the widths of intervals.

    Args:
        parts: the components of the variance; each as many numbers as there are intervals, or one.
        degrees: of freedom, of each component.
        t: the quantile of degrees of freedom.
    """
    known = list(zip(parts, degrees, strict=True))
    total = np.sum(parts, axis=0)
    fourth = np.sum([part**2 / degree for part, degree in known], axis=0)
    joint = np.divide(total**2, fourth, out=np.ones_like(total), where=fourth > 0)
    banerjee = sum((part * t(degree) ** 2 for part, degree in known), np.zeros(()))
    return np.asarray((banerjee + total * t(joint) ** 2) / 2)


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
    sizes = tuple(int(code.max()) + 1 if len(code) else 0 for code in codes)
    runs = np.bincount(codes[-1])
    if np.count_nonzero(2 * runs >= runs.max(initial=0)) < LEAST_LEVELS:
        return None
    free = [place for place, size in enumerate(sizes) if size >= LEAST_LEVELS]
    counts = [sizes[place] for place in free]
    cells = tuple(codes[place] for place in free)
    sums = np.zeros((*counts, 2))
    np.add.at(sums, cells, np.stack([np.asarray(top, float), np.asarray(bottom, float)], axis=1))
    squares = _mean_squares(sums)
    return Spread(
        tuple(
            Component(
                tuple(free[place] for place in factors),
                max(0.0, _above(factors, squares)),
                _degrees([cells[place] for place in factors], [counts[place] for place in factors]),
            )
            for factors in squares
        ),
        sizes,
    )


def subsets(places: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Give every subset but the empty one, the smaller first."""
    for size in range(1, len(places) + 1):
        yield from combinations(places, size)


def _codes(levels: Sequence[Hashable]) -> npt.NDArray[np.int64]:
    """Return the number of each level, in an order that does not depend on that of the runs."""
    numbers = {level: number for number, level in enumerate(sorted(set(levels), key=repr))}
    return np.array([numbers[level] for level in levels], dtype=np.int64)


def _mean_squares(sums: _Array) -> dict[tuple[int, ...], float]:
    """Return, by factors, the variance of what they bring about in the resamples, corrected for their few levels.

    Args:
        sums: of top and bottom, by the levels of all factors: (levels, …, 2).
    """
    places = range(sums.ndim - 1)
    parts: dict[tuple[int, ...], _Array] = {(): _ratio(sums.sum(tuple(places)))}
    for factors in subsets(places):
        figures = _figures(sums, factors)
        parts[factors] = figures - sum(parts[less] for less in parts if set(less) < set(factors))
    return {
        factors: float(np.nanvar(part))
        * math.prod(sums.shape[place] / (sums.shape[place] - 1) for place in factors)
        for factors, part in parts.items()
        if factors
    }


def _figures(sums: _Array, factors: Sequence[int]) -> _Array:
    """Return the figure of each resample in which only these factors are drawn anew."""
    kept = sums.sum(tuple(place for place in range(sums.ndim - 1) if place not in factors))
    # einsum, since the threads of a matrix product cost more than they save on so small arrays
    resampled = np.einsum("ri,i...->r...", _multiplicities(factors[0], kept.shape[0]), kept)
    for place, count in zip(factors[1:], kept.shape[1:], strict=False):
        resampled = np.einsum("ri,ri...->r...", _multiplicities(place, count), resampled)
    return _ratio(resampled)


def _ratio(sums: _Array) -> _Array:
    """Return top / bottom; NaN where no run is left."""
    top, bottom = sums[..., 0], sums[..., 1]
    return np.divide(top, bottom, out=np.full_like(top, np.nan), where=bottom != 0)


@lru_cache(maxsize=64)
def _multiplicities(place: int, count: int) -> _Array:
    """Return how often each resample has each level of a factor: (resamples, levels).

    They are turned a little, so that their covariance is exactly what it is over all resamples: a mean then has the
    variance that infinitely many would give.
    """
    drawn = generator(_SEED, "bootstrap", place, count).integers(count, size=(_RESAMPLES, count))
    often = np.stack([(drawn == level).sum(axis=1) for level in range(count)], axis=1)
    apart = often - often.mean(axis=0)
    values, vectors = np.linalg.eigh(apart.T @ apart / _RESAMPLES)
    values, vectors = values[1:], vectors[:, 1:]  # the sum of a resample is always the same
    turned: _Array = 1 + apart @ (vectors / np.sqrt(values)) @ vectors.T
    return turned


def _above(factors: tuple[int, ...], squares: dict[tuple[int, ...], float]) -> float:
    """Return the variance component of factors: their mean square, less what others have a part in."""
    return math.fsum(
        (-1) ** (len(more) - len(factors)) * square
        for more, square in squares.items()
        if set(factors) <= set(more)
    )


def _degrees(levels: Sequence[npt.NDArray[np.int64]], counts: Sequence[int]) -> int:
    """Return the degrees of freedom; not more than there are combinations, where one factor tells the other."""
    combinations_run = int(np.unique(np.stack(levels), axis=1).shape[1])
    return min(math.prod(count - 1 for count in counts), combinations_run - 1)
