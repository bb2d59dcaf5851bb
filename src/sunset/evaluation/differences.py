"""Differences between managing systems in their common runs: size, p, power, and the runs needed to detect them."""

import math
from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from statistics import fmean
from typing import TYPE_CHECKING, Final, TypeAlias

from sunset.errors import InvalidInputError
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
from sunset.evaluation.results import FIGURES, RunRow
from sunset.files.dataframes import data_frame
from sunset.texts.sentences import counted
from sunset.texts.tables import aligned
from sunset_ros.texts import suggestion

if TYPE_CHECKING:
    from pandas import DataFrame

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
    """The difference between two rows; figures are None where they are not applicable."""

    first: str
    second: str
    pairs: int  # the number of common runs
    score: Estimate | None  # the first's score less the second's
    utility: Estimate | None  # the first's utility less the second's
    pairs_won: float | None  # the share of pairs in which the first has more utility, ties by half
    p_holm: float | None  # of the difference in utility, adjusted after Holm
    detectable: float | None  # the difference in utility that such campaigns detect with a power of `POWER`
    runs_needed: int | None  # the runs of each that detect `DIFFERENCE` with that power

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
    """Return the differences between pairs of managing systems, named by their keys in `systems`, in utility.

    `gains` are those of repairing in each run that counts for the score.
    """
    compared = [_difference(*pair, systems, gains, clusters) for pair in pairs]
    adjusted = iter(holm([each.p_holm for each in compared if each.p_holm is not None]))
    return tuple(each if each.p_holm is None else replace(each, p_holm=next(adjusted)) for each in compared)


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


def _difference(
    first: str,
    second: str,
    systems: Mapping[str, Figures],
    gains: Figures,
    clusters: Mapping[Experiment, Cluster],
) -> ManagerDifference:
    """Return the difference between two managing systems, with p before its adjustment."""
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
        pairs_won=fmean((lead > 0) + (lead == 0) / 2 for lead in leads.values()) if leads else None,
        p_holm=spread.p_value(utility.mean) if utility and spread else None,
        detectable=detectable(spread) if spread else None,
        runs_needed=round(len(leads) / spread.sizes.repetitions * repetitions)
        if spread and repetitions
        else None,
    )


def power(spread: Spread, difference: float = DIFFERENCE) -> float:
    """Return the probability that the 95 % interval of a difference, which is truly above 0, excludes 0.

    Source: as in `detectable`.
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """A figure of two managing systems, one of `FIGURES`, over the pairs in which both have it."""

    figure: str
    first: float | None  # the mean of the first; None without pairs
    second: float | None
    difference: Estimate | None  # of first - second
    one_sided: int = 0  # the number of other pairs, in which only one of the two has the figure

    @property
    def pairs(self) -> int:
        """The number of pairs."""
        return self.difference.runs if self.difference else 0


def difference(figure: str, rows: Sequence[tuple[Cluster, float | None, float | None]]) -> Difference:
    """Compare a figure of pairs of runs: each row has a pair's cluster, and the figure of its runs or None."""
    both = [(cluster, a, b) for cluster, a, b in rows if a is not None and b is not None]
    return Difference(
        figure=figure,
        first=fmean(a for _, a, _ in both) if both else None,
        second=fmean(b for _, _, b in both) if both else None,
        difference=estimate([a - b for _, a, b in both], [cluster for cluster, _, _ in both]),
        one_sided=sum((a is None) != (b is None) for _, a, b in rows),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PairedComparison:
    """Two managing systems, figure by figure."""

    first: str
    second: str
    pairs: int  # of valid runs
    left_out: int  # valid runs without a valid counterpart
    differences: tuple[Difference, ...]

    def __getitem__(self, figure: str) -> Difference:
        """Return the difference in one figure.

        Raises:
            InvalidInputError: the figure is unknown.
        """
        for compared in self.differences:
            if compared.figure == figure:
                return compared
        raise InvalidInputError(
            f"There is no figure {figure!r}: {suggestion(figure, FIGURES)}choose among {', '.join(FIGURES)}."
        )

    def __str__(self) -> str:
        """Return a table: both means, the mean difference, and its confidence interval."""

        def shown(value: float | None) -> str:
            return "N/A" if value is None else f"{value:z.2f}"

        rows: list[tuple[str, ...]] = [
            ("figure", self.first, self.second, "difference", "95 % interval", "pairs")
        ]
        for compared in self.differences:
            estimate = compared.difference
            ends = (
                "{} to {}".format(*map(shown, estimate.interval)) if estimate and estimate.interval else "N/A"
            )
            means = (compared.first, compared.second, estimate.mean if estimate else None)
            rows.append((compared.figure, *map(shown, means), ends, str(compared.pairs)))
        left_out = f"\n\nLeft out: {counted(self.left_out, 'run')} without a counterpart that counts."
        return "\n".join(aligned(rows)) + (left_out if self.left_out else "")

    def to_frame(self) -> "DataFrame":
        """Return a data frame of pandas with a row for each figure.

        Raises:
            MissingExtraError: pandas is not installed.
        """
        return data_frame(
            {
                "figure": compared.figure,
                self.first: compared.first,
                self.second: compared.second,
                "difference": compared.difference and compared.difference.mean,
                "low": compared.difference and compared.difference.low,
                "high": compared.difference and compared.difference.high,
                "pairs": compared.pairs,
            }
            for compared in self.differences
        )


def compare_managers(runs: Sequence[RunRow], first: str, second: str) -> PairedComparison:
    """Compare two managing systems, named as in the runs, in their common runs.

    Raises:
        InvalidInputError: a managing system is unknown, both are the same, or they have no common run.
    """
    known = sorted({run.manager for run in runs})
    for name in (first, second):
        if name not in known:
            raise InvalidInputError(
                f"There are no runs of a managing system {name!r}: {suggestion(name, known)}choose among "
                f"{', '.join(known)}."
            )
    if first == second:
        raise InvalidInputError(f"Two managing systems are compared, got {first!r} twice.")
    ours, theirs = (
        {run.experiment: run for run in runs if run.manager == name and run.valid} for name in (first, second)
    )
    pairs = [(ours[key], theirs[key]) for key in ours if key in theirs]
    if not pairs:
        raise InvalidInputError(
            f"The managing systems {first} and {second} have no run in common that counts: they need the same "
            "scenarios, seeds, model and flight."
        )
    return PairedComparison(
        first=first,
        second=second,
        pairs=len(pairs),
        left_out=len(ours.keys() ^ theirs.keys()),
        differences=tuple(
            difference(name, [(run.cluster, run.metrics[name], other.metrics[name]) for run, other in pairs])
            for name in FIGURES
        ),
    )
