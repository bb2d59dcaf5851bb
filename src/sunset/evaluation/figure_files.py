"""The figures of a report in its page and as files."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Final

from sunset.errors import MissingExtraError
from sunset.evaluation.report_figures import report_figures
from sunset.evaluation.results import RunRow, load_results
from sunset.evaluation.scores import ScoreTable, score_tables
from sunset.files.outputs import draft_of_folder
from sunset.files.plots import NEEDS_MATPLOTLIB, can_draw
from sunset.processes.workers import Progress
from sunset.texts.sentences import counted
from sunset_ros.texts import printable

_SUFFIXES: Final = (".pdf", ".svg", ".png")


@dataclass(frozen=True, slots=True)
class WrittenFigures:
    """The figures of a report, in a folder.

    Attributes:
        folder: the folder.
        figures: their names; each has a file NAME.csv with its data.
        drawn: the names of figures with files NAME.pdf, NAME.svg and NAME.png.
        missing: sentences about parts that are not drawn.
    """

    folder: Path
    figures: tuple[str, ...]
    drawn: tuple[str, ...]
    missing: tuple[str, ...]

    def __str__(self) -> str:
        """Return a summary in sentences."""
        drawn = f"{len(self.drawn)} of {counted(len(self.figures), 'figure')} drawn"
        return "\n".join([f"{drawn}, and the data of all: {self.folder}.", *self.missing])


def figures_as_html(runs: Sequence[RunRow], tables: Sequence[ScoreTable]) -> str:
    """Return the figures of a report as a part of its page, each with its data."""
    lacking = "" if can_draw() else f"<p>{escape(NEEDS_MATPLOTLIB)}</p>"
    return "\n".join(
        ["<h2>Figures</h2>", lacking, *(each.as_html() for each in report_figures(runs, tables))]
    )


def write_figures(
    folder: Path, out: Path, *, recompute: bool = False, progress: Progress | None = None
) -> WrittenFigures:
    """Write the figures of a report, each as PDF, SVG, PNG and its data as CSV, and their captions as text.

    Args:
        folder: of a run, of a campaign, or of several campaigns.
        out: the new folder, which must not exist, or be empty.
        recompute: compute every number from the recorded messages instead of reading it.
        progress: called with (runs that are read, runs in all).

    Raises:
        MissingExtraError: matplotlib is not installed.
        RecordError: the folder is without runs, or a run is damaged.
        OutputError: the folder exists and is not empty, or cannot be written.
    """
    if not can_draw():
        raise MissingExtraError(NEEDS_MATPLOTLIB)
    runs = load_results(folder, again=recompute, progress=progress)
    figures = report_figures(runs, score_tables(runs))
    drawn = [figure for figure in figures if figure.picture]
    captions = [f"{each.name}: {each.title}. {' '.join((each.caption, *each.missing))}" for each in figures]
    with draft_of_folder(out, "folder of the figures") as draft:
        (draft / "captions.txt").write_text(printable("\n\n".join(captions)) + "\n", encoding="utf-8")
        for figure in figures:
            (draft / f"{figure.name}.csv").write_text(figure.as_csv(), encoding="utf-8")
        for figure in drawn:
            for suffix in _SUFFIXES:
                figure.save(draft / f"{figure.name}{suffix}")
    return WrittenFigures(
        out,
        tuple(figure.name for figure in figures),
        tuple(figure.name for figure in drawn),
        tuple(f"{figure.title}: {text}" for figure in figures for text in figure.missing),
    )
