"""Stored runs: opened, reported and drawn."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Union

from sunset.api.arguments import Extensions, as_path, extended
from sunset.errors import RecordError
from sunset.evaluation import report_figures
from sunset.evaluation.agreement import AGREEMENT_FORMATS, format_agreement
from sunset.evaluation.differences import PairedComparison, compare_managers
from sunset.evaluation.report import (
    FORMATS,
    RUNS_FORMATS,
    format_runs,
    render_runs,
    run_fields,
)
from sunset.evaluation.report_figures import WrittenFigures
from sunset.evaluation.results import RunRow, load_results
from sunset.evaluation.scores import ScoreTable, score_tables
from sunset.evaluation.summary import SystemRow, summarise
from sunset.files.dataframes import data_frame
from sunset.processes.workers import Progress
from sunset.recording import count_runs, read_stored_run
from sunset.texts.names import RUN_FILE

if TYPE_CHECKING:
    from pandas import DataFrame

    from sunset.api.viewing import Run

__all__ = [
    "AGREEMENT_FORMATS",
    "FORMATS",
    "RUNS_FORMATS",
    "Results",
    "format_agreement",
    "is_run",
    "load",
    "print_story",
    "report",
    "unfinished_remark",
    "write_figures",
]


@dataclass(frozen=True)
class Results:
    """The runs of a campaign, or of several.

    Attributes:
        folder: where they are.
        runs: a row for each run, including invalid runs.
    """

    folder: Path
    runs: Sequence[RunRow]

    @cached_property
    def rows(self) -> list[SystemRow]:
        """The rows of the table, by managing system and suite."""
        return summarise(self.runs)

    @cached_property
    def scores(self) -> list[ScoreTable]:
        """The scores, and the differences between managing systems: a table for each suite with several of them."""
        return score_tables(self.runs)

    @property
    def failing_managers(self) -> dict[str, str]:
        """The managing systems that failed in each of their runs: name → the first failure."""
        failures: dict[str, list[str]] = {}
        for run in self.runs:
            failures.setdefault(run.manager, []).append(run.failed)
        return {name: reasons[0] for name, reasons in failures.items() if all(reasons)}

    def table(self, form: str = "table", *, every: bool = False) -> str:
        """Return the report, as `sunset report` prints it.

        Args:
            form: `table`, `latex`, `csv`, `json` or `html`.
            every: whether a table or LaTeX has every figure, and not the first page only.

        Raises:
            InvalidInputError: the format is unknown.
        """
        return format_runs(self.runs, form, every=every)

    def compare(self, first: str, second: str) -> PairedComparison:
        """Compare two managing systems in the runs that both have: the same scenario, seed, model and flight.

        Raises:
            InvalidInputError: a managing system is unknown, both are the same, or they lack a common run.
        """
        return compare_managers(self.runs, first, second)

    def to_frame(self) -> "DataFrame":
        """Return a data frame of pandas with a row for each run, with the columns of `sunset report --runs`.

        Raises:
            MissingExtraError: pandas is not installed.
        """
        return data_frame(run_fields(run, self.folder) for run in self.runs)

    def __repr__(self) -> str:
        """Return the number of runs, their managing systems and their folder."""
        managers = ", ".join(dict.fromkeys(run.manager for run in self.runs))
        return f"<{len(self.runs)} runs of {managers} in {self.folder}>"


def is_run(folder: Path) -> bool:
    """Return whether a folder is the record of a single run."""
    return (folder / RUN_FILE).is_file()


def print_story(folder: Path) -> None:
    """Print the time line of a single run, in colour on a terminal."""
    read_stored_run(folder).print_story()


def load(path: str | Path, *, recompute: bool = False, extensions: Extensions = ()) -> Union["Run", Results]:
    """Open stored runs: of the folder of a single run, that run; of a folder with several, their results.

    Args:
        path: the folder that `run` or `bench`, or the command line, has written.
        recompute: compute the figures of several runs from the recorded messages instead of reading stored figures.
        extensions: extensions that the runs were made with, where figures are computed.

    Raises:
        RecordError: the folder or its runs are missing, damaged or of another version.
    """
    folder = as_path(path, "folder of stored runs")
    with extended(extensions):
        if folder.is_file() or is_run(folder):
            from sunset.api.viewing import Run  # noqa: PLC0415  slow, and not needed for reports

            return Run.of(read_stored_run(folder), extensions=extensions)
        return Results(folder, load_results(folder, again=recompute))


def report(
    path: str | Path,
    form: str | None = None,
    *,
    every: bool = False,
    recompute: bool = False,
    paper: bool = False,
    runs: bool = False,
    progress: Progress | None = None,
    extensions: Extensions = (),
) -> str:
    """Return the report of stored runs, as `sunset report` prints it.

    Args:
        path: as in `load`; with `paper`, also a log of the published exemplar, or a folder of logs.
        form: `table`, `latex`, `csv`, `json` or `html`; of `runs`, `csv` or `json`. If it is None, the first of them,
            but the time line for the folder of a single run.
        every: whether a table or LaTeX has every figure, and not the first page only.
        recompute: as in `load`; of a table.
        paper: whether to return the paper's five figures by the published evaluation script instead, as `table`,
            `latex`, `html` or `json`.
        runs: whether to return a row for each run instead.
        progress: called with (runs that are read, all runs).
        extensions: as in `load`.

    Raises:
        RecordError: as `load`.
        InvalidInputError: the format is unknown.
    """
    folder = as_path(path, "folder of stored runs")
    with extended(extensions):
        if paper:
            from sunset.evaluation.published import paper_report  # noqa: PLC0415  slow, and rarely needed

            return paper_report(folder, form or FORMATS[0], progress=progress)
        if runs:
            return render_runs(folder, form or RUNS_FORMATS[0], recompute=recompute, progress=progress)
        if form is None and not (every or recompute) and is_run(folder):
            return f"{read_stored_run(folder)}\n"
        rows = load_results(folder, again=recompute, progress=progress)
        return format_runs(rows, form or FORMATS[0], every=every)


def unfinished_remark(folder: Path) -> str:
    """Return a sentence that says how much of a folder's campaign is missing; empty if nothing is."""
    try:
        counts = count_runs(folder)
    except RecordError as error:
        return f"The campaign in {folder} may not be finished, since its plan cannot be read: {error}"
    if counts is None or counts[0] >= counts[1]:
        return ""
    return f"The campaign in {folder} is not finished: {counts[0]} of {counts[1]} runs are there."


def write_figures(
    path: str | Path,
    out: str | Path,
    *,
    recompute: bool = False,
    progress: Progress | None = None,
    extensions: Extensions = (),
) -> WrittenFigures:
    """Write the figures of a report of stored runs, as `sunset report --figures` does.

    Each is written as PDF, SVG and PNG, and its data as CSV; `captions.txt` has their captions.

    Args:
        path: as in `load`.
        out: the new folder, which must not exist, or be empty.
        recompute: compute every number from the recorded messages instead of reading stored figures.
        progress: called with (runs that are read, all runs).
        extensions: as in `load`.

    Raises:
        MissingExtraError: matplotlib is not installed.
        RecordError: the runs are missing or damaged.
        OutputError: the folder exists and is not empty, or cannot be written.
    """
    with extended(extensions):
        return report_figures.write_figures(
            as_path(path, "folder of stored runs"),
            as_path(out, "folder of the figures"),
            recompute=recompute,
            progress=progress,
        )
