"""How managing systems differ, in the runs that both have: how much, how surely, and what it takes to tell."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Final, TypeAlias

from sunset.evaluation.estimates import Estimate, estimate, estimate_ratio
from sunset.evaluation.intervals import Cluster
from sunset.evaluation.power import detectable, repetitions_needed

DIFFERENCE_METHOD: Final = (
    "Differences are of pairs: runs with the same scenario, flight and seed; in score, of the pairs that count for it. "
    "Pairs won: the share of pairs in which the first has more utility, ties by half. p: of the difference in utility, "
    "adjusted after Holm for all pairs of managing systems; intervals are not adjusted."
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
        pairs_won: the share of pairs in which the first has more utility, ties by half; None likewise.
        p_holm: of the difference in utility, adjusted after Holm; None where it has no interval.
        detectable: the difference in utility that such campaigns detect with a power of `POWER`; None likewise.
        runs_needed: how many runs of each detect `DIFFERENCE` so; None where no number of repetitions does, or there
            is no interval.
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
    """Return how managing systems differ, pair by pair.

    Args:
        systems: utility of their runs, by name.
        gains: what repairing can win, where that is enough for a score.
        clusters: what each run has in common with others.
        pairs: the names of those that are compared.
    """
    found = [_difference(*pair, systems, gains, clusters) for pair in pairs]
    estimates = [one.utility for one in found]
    p_values = [one.spread.p_value(one.mean) if one and one.spread else None for one in estimates]
    adjusted = iter(holm([p for p in p_values if p is not None]))
    return tuple(
        difference if p is None else replace(difference, p_holm=next(adjusted))
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


def pairs_won(leads: Sequence[float]) -> float:
    """Return the share of pairs in which the first has more than the second, ties by half.

    Args:
        leads: by how much the first has more, of each pair; at least one.

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
    """Return what tells two managing systems apart, all but p."""
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
        )
        if scored
        else None,
        utility=utility,
        pairs_won=pairs_won(list(leads.values())) if leads else None,
        p_holm=None,
        detectable=detectable(spread) if spread else None,
        runs_needed=round(len(leads) / spread.sizes.repetitions * repetitions)
        if spread and repetitions
        else None,
    )
