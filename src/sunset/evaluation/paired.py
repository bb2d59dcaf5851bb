"""Two managing systems, compared in the runs that both have: the same scenario, flight, model and seed."""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import TYPE_CHECKING

from sunset.dataframes import data_frame
from sunset.errors import InvalidInputError
from sunset.evaluation.estimates import Estimate, estimate
from sunset.evaluation.intervals import Cluster
from sunset.evaluation.results import FIGURES, RunRow
from sunset.tables import aligned
from sunset.texts import counted, suggestion

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """One figure of two managing systems, over the pairs in which both have it.

    Attributes:
        figure: one of `FIGURES`.
        first: the mean of the first; None where there is no such pair.
        second: the mean of the second.
        difference: the estimate of first - second, over the pairs.
        one_sided: in how many more pairs only one of the two has the figure.
    """

    figure: str
    first: float | None
    second: float | None
    difference: Estimate | None
    one_sided: int = 0

    @property
    def pairs(self) -> int:
        """How many pairs there are."""
        return self.difference.runs if self.difference else 0


def difference(figure: str, rows: Sequence[tuple[Cluster, float | None, float | None]]) -> Difference:
    """Compare a figure of pairs of runs.

    Args:
        figure: its name.
        rows: of each pair, its cluster, and the figure of its two runs; None where one has none.
    """
    both = [(cluster, one, other) for cluster, one, other in rows if one is not None and other is not None]
    return Difference(
        figure=figure,
        first=fmean(one for _, one, _ in both) if both else None,
        second=fmean(other for _, _, other in both) if both else None,
        difference=estimate([one - other for _, one, other in both], [cluster for cluster, _, _ in both]),
        one_sided=sum((one is None) != (other is None) for _, one, other in rows),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PairedComparison:
    """Two managing systems, figure by figure.

    Attributes:
        pairs: how many runs both have that count.
        left_out: how many runs have no counterpart that counts.
    """

    first: str
    second: str
    pairs: int
    left_out: int
    differences: tuple[Difference, ...]

    def __getitem__(self, figure: str) -> Difference:
        """Return the difference in one figure.

        Raises:
            InvalidInputError: there is no such figure.
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

        rows = [("figure", self.first, self.second, "difference", "95 % interval", "pairs")]
        for one in self.differences:
            found = one.difference
            ends = "{} to {}".format(*map(shown, found.interval)) if found and found.interval else "N/A"
            mean = shown(found.mean if found else None)
            rows.append((one.figure, shown(one.first), shown(one.second), mean, ends, str(one.pairs)))
        left_out = f"\n\nLeft out: {counted(self.left_out, 'run')} without a counterpart that counts."
        return "\n".join(aligned(rows)) + (left_out if self.left_out else "")

    def to_frame(self) -> "DataFrame":
        """Return one row a figure, as a data frame of pandas.

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
    """Compare two managing systems, named as in the runs, in the runs that both have.

    Raises:
        InvalidInputError: there is no such managing system, both are the same, or they have no run in common.
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
            difference(name, [(one.cluster, one.metrics[name], other.metrics[name]) for one, other in pairs])
            for name in FIGURES
        ),
    )
