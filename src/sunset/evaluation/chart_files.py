"""The figures of a report as files: for a paper, and their data."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from sunset.evaluation.chart_drawing import looks_of, save_chart
from sunset.evaluation.charts import Chart
from sunset.evaluation.report_charts import report_charts
from sunset.evaluation.results import load_results
from sunset.evaluation.scores import score_tables
from sunset.figures import NEEDS_MATPLOTLIB, can_draw
from sunset.output_files import draft_of_folder
from sunset.texts import counted
from sunset.workers import Progress

_SUFFIXES: Final = (".pdf", ".png")


@dataclass(frozen=True, slots=True)
class WrittenFigures:
    """The figures of a report, in a folder.

    Attributes:
        folder: where they are.
        figures: what they show; each has a file NAME.csv with its data.
        drawn: the names of those that have files NAME.pdf and NAME.png, too.
        missing: what is not shown and why, a sentence each.
    """

    folder: Path
    figures: tuple[str, ...]
    drawn: tuple[str, ...]
    missing: tuple[str, ...]

    def __str__(self) -> str:
        """Return what was written, in sentences."""
        drawn = f"{len(self.drawn)} of {counted(len(self.figures), 'figure')} drawn"
        wrote = f"{drawn}, and the data of all: {self.folder}."
        return "\n".join([wrote, *self.missing])


def write_figures(
    folder: Path, out: Path, *, recompute: bool = False, progress: Progress | None = None
) -> WrittenFigures:
    """Write the figures of a report, each as PDF, as PNG and its data as CSV; without matplotlib, the data only.

    Args:
        folder: of one run, of a campaign, or of several.
        out: the new folder, which must not exist, or be empty.
        recompute: compute every number from the recorded messages instead of reading the stored ones.
        progress: called with (runs that are read, runs in all).

    Raises:
        RecordError: there is no run, or one is damaged.
        OutputError: the folder exists and is not empty, or cannot be written.
    """
    runs = load_results(folder, again=recompute, progress=progress)
    charts = report_charts(runs, score_tables(runs))
    drawn = [chart for chart in charts if chart.panels and can_draw()]
    looks = looks_of(charts)
    with draft_of_folder(out, "folder of the figures") as draft:
        for chart in charts:
            (draft / f"{chart.name}.csv").write_text(chart.as_csv(), encoding="utf-8")
        for chart in drawn:
            for suffix in _SUFFIXES:
                save_chart(chart, looks, draft / f"{chart.name}{suffix}")
    return WrittenFigures(
        out,
        tuple(chart.name for chart in charts),
        tuple(chart.name for chart in drawn),
        (*([] if can_draw() else [NEEDS_MATPLOTLIB]), *_missing(charts)),
    )


def _missing(charts: Sequence[Chart]) -> list[str]:
    return [f"{chart.title}: {text}" for chart in charts for text in chart.missing]
