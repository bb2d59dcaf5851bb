"""The runs below a folder, as what is asked of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from sunset.dataframes import data_frame
from sunset.evaluation import (
    PairedComparison,
    RunRow,
    ScoreTable,
    SystemRow,
    compare_managers,
    format_runs,
    run_fields,
    score_tables,
    summarise,
)

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True)
class Results:
    """The runs of a campaign, or of several.

    Attributes:
        folder: where they are.
        runs: one each, those that do not count included.
    """

    folder: Path
    runs: Sequence[RunRow]

    @cached_property
    def rows(self) -> list[SystemRow]:
        """The rows of the table: one a managing system and suite."""
        return summarise(self.runs)

    @cached_property
    def scores(self) -> list[ScoreTable]:
        """The scores, and how managing systems differ: a table a suite of which several were run."""
        return score_tables(self.runs)

    def table(self, form: str = "table", *, every: bool = False) -> str:
        """Return the report, as `sunset report` prints it.

        Args:
            form: `table`, `latex`, `csv`, `json` or `html`.
            every: whether a table or LaTeX has every figure, and not the first page only.

        Raises:
            InvalidInputError: there is no such format.
        """
        return format_runs(self.runs, form, every=every)

    def compare(self, first: str, second: str) -> PairedComparison:
        """Compare two managing systems in the runs that both have: the same scenario, seed, model and flight.

        Raises:
            InvalidInputError: there is no such managing system, both are the same, or they have no run in common.
        """
        return compare_managers(self.runs, first, second)

    def to_frame(self) -> "DataFrame":
        """Return one row a run, as a data frame of pandas, with the columns of `sunset report --runs`.

        Raises:
            MissingExtraError: pandas is not installed.
        """
        return data_frame(run_fields(run, self.folder) for run in self.runs)

    def __repr__(self) -> str:
        """Return how many runs of which managing systems there are, and where."""
        managers = ", ".join(dict.fromkeys(run.manager for run in self.runs))
        return f"<{len(self.runs)} runs of {managers} in {self.folder}>"
