"""Power: how surely a campaign of some size tells two managing systems apart that differ by so much."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.evaluation.resampling import LEAST_LEVELS, Spread, half_squares, subsets
from sunset.evaluation.students_t import quantile
from sunset.seeding import generator

_Array = npt.NDArray[np.float64]
_Factors = tuple[int, ...]

DIFFERENCE: Final = 0.02
"""The difference in utility that reports and plans speak of."""

POWER: Final = 0.8
"""How surely they say that it is told."""

MOST_REPETITIONS: Final = 1000

_DRAWS: Final = 1000
_ALIKE, _FLIGHT, _SEED = range(3)


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """The size of a campaign.

    Attributes:
        alike: of how many different degradations its scenarios are.
        flights: on how many each is run.
        repetitions: how often.
    """

    alike: int
    flights: int
    repetitions: int

    @property
    def is_enough(self) -> bool:
        """Whether differences have an interval."""
        return self.repetitions >= LEAST_LEVELS


@dataclass(frozen=True, slots=True)
class Variances:
    """What makes the difference of two managing systems vary from run to run.

    Attributes:
        parts: factors, by place in `Cluster` → the variance between their levels; of several, of what is theirs
            together only. That of all of them is between cells, each of as many scenarios as share their degradations.
        flights: of how many they were taken; fewer than three say nothing of other flights.
        alike: of how many different degradations; likewise.
    """

    parts: Mapping[_Factors, float]
    flights: int
    alike: int = LEAST_LEVELS

    def reaches(self, design: Design) -> bool:
        """Whether they say how a campaign on so many flights, with so many degradations, varies."""
        pairs = ((self.flights, design.flights), (self.alike, design.alike))
        return all(known >= LEAST_LEVELS or wanted < LEAST_LEVELS for known, wanted in pairs)


_PANEL: Final = 8
_DEVIATIONS: Final[Mapping[str, tuple[float, ...]]] = MappingProxyType(
    {
        "reactive − baseline": (0.0463, 0.0248, 0.0011, 0.0211, 0.0, 0.0071, 0.0113),
        "oracle − baseline": (0.0481, 0.0332, 0.0039, 0.0224, 0.0008, 0.0039, 0.0072),
        "oracle − reactive": (0.0, 0.0087, 0.0048, 0.0134, 0.0032, 0.0058, 0.0084),
    }
)

VARIANCES: Final[Mapping[str, Variances]] = MappingProxyType(
    {
        pair: Variances(
            MappingProxyType(
                {
                    factors: deviation**2
                    for factors, deviation in zip(subsets(range(3)), deviations, strict=True)
                }
            ),
            _PANEL,
        )
        for pair, deviations in _DEVIATIONS.items()
    }
)
"""Two managing systems → what makes their difference in utility vary, as `scripts/measure_variances` prints it: on the
panel, with three seeds, and the scenarios of the suite paper with a camera driver issue or a memory leakage, which are
two for each pair of degradations."""


def variances(spread: Spread) -> Variances:
    """Return what makes the runs vary of which this is the spread of a mean."""
    return Variances(
        MappingProxyType(
            {
                part.factors: part.variance * math.prod(spread.sizes[place] for place in part.factors)
                for part in spread.components
            }
        ),
        spread.sizes[_FLIGHT],
        spread.sizes[_ALIKE],
    )


def power(found: Variances, design: Design, difference: float = DIFFERENCE) -> float:
    """Return the probability that the 95 % interval of a difference excludes 0, in campaigns of this size.

    Args:
        found: what makes the difference vary.
        design: of at least three repetitions.
        difference: the true one, in the unit of the variances' root.
    """
    return _chance(*_outcomes(found, design), difference)


def least_difference(found: Variances, design: Design, chance: float = POWER) -> float:
    """Return the difference that campaigns of this size tell with a probability."""
    halves, error = _outcomes(found, design)
    low, high = 0.0, float(halves.max()) + 10 * error
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (middle, high) if _chance(halves, error, middle) < chance else (low, middle)
    return high


def repetitions_needed(
    found: Variances,
    design: Design,
    difference: float = DIFFERENCE,
    chance: float = POWER,
) -> int | None:
    """Return how many repetitions of a design tell a difference with a probability; None if 1000 do not."""

    def tells(repetitions: int) -> bool:
        size = Design(alike=design.alike, flights=design.flights, repetitions=repetitions)
        return power(found, size, difference) >= chance

    return _least(tells, LEAST_LEVELS, MOST_REPETITIONS)


def _least(holds: Callable[[int], bool], low: int, high: int) -> int | None:
    """Return the least number for which something holds that then holds for all greater ones."""
    if not holds(high):
        return None
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle + 1, high)
    return low


def _outcomes(found: Variances, design: Design) -> tuple[_Array, float]:
    """Return what half the width of the interval may turn out to be, and the mean's standard error."""
    sizes = (design.alike, design.flights, design.repetitions)
    free = [place for place, size in enumerate(sizes) if size >= LEAST_LEVELS]
    true = dict.fromkeys(subsets(free), 0.0)
    for factors, variance in found.parts.items():
        moving = tuple(place for place in factors if place in free)
        if moving:  # what is only between levels that are held as they are does not vary
            true[moving] += variance / math.prod(sizes[place] for place in factors)
    degrees = {factors: math.prod(sizes[place] - 1 for place in factors) for factors in true}
    squares = {
        factors: sum(true[more] for more in true if set(factors) <= set(more))
        * _shares(factors, degrees[factors])
        for factors in true
    }
    parts = [
        np.maximum(
            0,
            sum(
                (-1) ** (len(more) - len(factors)) * squares[more]
                for more in squares
                if set(factors) <= set(more)
            ),
        )
        for factors in squares
    ]
    return np.sqrt(half_squares(parts, list(degrees.values()), quantile)), math.sqrt(math.fsum(true.values()))


@lru_cache(maxsize=256)
def _shares(factors: _Factors, degrees: int) -> _Array:
    """Return what mean squares may turn out to be, as shares of their expectation."""
    return generator(0, "power", *factors, degrees).chisquare(degrees, _DRAWS) / degrees


def _chance(halves: _Array, error: float, difference: float) -> float:
    """Return the probability that a normal figure is further from 0 than half its interval's width."""
    if error == 0:
        return float(np.mean(difference > halves))
    ends = np.concatenate([(difference - halves) / error, (-difference - halves) / error])
    return math.fsum(math.erfc(-end / math.sqrt(2)) / 2 for end in ends.tolist()) / len(halves)
