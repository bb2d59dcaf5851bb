"""The figures of a report: a function of matplotlib each."""

from collections import Counter
from collections.abc import Callable, Sequence
from statistics import fmean
from textwrap import fill
from typing import TYPE_CHECKING, Final

import numpy as np

from sunset.evaluation.estimates import Estimate, estimate
from sunset.evaluation.figure_frame import (
    GRID,
    SOFT,
    ReportFigure,
    add_legend,
    panels,
    report_drawing,
    short_name,
)
from sunset.evaluation.figure_runs import (
    Fault,
    Setup,
    Suite,
    outcomes_of,
    scores_of,
    setup_of,
    values,
)
from sunset.evaluation.results import RunRow
from sunset.evaluation.scores import LEAST_GAIN, ScoreTable
from sunset.evaluation.system_styles import PAPER, Style
from sunset.figures import BLUE, can_draw
from sunset.metrics import FATES
from sunset.recording import SCORE_REFERENCES
from sunset.texts import listed, printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_INTERVALS: Final = "Lines are 95 % confidence intervals, where there are enough runs for them."
_ROW_IN: Final = 0.15
_MOST_ROWS: Final = 54
"""How many rows fit the height of a page."""
_SINGLE_ROWS: Final = 32
"""How many rows are drawn in one column; more are drawn in two."""
_TITLE: Final = 28
_HEADING: Final = 40
_NAME: Final = 11
"""How many characters fit a line: of the title of a panel, of a heading in a column, and of a narrow title."""
_STEPS: Final = 100
"""Into how many steps a profile divides its axis."""
_PROFILED: Final = (
    ("t_down_s", "t_down [s]", "runs with t_down ≤ x"),
    ("iou_all", "IoU_all", "runs with IoU_all > x"),
)
_FATE_COLOURS: Final = {"cured": BLUE, "masked": "#E69F00", "missed": PAPER}
"""From dark to light, so that they differ in grey, too."""

_Mark = tuple[str, str, Estimate]
"""The label of a row, its managing system, and what is marked."""
_Group = tuple[str, Sequence[_Mark]]
"""A heading, and the rows below it."""


def report_figures(runs: Sequence[RunRow], tables: Sequence[ScoreTable]) -> list[ReportFigure]:
    """Return the figures of a report, in their order; none without matplotlib.

    Args:
        runs: all of them.
        tables: their scores.
    """
    if not runs or not can_draw():
        return []
    setup = setup_of(runs, tables)
    with report_drawing():
        return [figure(setup) for figure in (_scores, _differences, _profiles, _costs, _fates, _uncured)]


def _scores(setup: Setup) -> ReportFigure:
    groups, lines = [], []
    for suite, flight, title, scores in scores_of(setup):
        marks = [(name, name, score) for name, score in scores if score]
        lines += [(suite, flight, name, score.runs, *_cells(score)) for _, name, score in marks]
        groups.append((title, [mark for mark in marks if mark[1] not in SCORE_REFERENCES]))
    picture, missing = _rows(setup, groups, "score (0: none, 1: oracle)", (0, 1))
    return ReportFigure(
        name="scores",
        title="Score by suite and by flight",
        caption="How much each managing system wins of what repairing can win: 0 is none, 1 is oracle. Suites with "
        f"little to repair are left out; a flight has the runs of all suites. {_INTERVALS} {setup.common}",
        head=("suite", "flight", "system", "runs", "score", "ci_low", "ci_high"),
        lines=lines,
        picture=picture,
        missing=missing if picture else ["A score needs runs of none, oracle and another managing system."],
    )


def _differences(setup: Setup) -> ReportFigure:
    groups, lines = [], []
    for suite in setup.suites:
        marks: list[_Mark] = []
        for pair in suite.table.differences if suite.table else ():
            first, second = (setup.managers[name] for name in (pair.first, pair.second))
            found, won = pair.utility, pair.pairs_won
            lines.append(
                (suite.name, first, second, pair.pairs, *_cells(found), won, pair.p, *_cells(pair.score))
            )
            if found and suite.table and pair in suite.table.neighbours:
                marks.append((f"{short_name(first, 14)} − {short_name(second, 14)}", first, found))
        groups.append((suite.title, marks))
    picture, missing = _rows(setup, groups, "difference in utility", (0,))
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
        missing=missing
        if picture
        else ["No two managing systems have runs of the same scenario, flight and seed."],
    )


def _profiles(setup: Setup) -> ReportFigure:
    suites, missing = _shown(setup, 3, lambda suite: any(len(runs) > 1 for runs in suite.systems.values()))
    lines: list[tuple[object, ...]] = []
    picture, grid = panels(2 * len(suites), len(suites), 1.9, sharex="row") if suites else (None, [])
    for row, (figure, label, share_label) in enumerate(_PROFILED):
        most = max((max(values(runs, figure), default=0.0) for runs in setup.systems.values()), default=0.0)
        at = np.linspace(0, max(0.1, most * 1.02), _STEPS + 1)
        for suite in setup.suites:
            known = {name: found for name, runs in suite.systems.items() if (found := values(runs, figure))}
            for place, (name, found) in enumerate(known.items()):
                shares = np.searchsorted(np.sort(found), at + 1e-9, side="right") / len(found)
                shares = 1 - shares if figure == "iou_all" else shares
                changes = np.flatnonzero(np.diff(shares, prepend=np.nan) != 0)
                lines += [(suite.name, figure, name, len(found), at[step], shares[step]) for step in changes]
                if suite in suites:
                    axes = grid[row * len(suites) + suites.index(suite)]
                    # markers stand elsewhere on each curve, so that curves on one another can be seen
                    every = (int((place + 0.5) * 25 / len(known)), 25)
                    axes.plot(at, shares, drawstyle="steps-post", markevery=every, **setup.looks[name].curve)
        for axes, suite in zip(grid[row * len(suites) :][: len(suites)], suites, strict=True):
            axes.set(xlim=(0, at[-1]), ylim=(-0.02, 1.02), xlabel=label)
            axes.set_ylabel(share_label if suite == suites[0] else "")
            axes.set_yticks([0, 0.25, 0.5, 0.75, 1], ["0", "25 %", "50 %", "75 %", "100 %"])
            axes.set_title("" if row else fill(printable(suite.title), _TITLE))
            axes.grid()
    if picture:
        _add_systems(picture, setup, "curve")
    return ReportFigure(
        name="profiles",
        title="Performance profiles",
        caption="In which share of its runs a managing system has a downtime of at most x, or an IoU_all of more than "
        f"x. A higher curve is better. {setup.common}",
        head=("suite", "figure", "system", "runs", "x", "share"),
        lines=lines,
        picture=picture,
        missing=missing,
    )


def _costs(setup: Setup) -> ReportFigure:
    suites, missing = _shown(setup, 6, lambda suite: len(suite.systems) > 1)
    lines: list[tuple[object, ...]] = []
    picture, grid = panels(len(suites), 3, 2.2) if suites else (None, [])
    for suite in setup.suites:
        for name, runs in suite.systems.items():
            gain = estimate([run.metrics["iou_all"] for run in runs], [run.cluster for run in runs])
            cost = estimate([_cost(run) for run in runs], [run.cluster for run in runs])
            if gain is None or cost is None:
                continue
            lines.append((suite.name, name, gain.runs, *_cells(cost), *_cells(gain)))
            if suite in suites:
                axes, style = grid[suites.index(suite)], setup.looks[name]
                _draw_interval(axes, cost, gain.mean, style)
                if gain.low is not None and gain.high is not None:
                    axes.plot(
                        [cost.mean, cost.mean], [gain.low, gain.high], color=style.colour, linewidth=1.4
                    )
    for axes, suite in zip(grid, suites, strict=True):
        axes.set_title(fill(printable(suite.title), _TITLE))
    if picture:
        (left, right), (bottom, top) = grid[0].get_xlim(), grid[0].get_ylim()
        for axes in grid:
            for level in np.arange(-1, 1, 0.1):  # sloped lines in place of a grid
                axes.plot([left, right], [level + left, level + right], color=GRID, linewidth=0.5, zorder=0)
            axes.set(xlim=(left, right), ylim=(bottom, top), xlabel="cost of adaptations", ylabel="IoU_all")
            axes.label_outer()
        _add_systems(picture, setup, "points")
    return ReportFigure(
        name="costs",
        title="IoU_all against the cost of adaptations",
        caption="How much of IoU_all a managing system pays for its adaptations. What is left is its utility, which is "
        f"the same along each sloped line. {_INTERVALS} {setup.common}",
        head=(
            "suite",
            "system",
            "runs",
            "cost",
            "cost_ci_low",
            "cost_ci_high",
            "iou_all",
            "ci_low",
            "ci_high",
        ),
        lines=lines,
        picture=picture,
        missing=missing,
    )


def _fates(setup: Setup) -> ReportFigure:
    outcomes = outcomes_of(setup)
    names, faults = list(setup.systems), sorted({fault for fault, _ in outcomes})
    counts = {key: Counter(outcome.fate for outcome in found) for key, found in outcomes.items()}
    picture = None
    if faults:
        from matplotlib.patches import Patch  # noqa: PLC0415  an optional extra

        titles = [fill(short_name(name), _NAME) for name in names]
        most = max(title.count("\n") for title in titles)
        picture, grid = panels(len(names), 6, 0.55 + 0.15 * (len(faults) + most))
        for axes, name, title in zip(grid, names, titles, strict=True):
            left = np.zeros(len(faults))
            for fate in FATES:
                shares = np.array([_share(counts.get((fault, name)), fate) for fault in faults])
                axes.barh(
                    *(range(len(faults)), shares),
                    left=left,
                    color=_FATE_COLOURS[fate],
                    edgecolor=SOFT,
                    linewidth=0.4,
                )
                left += shares
            axes.set(xlim=(0, 1), ylim=(len(faults) - 0.4, -0.6))
            axes.set_xticks([0, 0.5, 1], ["0", "50", "100 %"])
            axes.set_title(title)
            _label_faults(axes, faults)
        add_legend(
            picture, [Patch(label=fate, facecolor=_FATE_COLOURS[fate], edgecolor=SOFT) for fate in FATES]
        )
    return ReportFigure(
        name="fates",
        title="What became of each fault",
        caption="In which share of its occurrences each managing system cured a fault, masked its symptom for a "
        f"while, or did neither. Runs of all suites. {setup.common}",
        head=("failure", "fault", "system", "faults", *FATES),
        lines=[
            (*fault, name, found.total(), *(found[fate] for fate in FATES))
            for (fault, name), found in sorted(counts.items())
        ],
        picture=picture,
        missing=setup.remarks if faults else ["No run says what became of a fault."],
    )


def _uncured(setup: Setup) -> ReportFigure:
    means = {key: fmean(one.uncured_s for one in found) for key, found in outcomes_of(setup).items()}
    names, faults = list(setup.systems), sorted({fault for fault, _ in means})
    picture = None
    if faults:
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
        _add_systems(picture, setup, "points")
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
    """Return a figure of rows with intervals over one scale, None if there are none, and what it leaves out."""
    groups = [(fill(printable(title), _HEADING), marks) for title, marks in groups if marks]
    if not groups:
        return None, []
    heights = {title: title.count("\n") + 1 + len(marks) for title, marks in groups}
    total = sum(heights.values())
    most = total if total <= _SINGLE_ROWS else min(_MOST_ROWS, (total + max(heights.values())) // 2)
    columns: list[list[_Group]] = [[]]
    for group in groups:
        if columns[-1] and sum(heights[title] for title, _ in (*columns[-1], group)) > most:
            columns.append([])
        columns[-1].append(group)
    left_out = [title for column in columns[2:] for title, _ in column]
    rows = max(sum(heights[title] for title, _ in column) for column in columns[:2])
    picture, grid = panels(len(columns[:2]), 2, 0.5 + _ROW_IN * rows, sharey=False)
    for axes, column in zip(grid, columns, strict=False):
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
            place += heights[title] - len(marks)
            for name, system, found in marks:
                _draw_interval(axes, found, place, setup.looks[system])
                ticks[place] = short_name(name, 31)
                place += 1
        for guide in guides:
            axes.axvline(guide, color=SOFT, linewidth=0.8, linestyle=(0, (4, 2)), zorder=0)
        axes.set_yticks(list(ticks), list(ticks.values()))
        axes.set(xlabel=label, ylim=(rows - 0.4, -0.6))
        axes.tick_params(axis="y", length=0, labelleft=True)
        axes.spines["left"].set_visible(False)
        axes.grid(axis="x")
    return picture, [f"Not drawn, but in the data: {listed(left_out)}."] if left_out else []


def _shown(setup: Setup, most: int, can_show: Callable[[Suite], bool]) -> tuple[list[Suite], list[str]]:
    """Return the suites that a figure draws, and sentences on the others."""
    shown = [suite for suite in setup.suites if can_show(suite) and not suite.is_flat][:most]
    others = [suite.title for suite in setup.suites if suite not in shown]
    why = f"for want of runs, of a difference of {LEAST_GAIN:g} in IoU_all, or of room"
    return shown, [
        *([f"Not drawn, but in the data, {why}: {listed(others)}."] if others else []),
        *setup.remarks,
    ]


def _share(counts: Counter[str] | None, fate: str) -> float:
    return counts[fate] / counts.total() if counts else 0.0


def _cost(run: RunRow) -> float | None:
    """Return what the adaptations of a run cost, as a part of IoU_all."""
    whole, left = run.metrics["iou_all"], run.metrics["utility"]
    return None if whole is None or left is None else whole - left


def _cells(found: Estimate | None) -> tuple[float | None, ...]:
    """Return a mean and the ends of its interval, as cells of a table."""
    return (found.mean, found.low, found.high) if found else (None, None, None)


def _draw_interval(axes: "Axes", found: Estimate, place: float, style: Style) -> None:
    if found.low is not None and found.high is not None:
        axes.plot([found.low, found.high], [place, place], color=style.colour, linewidth=1.4)
    axes.plot([found.mean], [place], **style.points)


def _label_faults(axes: "Axes", faults: Sequence[Fault]) -> None:
    axes.set_yticks(
        range(len(faults)), [f"{fault.replace('_', ' ')} ({failure})" for failure, fault in faults]
    )
    axes.tick_params(axis="y", length=0)


def _add_systems(figure: "Figure", setup: Setup, kind: str) -> None:
    """Put a legend of the managing systems below a figure; `kind` is an attribute of their styles."""
    from matplotlib.lines import Line2D  # noqa: PLC0415  an optional extra

    styles = setup.looks
    add_legend(
        figure,
        [Line2D([], [], **getattr(styles[name], kind), label=short_name(name)) for name in setup.systems],
    )
