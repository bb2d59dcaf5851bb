"""How managing systems differ, in the runs that both have: how much, how surely, and what it takes to tell."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

import numpy as np

from sunset.evaluation.estimates import Estimate, estimate, estimate_ratio
from sunset.evaluation.power import DIFFERENCE, POWER, Design, least_difference, repetitions_needed, variances
from sunset.evaluation.resampling import Cluster, Spread

DIFFERENCE_METHOD: Final = (
    "Differences are of runs with the same scenario, flight and seed, with the same bootstrap; those in score, of the "
    "runs that count for it. A12 (Vargha and Delaney): how probably a run of the first has more utility than a run of "
    "the second. p: of the difference in utility, adjusted after Holm for all pairs of managing systems; intervals "
    "are not adjusted. Told: the smallest difference in utility that a campaign of this size detects with a "
    f"probability of {100 * POWER:g} %. Runs for {DIFFERENCE:g}: how many runs of each detect a difference of "
    f"{DIFFERENCE:g} so; never, where only other scenarios or flights would help."
)
"""How differences come about, in words."""

Experiment: TypeAlias = tuple[object, ...]
"""What makes runs of two managing systems a pair: `RunRow.experiment`."""

Figures: TypeAlias = Mapping[Experiment, float]
"""A figure of one managing system's runs, or of pairs of runs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ManagerDifference:
    """What tells two managing systems apart.

    Attributes:
        first: a row's name.
        second: another's.
        pairs: how many runs both have.
        score: by how much the score of the first is above that of the second; None where there is no score.
        utility: likewise of utility; None where there is no pair.
        a12: how probably a run of the first has more utility than one of the second, ties by half; None likewise.
        p: of the difference in utility, adjusted after Holm; None where it has no interval.
        told: the difference in utility that such a campaign tells with a probability of `POWER`; None likewise.
        runs_needed: how many runs of each would tell `DIFFERENCE` so; None where no number of repetitions does, or
            there is no interval.
    """

    first: str
    second: str
    pairs: int
    score: Estimate | None
    utility: Estimate | None
    a12: float | None
    p: float | None
    told: float | None
    runs_needed: int | None

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        return {
            "first": self.first,
            "second": self.second,
            "pairs": self.pairs,
            "score": self.score and self.score.to_json(),
            "utility": self.utility and self.utility.to_json(),
            "a12": self.a12,
            "p_holm": self.p,
            "told": self.told,
            "runs_needed": self.runs_needed,
        }


def differences(
    systems: Mapping[str, Figures],
    gains: Figures,
    clusters: Mapping[Experiment, Cluster],
    pairs: Iterable[tuple[str, str]],
) -> tuple[ManagerDifference, ...]:
    """Return how managing systems differ, pair by pair.

    Args:
        systems: utility of their runs, by name.
        gains: what repairing can win, where that is enough for a score.
        clusters: what each run has in common with others.
        pairs: the names of those that are compared.
    """
    found = [_difference(*pair, systems, gains, clusters) for pair in pairs]
    p_values = [None if difference.utility is None else _p_value(difference.utility) for difference in found]
    adjusted = iter(holm([p for p in p_values if p is not None]))
    return tuple(
        difference if p is None else replace(difference, p=next(adjusted))
        for difference, p in zip(found, p_values, strict=True)
    )


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p-values as they must be read where so many are: adjusted after Holm.

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


def a12(first: Sequence[float], second: Sequence[float]) -> float:
    """Return how probably a value of the first is greater than one of the second, ties by half.

    Source: Vargha and Delaney, A critique and improvement of the CL common language effect size statistics, Journal of
    Educational and Behavioral Statistics 25 (2000).

    >>> a12([1.0, 2.0], [1.0, 0.0])
    0.875
    """
    ordered = np.sort(second)
    less = np.searchsorted(ordered, first, side="left")
    up_to = np.searchsorted(ordered, first, side="right")
    return float((less + up_to).mean() / 2 / len(second))


def _difference(
    first: str,
    second: str,
    systems: Mapping[str, Figures],
    gains: Figures,
    clusters: Mapping[Experiment, Cluster],
) -> ManagerDifference:
    """Return what tells two managing systems apart, all but p."""
    ours, theirs = systems[first], systems[second]
    leads = {key: ours[key] - theirs[key] for key in ours if key in theirs}
    scored = [key for key in leads if key in gains]
    utility = estimate(list(leads.values()), [clusters[key] for key in leads])
    told, needed = _told(utility.spread, utility.runs) if utility and utility.spread else (None, None)
    return ManagerDifference(
        first=first,
        second=second,
        pairs=len(leads),
        score=estimate_ratio(
            [leads[key] for key in scored], [gains[key] for key in scored], [clusters[key] for key in scored]
        )
        if scored
        else None,
        utility=utility,
        a12=a12([ours[key] for key in leads], [theirs[key] for key in leads]) if leads else None,
        p=None,
        told=told,
        runs_needed=needed,
    )


def _p_value(found: Estimate) -> float | None:
    return found.spread.p_value(found.mean) if found.spread else None


def _told(spread: Spread, runs: int) -> tuple[float, int | None]:
    """Return the least difference that such a campaign tells, and how many runs would tell `DIFFERENCE`."""
    found = variances(spread)
    alike, flights, repetitions = spread.sizes
    design = Design(alike=alike, flights=flights, repetitions=repetitions)
    needed = repetitions_needed(found, design)
    return least_difference(found, design), None if needed is None else round(runs / repetitions * needed)
