"""The power of a campaign to detect a difference between two managing systems."""

import math
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

from sunset.evaluation.intervals import LEAST_LEVELS, Design, Spread
from sunset.evaluation.students_t import quantile, within

DIFFERENCE: Final = 0.02
"""The difference in utility that reports and plans use."""

POWER: Final = 0.8
"""The power that reports and plans use."""

MOST_REPETITIONS: Final = 1000

_DEVIATIONS: Final[Mapping[str, Mapping[tuple[int, ...], float]]] = MappingProxyType(
    {
        "reactive − baseline": {(0,): 0.0765, (1,): 0.0120, (0, 1): 0.0113, (0, 1, 2): 0.0149},
        "oracle − baseline": {(0,): 0.0698, (1,): 0.0236, (2,): 0.0014, (0, 1, 2): 0.0147},
        "oracle − reactive": {(0,): 0.0244, (1,): 0.0118, (2,): 0.0036, (0, 1, 2): 0.0216},
    }
)

VARIANCES: Final[Mapping[str, Spread]] = MappingProxyType(
    {
        pair: Spread(
            MappingProxyType({factors: deviation**2 for factors, deviation in deviations.items()}),
            Design(alike=11, flights=4, repetitions=3),
        )
        for pair, deviations in _DEVIATIONS.items()
    }
)
"""Two managing systems → the variances of their difference in utility, as `scripts/measure_variances` printed them from
the runs of the test split in docs/results.md, on the held-out flights."""


def power(spread: Spread, difference: float = DIFFERENCE) -> float:
    """Return the probability that the 95 % interval of a difference excludes 0.

    Args:
        spread: the variances of the difference.
        difference: the true difference, above 0.

    Source: as of `detectable`.
    """
    if not spread.error:
        return 1.0
    t = difference / spread.error - quantile(0.95, spread.degrees)
    return (1 + math.copysign(within(abs(t), spread.degrees), t)) / 2


def detectable(spread: Spread) -> float:
    """Return the difference that campaigns detect with the probability `POWER`.

    Source: Bloom, Minimum detectable effects, Evaluation Review 19 (1995).
    """
    return (quantile(0.95, spread.degrees) + quantile(2 * POWER - 1, spread.degrees)) * spread.error


def repetitions_needed(spread: Spread) -> int | None:
    """Return the repetitions that detect `DIFFERENCE` with the probability `POWER`; None if 1000 do not."""

    def chance(repetitions: int) -> float:
        return power(replace(spread, sizes=spread.sizes._replace(repetitions=repetitions)))

    needed = LEAST_LEVELS + bisect_left(range(LEAST_LEVELS, MOST_REPETITIONS + 1), POWER, key=chance)
    return needed if needed <= MOST_REPETITIONS else None


def reaches(spread: Spread, design: Design) -> bool:
    """Return whether variances hold for a campaign of another size: few levels do not show the variance of more."""
    sizes = zip(spread.sizes[:-1], design[:-1], strict=True)
    return all(size >= LEAST_LEVELS or wanted < LEAST_LEVELS for size, wanted in sizes)
