"""Differences between managing systems in their common runs: size, p, power, and the runs needed to detect them."""

import math
from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Final, TypeAlias

from sunset.evaluation.intervals import (
    LEAST_LEVELS,
    Cluster,
    Design,
    Estimate,
    Spread,
    estimate,
    estimate_ratio,
    quantile,
    within,
)

DIFFERENCE: Final = 0.02
"""The difference in utility that reports and plans use."""

POWER: Final = 0.8
"""The power that reports and plans use."""

MOST_REPETITIONS: Final = 1000

VARIANCES: Final = {
    pair: Spread(
        {factors: deviation**2 for factors, deviation in deviations.items()},
        Design(alike=11, flights=4, repetitions=3),
    )
    for pair, deviations in {
        "reactive − baseline": {(0,): 0.0765, (1,): 0.0120, (0, 1): 0.0113, (0, 1, 2): 0.0149},
        "oracle − baseline": {(0,): 0.0698, (1,): 0.0236, (2,): 0.0014, (0, 1, 2): 0.0147},
        "oracle − reactive": {(0,): 0.0244, (1,): 0.0118, (2,): 0.0036, (0, 1, 2): 0.0216},
    }.items()
}
"""Two managing systems → the variances of their difference in utility, as `scripts/measure_variances` printed them from
the runs of the test split in docs/results.md, on the held-out flights."""

DIFFERENCE_METHOD: Final = (
    "Differences are of pairs: runs with the same scenario, flight and seed; in score, of the pairs that count for it. "
    "Pairs won: the share of pairs in which the first has more utility, ties by half. p: of the difference in utility, "
    "adjusted after Holm for all pairs of managing systems; intervals are not adjusted."
)
"""The method of differences, in words."""

Experiment: TypeAlias = tuple[object, ...]
"""`RunRow.experiment`, which the runs of a pair have in common."""

Figures: TypeAlias = Mapping[Experiment, float]
"""A figure of a managing system's runs, or of pairs of runs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ManagerDifference:
    """The difference between two managing systems; figures are None where they are not applicable.

    Attributes:
        first: a row's name.
        second: another row's name.
        pairs: the number of common runs.
        score: the first's score less the second's.
        utility: the first's utility less the second's.
        pairs_won: the share of pairs in which the first has more utility, ties by half.
        p_holm: of the difference in utility, adjusted after Holm.
        detectable: the difference in utility that such campaigns detect with a power of `POWER`.
        runs_needed: the runs of each that detect `DIFFERENCE` with that power.
    """

    first: str
    second: str
    pairs: int
    score: Estimate | None
    utility: Estimate | None
    pairs_won: float | None
    p_holm: float | None
    detectable: float | None
    runs_needed: int | None

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {
            name: value.to_json() if isinstance(value, Estimate) else value for name, value in values.items()
        }


def differences(
    systems: Mapping[str, Figures],
    gains: Figures,
    clusters: Mapping[Experiment, Cluster],
    pairs: Iterable[tuple[str, str]],
) -> tuple[ManagerDifference, ...]:
    """Return the differences between pairs of managing systems.

    Args:
        systems: name → utility of the runs.
        gains: the gain of repairing in each run that counts for the score.
        clusters: of each run.
        pairs: the names to compare.
    """
    compared = [_difference(*pair, systems, gains, clusters) for pair in pairs]
    utilities = [difference.utility for difference in compared]
    p_values = [
        utility.spread.p_value(utility.mean) if utility and utility.spread else None for utility in utilities
    ]
    adjusted = iter(holm([p for p in p_values if p is not None]))
    return tuple(
        difference if p is None else replace(difference, p_holm=next(adjusted))
        for difference, p in zip(compared, p_values, strict=True)
    )


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p-values adjusted for their number after Holm.

    Source: Holm, A simple sequentially rejective multiple test procedure, Scandinavian Journal of Statistics 6 (1979).

    >>> holm([0.01, 0.04, 0.03])
    [0.03, 0.06, 0.06]
    """
    adjusted = [0.0] * len(p_values)
    least = 0.0
    for rank, place in enumerate(sorted(range(len(p_values)), key=p_values.__getitem__)):
        least = max(least, min(1.0, (len(p_values) - rank) * p_values[place]))
        adjusted[place] = least
    return adjusted


def pairs_won(leads: Sequence[float]) -> float:
    """Return the share of pairs in which the first leads, ties by half.

    Args:
        leads: the first's lead in each pair; at least one.

    >>> pairs_won([0.25, -0.5, 0.0, 0.5])
    0.625
    """
    return sum((lead > 0) + (lead == 0) / 2 for lead in leads) / len(leads)


def _difference(
    first: str,
    second: str,
    systems: Mapping[str, Figures],
    gains: Figures,
    clusters: Mapping[Experiment, Cluster],
) -> ManagerDifference:
    """Return the difference between two managing systems without p."""
    ours, theirs = systems[first], systems[second]
    leads = {key: ours[key] - theirs[key] for key in ours if key in theirs}
    scored = [key for key in leads if key in gains]
    utility = estimate(list(leads.values()), [clusters[key] for key in leads])
    spread = utility.spread if utility else None
    repetitions = repetitions_needed(spread) if spread else None
    return ManagerDifference(
        first=first,
        second=second,
        pairs=len(leads),
        score=estimate_ratio(
            [leads[key] for key in scored], [gains[key] for key in scored], [clusters[key] for key in scored]
        ),
        utility=utility,
        pairs_won=pairs_won(list(leads.values())) if leads else None,
        p_holm=None,
        detectable=detectable(spread) if spread else None,
        runs_needed=round(len(leads) / spread.sizes.repetitions * repetitions)
        if spread and repetitions
        else None,
    )


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
