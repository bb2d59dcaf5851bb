"""The figures of a report, with a function for each, in its page and as files."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from statistics import fmean
from textwrap import fill
from typing import TYPE_CHECKING, Final

import numpy as np

from sunset.errors import MissingExtraError
from sunset.evaluation.figure_frame import (
    GRID,
    PAPER,
    SOFT,
    ReportFigure,
    Style,
    add_legend,
    panels,
    report_drawing,
)
from sunset.evaluation.figure_runs import Fault, Setup, outcomes_of, scores_of, setup_of
from sunset.evaluation.formats import short_name
from sunset.evaluation.intervals import Estimate
from sunset.evaluation.results import RunRow, load_results
from sunset.evaluation.scores import LEAST_GAIN, ScoreTable, score_tables
from sunset.files.outputs import draft_of_folder
from sunset.files.plots import BLUE, NEEDS_MATPLOTLIB, can_draw
from sunset.metrics import FATES
from sunset.processes.workers import Progress
from sunset.recording import SCORE_REFERENCES
from sunset.texts.sentences import counted, listed
from sunset_ros.texts import printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_INTERVALS: Final = "Lines are 95 % confidence intervals, where there are enough runs for them."
_SUFFIXES: Final = (".pdf", ".svg", ".png")
_ROW_IN: Final = 0.15
_MOST_ROWS: Final = 54  # rows that fit the height of a page
_SINGLE_ROWS: Final = 32  # the most rows in a single column; more rows are drawn in two
_HEADING: Final = 40  # characters in a line of a heading
_NAME: Final = 11  # characters in a line of a narrow title
_FATE_COLOURS: Final = {"cured": BLUE, "masked": "#E69F00", "missed": PAPER}
"""From dark to light, so that they differ in grey, too."""

_Mark = tuple[str, str, Estimate]  # the label of a row, its managing system, and its figure
_Group = tuple[str, Sequence[_Mark]]  # a heading, and the rows below it


@dataclass(frozen=True, slots=True)
class WrittenFigures:
    """The figures of a report, in a folder."""

    folder: Path
    figures: tuple[str, ...]  # names; each has a file NAME.csv with its data
    drawn: tuple[str, ...]  # the names of figures with files NAME.pdf, NAME.svg and NAME.png
    missing: tuple[str, ...]  # sentences about parts that are not drawn

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

    The folder `out` must not exist, or be empty; other arguments are as in `load_results`.

    Raises:
        MissingExtraError: matplotlib is not installed.
        OutputError: the folder `out` exists and is not empty, or cannot be written.
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


def report_figures(runs: Sequence[RunRow], tables: Sequence[ScoreTable]) -> list[ReportFigure]:
    """Return the figures of a report, in their order; empty without matplotlib."""
    if not runs or not can_draw():
        return []
    setup = setup_of(runs, tables)
    with report_drawing():
        return [figure(setup) for figure in (_scores, _differences, _fates, _uncured)]


def _scores(setup: Setup) -> ReportFigure:
    groups, lines = [], []
    for suite, flight, title, scores in scores_of(setup):
        marks = [(name, name, score) for name, score in scores if score]
        lines += [(suite, flight, name, score.runs, *_cells(score)) for _, name, score in marks]
        groups.append((title, [mark for mark in marks if mark[1] not in SCORE_REFERENCES]))
    picture, missing = _rows(setup, groups, "score (0: none, 1: oracle)", (0, 1))
    rows = [row for suite in setup.suites if suite.table for row in suite.table.rows if not row.is_reference]
    lacking = (
        f"No suite has a score to draw: in most runs, oracle wins less than {LEAST_GAIN} over none."
        if any(row.is_calm for row in rows)
        else "A score needs runs of none, oracle and another managing system."
    )
    return ReportFigure(
        name="scores",
        title="Score by suite and by flight",
        caption="How much each managing system wins of what repairing can win: 0 is none, 1 is oracle. Suites with "
        f"little to repair are left out; a flight has the runs of all suites. {_INTERVALS} {setup.common}",
        head=("suite", "flight", "system", "runs", "score", "ci_low", "ci_high"),
        lines=lines,
        picture=picture,
        missing=missing if picture else [lacking],
    )


def _differences(setup: Setup) -> ReportFigure:
    groups, lines = [], []
    for suite in setup.suites:
        marks: list[_Mark] = []
        for pair in suite.table.differences if suite.table else ():
            first, second = (setup.managers[name] for name in (pair.first, pair.second))
            figures = (*_cells(pair.utility), pair.pairs_won, pair.p_holm, *_cells(pair.score))
            lines.append((suite.name, first, second, pair.pairs, *figures))
            if pair.utility and suite.table and pair in suite.table.neighbours:
                marks.append((f"{short_name(first, 14)} − {short_name(second, 14)}", first, pair.utility))
        groups.append((suite.title, marks))
    picture, missing = _rows(setup, groups, "difference in utility", (0,))
    lacking = "No two managing systems have runs of the same scenario, flight and seed."
    return ReportFigure(
        name="differences",
        title="Paired differences",
        caption="By how much the utility of a managing system is above that of the next one by score, in runs of the "
        f"same scenario, flight and seed. {_INTERVALS} An interval without 0 distinguishes the two. {setup.common}",
        head=(
            *("suite", "first", "second", "pairs", "utility_difference", "ci_low", "ci_high", "pairs_won"),
            *("p_holm", "score_difference", "score_ci_low", "score_ci_high"),
        ),
        lines=lines,
        picture=picture,
        missing=missing if picture else [lacking],
    )


def _fates(setup: Setup) -> ReportFigure:
    outcomes = outcomes_of(setup)
    counts = {key: Counter(outcome.fate for outcome in same) for key, same in outcomes.items()}
    return ReportFigure(
        name="fates",
        title="What became of each fault",
        caption="In which share of its occurrences each managing system cured a fault, masked its symptom for a "
        "while, or did neither; none, which does neither, is drawn only if it is alone. Runs of all suites. "
        f"{setup.common}",
        head=("failure", "fault", "system", "faults", *FATES),
        lines=[
            (*fault, name, fates.total(), *(fates[fate] for fate in FATES))
            for (fault, name), fates in sorted(counts.items())
        ],
        picture=_draw_fates(setup, counts) if counts else None,
        missing=setup.remarks if counts else ["No run says what became of a fault."],
    )


def _draw_fates(setup: Setup, counts: Mapping[tuple[Fault, str], Counter[str]]) -> "Figure":
    from matplotlib.patches import Patch  # noqa: PLC0415  an optional extra

    faults = sorted({fault for fault, _ in counts})
    names = [name for name in setup.systems if name != SCORE_REFERENCES[0]]  # none misses all of them
    names = names or list(setup.systems)
    titles = [fill(short_name(name), _NAME) for name in names]
    most = max(title.count("\n") for title in titles)
    picture, grid = panels(len(names), 6, 0.55 + 0.15 * (len(faults) + most))
    for axes, name, title in zip(grid, names, titles, strict=True):
        left, fates = np.zeros(len(faults)), [counts.get((fault, name), Counter()) for fault in faults]
        for fate in FATES:
            shares = np.array([each[fate] / (each.total() or 1) for each in fates])
            colour = _FATE_COLOURS[fate]
            axes.barh(range(len(faults)), shares, left=left, color=colour, edgecolor=SOFT, linewidth=0.4)
            left += shares
        axes.set(xlim=(0, 1), ylim=(len(faults) - 0.4, -0.6))
        axes.set_xticks([0, 0.5, 1], ["0", "50", "100 %"])
        axes.set_title(title)
        _label_faults(axes, faults)
    add_legend(picture, [Patch(label=fate, facecolor=_FATE_COLOURS[fate], edgecolor=SOFT) for fate in FATES])
    return picture


def _uncured(setup: Setup) -> ReportFigure:
    outcomes = outcomes_of(setup)
    means = {key: fmean(outcome.uncured_s for outcome in same) for key, same in outcomes.items()}
    names, faults = list(setup.systems), sorted({fault for fault, _ in means})
    picture = None
    if faults:
        from matplotlib.lines import Line2D  # noqa: PLC0415  an optional extra

        picture, (axes,) = panels(1, 1, max(1.2, 0.5 + max(0.2, 0.05 * len(names)) * len(faults)))
        for (fault, name), mean in means.items():
            # managing systems stand below one another, so that the same value of several can be seen
            offset = 0.7 * ((names.index(name) + 0.5) / len(names) - 0.5)
            axes.plot([mean], [faults.index(fault) + offset], **setup.looks[name].points)
        for row in range(len(faults)):
            axes.axhline(row + 0.5, color=GRID, linewidth=0.5)
        axes.set(xlabel="mean time without a cure [s]", ylim=(len(faults) - 0.5, -0.5))
        axes.set_xlim(left=min(0, axes.get_xlim()[0]))
        axes.grid(axis="x")
        _label_faults(axes, faults)
        looks = {short_name(name): setup.looks[name].points for name in names}
        add_legend(picture, [Line2D([], [], **points, label=name) for name, points in looks.items()])
    return ReportFigure(
        name="uncured",
        title="Time without a cure by fault",
        caption="How long a fault was there without a cure in place: means over its occurrences, in the runs of all "
        f"suites. {setup.common}",
        head=("failure", "fault", "system", "uncured_s"),
        lines=[(*fault, name, mean) for (fault, name), mean in sorted(means.items())],
        picture=picture,
        missing=setup.remarks if faults else ["No run says what became of a fault."],
    )


def _rows(
    setup: Setup, groups: Sequence[_Group], label: str, guides: Sequence[float]
) -> tuple["Figure | None", list[str]]:
    """Return a figure of rows with intervals over the same scale, or None without rows, and notes on missing rows."""
    groups = [(fill(printable(title), _HEADING), marks) for title, marks in groups if marks]
    if not groups:
        return None, []
    columns = _columns(groups)
    left_out = [title for column in columns[2:] for title, _ in column]
    rows = max(sum(map(_height, column)) for column in columns[:2])
    picture, grid = panels(len(columns[:2]), 2, 0.5 + _ROW_IN * rows, sharey=False)
    for axes, column in zip(grid, columns, strict=False):
        _draw_rows(axes, column, setup.looks)
        for guide in guides:
            axes.axvline(guide, color=SOFT, linewidth=0.8, linestyle=(0, (4, 2)), zorder=0)
        axes.set(xlabel=label, ylim=(rows - 0.4, -0.6))
        axes.tick_params(axis="y", length=0, labelleft=True)
        axes.spines["left"].set_visible(False)
        axes.grid(axis="x")
    return picture, [f"Not drawn, but in the data: {listed(left_out)}."] if left_out else []


def _height(group: _Group) -> int:
    title, marks = group
    return title.count("\n") + 1 + len(marks)


def _columns(groups: Sequence[_Group]) -> list[list[_Group]]:
    """Return the groups of each column."""
    heights = [_height(group) for group in groups]
    total = sum(heights)
    most = total if total <= _SINGLE_ROWS else min(_MOST_ROWS, (total + max(heights)) // 2)
    columns: list[list[_Group]] = [[]]
    for group in groups:
        if columns[-1] and sum(map(_height, (*columns[-1], group))) > most:
            columns.append([])
        columns[-1].append(group)
    return columns


def _draw_rows(axes: "Axes", column: Sequence[_Group], looks: Mapping[str, Style]) -> None:
    ticks: dict[int, str] = {}
    longest = max(len(short_name(name, 31)) for _, marks in column for name, _, _ in marks)
    place = 0
    for title, marks in column:
        axes.annotate(
            *(title, (0, place - 0.25), (-3.6 * longest, 0), axes.get_yaxis_transform(), "offset points"),
            va="top",
            weight="bold",
            in_layout=False,
        )
        place += title.count("\n") + 1
        for name, system, estimate in marks:
            if estimate.interval is not None:
                axes.plot(estimate.interval, [place, place], color=looks[system].colour, linewidth=1.4)
            axes.plot([estimate.mean], [place], **looks[system].points)
            ticks[place] = short_name(name, 31)
            place += 1
    axes.set_yticks(list(ticks), list(ticks.values()))


def _cells(estimate: Estimate | None) -> tuple[float | None, ...]:
    return (estimate.mean, estimate.low, estimate.high) if estimate else (None, None, None)


def _label_faults(axes: "Axes", faults: Sequence[Fault]) -> None:
    axes.set_yticks(
        range(len(faults)), [f"{fault.replace('_', ' ')} ({failure})" for failure, fault in faults]
    )
    axes.tick_params(axis="y", length=0)
