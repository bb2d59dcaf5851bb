"""Figures that compare managing systems: differences, scores, profiles, and what adapting costs."""

from collections.abc import Iterator, Sequence
from math import ceil
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.evaluation.chart_runs import NO_RUN, Setup, uneven_notes
from sunset.evaluation.charts import Chart, Curve, Curves, Intervals, Mark, Point, Points
from sunset.evaluation.estimates import NO_INTERVAL, Estimate
from sunset.evaluation.results import RunRow
from sunset.evaluation.scores import NO_SCORE, score_rows
from sunset.evaluation.summary import estimate_figure
from sunset.recording import SCORE_REFERENCES
from sunset.texts import shorten

_LINES: Final = "lines are 95 % confidence intervals"
_SCORE_GUIDES: Final = ((0.0, "none"), (1.0, "oracle"))
_STEPS: Final = 200
"""Into how many steps a profile divides the measured time."""
_IOU_STEPS: Final = 100
"""Into how many steps a profile divides an IoU of 1."""
_LONGEST_PAIR: Final = 31
"""How many letters both names of a difference have at most."""
_NO_PAIR: Final = (
    "There is nothing to compare: no two managing systems have runs with the same scenario, flight and seed."
)


def differences_chart(found: Sequence[Setup]) -> Chart:
    """Return by how much a managing system is better than the next one; the data has every two."""
    panels, lines = [], []
    for setup in found:
        for table in setup.tables:
            pairs = [
                (setup.managers[difference.first], setup.managers[difference.second], difference)
                for difference in table.differences
            ]
            lines += [
                (
                    *(setup.label, table.suite, first, second, difference.pairs, *_ends(difference.utility)),
                    *(difference.pairs_won, difference.p, *_ends(difference.score)),
                )
                for first, second, difference in pairs
            ]
            marks = [
                _mark(_pair(first, second), first, difference.utility)
                for first, second, difference in pairs
                if difference.utility and difference in table.neighbours
            ]
            if marks:
                panels.append(
                    Intervals(
                        title=setup.title(setup.suite_title(table.suite)),
                        label="difference in utility",
                        marks=tuple(marks),
                        guides=((0.0, ""),),
                    )
                )
    return Chart(
        name="differences",
        title="Paired differences",
        meaning="By how much the utility of a managing system is above that of the next one by score, over the runs "
        "that both have: of the same scenario, flight and seed. "
        f"Marks are means, {_LINES}; one that does not reach 0 tells both apart.",
        panels=tuple(panels),
        missing=_interval_notes(panels) if panels else (_NO_PAIR,),
        head=(
            *("setup", "suite", "first", "second", "pairs", "utility_difference", "ci_low", "ci_high"),
            *("pairs_won", "p_holm", "score_difference", "score_ci_low", "score_ci_high"),
        ),
        lines=tuple(lines),
    )


def scores_chart(found: Sequence[Setup]) -> Chart:
    """Return the scores by suite and, where there are several, by flight."""
    panels, lines = [], []
    for setup in found:
        for suite, flight, title, scores in _scores(setup):
            marks = tuple(
                _mark(name, name, score) for name, score in scores if name not in SCORE_REFERENCES and score
            )
            if marks:
                panels.append(
                    Intervals(title=setup.title(title), label="score", marks=marks, guides=_SCORE_GUIDES)
                )
            lines += [
                (setup.label, suite, flight, name, score.runs, *_ends(score))
                for name, score in scores
                if score
            ]
    return Chart(
        name="scores",
        title="Score by suite and by flight",
        meaning="How much each managing system wins of what repairing can win: 0 is none, 1 is oracle, which is told "
        "the faults. Suites of which most runs have nothing to repair are left out; a flight's score is over the runs "
        f"of all suites. Marks are scores, {_LINES}.",
        panels=tuple(panels),
        missing=_interval_notes(panels) if panels else (NO_SCORE,),
        head=("setup", "suite", "flight", "system", "runs", "score", "ci_low", "ci_high"),
        lines=tuple(lines),
    )


def profiles_chart(found: Sequence[Setup]) -> Chart:
    """Return, by managing system, the share of runs with at most x downtime, or with more than x IoU_all."""
    panels, lines = [], []
    for setup in found:
        for figure, label in (("t_down_s", "t_down [s]"), ("iou_all", "IoU_all")):
            for suite, systems in setup.suites.items():
                values = {name: known for name, runs in systems.items() if (known := _values(runs, figure))}
                if figure == "iou_all":
                    steps = max(
                        1, ceil(_IOU_STEPS * max((max(known) for known in values.values()), default=1))
                    )
                    at, what = np.arange(steps + 1) / _IOU_STEPS, "runs with IoU_all > x"
                else:
                    at, what = np.linspace(0, setup.duration_s, _STEPS + 1), "runs with t_down ≤ x"
                curves = [
                    _profile(name, known, at, more=figure == "iou_all") for name, known in values.items()
                ]
                title = setup.title(setup.suite_title(suite))
                panels.append(
                    Curves(
                        title=title, label=label, share_label=what, end=float(at[-1]), curves=tuple(curves)
                    )
                )
                lines += [
                    (setup.label, suite, figure, curve.system, len(values[curve.system]), *step)
                    for curve in curves
                    for step in zip(curve.x, curve.shares, strict=True)
                ]
    return Chart(
        name="profiles",
        title="Performance profiles",
        meaning="Share of each managing system's runs that have a downtime of at most x, or an IoU_all of more than x. "
        "A higher curve is better.",
        panels=tuple(panels),
        missing=uneven_notes(found) if panels else (NO_RUN,),
        head=("setup", "suite", "figure", "system", "runs", "x", "share"),
        lines=tuple(lines),
    )


def costs_chart(found: Sequence[Setup]) -> Chart:
    """Return IoU_all against adaptations, with those that no other managing system beats in both."""
    panels, lines = [], []
    for setup in found:
        for suite, systems in setup.suites.items():
            pairs = {
                name: (estimate_figure(runs, "adaptations"), estimate_figure(runs, "iou_all"))
                for name, runs in systems.items()
            }
            panel = Points(
                title=setup.title(setup.suite_title(suite)),
                x_label="adaptations in a run",
                y_label="IoU_all",
                points=tuple(
                    Point(
                        system=name,
                        x=cost.mean,
                        y=gain.mean,
                        x_interval=_interval(cost),
                        y_interval=_interval(gain),
                    )
                    for name, (cost, gain) in pairs.items()
                    if cost and gain
                ),
            )
            panels.append(panel)
            for point in panel.points:
                cost, gain = pairs[point.system]
                line = (
                    setup.label,
                    suite,
                    point.system,
                    len(systems[point.system]),
                    *_ends(cost),
                    *_ends(gain),
                )
                lines.append((*line, point in panel.front))
    has_intervals = all(point.y_interval for panel in panels for point in panel.points)
    return Chart(
        name="costs",
        title="IoU_all against adaptations",
        meaning=f"What adapting costs, and what it wins. Marks are means, {_LINES}. The stepped line goes through "
        "those that no other one beats: there is more IoU_all for more adaptations only.",
        panels=tuple(panels),
        missing=(*([] if has_intervals else [NO_INTERVAL]), *uneven_notes(found)) if panels else (NO_RUN,),
        head=(
            *("setup", "suite", "system", "runs", "adaptations", "adaptations_ci_low", "adaptations_ci_high"),
            *("iou_all", "iou_all_ci_low", "iou_all_ci_high", "on_front"),
        ),
        lines=tuple(lines),
    )


def _scores(setup: Setup) -> Iterator[tuple[str, str, str, list[tuple[str, Estimate | None]]]]:
    """Give suite, flight and title of a panel, and the scores by managing system."""
    for table in setup.tables:
        rows = [(setup.managers[row.system], row.score) for row in table.rows if not row.is_calm]
        yield table.suite, "", setup.suite_title(table.suite), rows
    systems = setup.scored
    flights = sorted({run.flight for runs in systems.values() for run in runs})
    for flight in flights if len(flights) > 1 else []:
        parts = {name: [run for run in runs if run.flight == flight] for name, runs in systems.items()}
        on_flight = score_rows({name: runs for name, runs in parts.items() if runs})
        label = flight.name or flight.short_bag
        yield "", label, f"flight {label}", [(row.system, row.score) for row in on_flight]


def _pair(first: str, second: str) -> str:
    """Return what a difference is called, such that of long names something of both is left.

    >>> _pair("mine", "baseline")
    'mine − baseline'
    """
    names = (first, second)
    if len(first) + len(second) > _LONGEST_PAIR:
        names = (shorten(first, _LONGEST_PAIR // 2 - 1), shorten(second, _LONGEST_PAIR // 2 - 1))
    return " − ".join(names)


def _mark(label: str, system: str, found: Estimate) -> Mark:
    return Mark(label=label, system=system, value=found.mean, low=found.low, high=found.high)


def _ends(found: Estimate | None) -> tuple[float | None, float | None, float | None]:
    """Return a mean and the ends of its interval, as cells of a table."""
    return (found.mean, found.low, found.high) if found else (None, None, None)


def _interval(found: Estimate) -> tuple[float, float] | None:
    return None if found.low is None or found.high is None else (found.low, found.high)


def _interval_notes(panels: Sequence[Intervals]) -> tuple[str, ...]:
    lacks = any(mark.low is None for panel in panels for mark in panel.marks)
    return (NO_INTERVAL,) if lacks else ()


def _values(runs: Sequence[RunRow], figure: str) -> list[float]:
    return [value for run in runs if (value := run.metrics[figure]) is not None]


def _profile(system: str, values: Sequence[float], at: npt.NDArray[np.float64], *, more: bool) -> Curve:
    """Return which share of values is at most so much, or more than that; where it changes, and at both ends.

    >>> _profile("mine", [0.2, 0.2, 0.4, 0.4], np.arange(6) / 10, more=False)
    Curve(system='mine', x=[0.0, 0.2, 0.4, 0.5], shares=[0.0, 0.5, 1.0, 1.0], mean=None)
    """
    # what is the same number in a table is the same here
    up_to = np.searchsorted(np.sort(np.round(values, 9)), np.round(at, 9), side="right") / len(values)
    shares = 1 - up_to if more else up_to
    kept = np.flatnonzero(np.diff(shares, prepend=np.nan) != 0)
    kept = np.union1d(kept, [len(at) - 1])
    return Curve(system=system, x=at[kept].tolist(), shares=shares[kept].tolist())
