"""A comparison of two managing systems in their common runs: the same scenario, flight, model and seed."""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import TYPE_CHECKING

from sunset.errors import InvalidInputError
from sunset.evaluation.intervals import Cluster, Estimate, estimate
from sunset.evaluation.results import FIGURES, RunRow
from sunset.files.dataframes import data_frame
from sunset.texts.sentences import counted
from sunset.texts.tables import aligned
from sunset_ros.texts import suggestion

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """A figure of two managing systems, over the pairs in which both have it.

    Attributes:
        figure: one of `FIGURES`.
        first: the mean of the first; None without pairs.
        second: the mean of the second.
        difference: the estimate of first - second.
        one_sided: the number of other pairs, in which only one of the two has the figure.
    """

    figure: str
    first: float | None
    second: float | None
    difference: Estimate | None
    one_sided: int = 0

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
    """Two managing systems, figure by figure.

    Attributes:
        pairs: the number of pairs of valid runs.
        left_out: the number of valid runs without a valid counterpart.
    """

    first: str
    second: str
    pairs: int
    left_out: int
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
