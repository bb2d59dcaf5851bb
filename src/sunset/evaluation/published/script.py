"""The figures of a log, by the published evaluation script and by SUNSET's definitions."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import isnan
from typing import Final

import numpy as np

from sunset.metrics import downtime
from sunset.system import DURATION_S, PERIOD_S

OWN_FIGURES: Final = ("t_down_s", "iou", "iou_all")
"""SUNSET's figures that can be computed from a log."""

EVALUATOR: Final = "/evaluator_log"
EXECUTOR: Final = "scenario_executor"
ANALYZER: Final = "analyzer"
PLANNING: Final = "planning"

EXECUTED: Final = 1
SUCCEEDED: Final = 3
FAILED: Final = 4
RESOLVED: Final = 5
"""The status of a strategy, in rows of the planning and the analyzer."""

_LONGEST_GAP_NS: Final = 200_000_000
_DROPPED_ROWS: Final = 4
_ROWS_AFTER_LAST_EVENT: Final = 10
_LEAST_FRAMES: Final = 10
_WALL_NS: Final = 10**18  # an experiment's clock needs 31 years for this
_REDEPLOY_ONLY: Final = frozenset({"hardware_disconnect", "memory_leakage", "gpu_failure"})


@dataclass(frozen=True, slots=True)
class LogRow:
    """A row of a log.

    Attributes:
        time_ns: on the experiment's clock.
        source: the writer: `EVALUATOR`, `EXECUTOR`, `ANALYZER`, `PLANNING`, or another, which is ignored.
        status: of the strategy, such as `EXECUTED`; 0 when a rule of the analyzer triggers.
        iou: of the evaluator's frame, NaN without labels.
    """

    time_ns: int
    source: str
    rule: str = ""
    strategy: str = ""
    status: int = 0
    iou: float = 0.0
    fault: str = ""

    @property
    def succeeds(self) -> bool:
        """Whether a rule succeeds."""
        return self.source == ANALYZER and self.status in {SUCCEEDED, RESOLVED}


@dataclass(frozen=True, slots=True)
class LogFigures:
    """The figures of a log.

    Attributes:
        refused: why the script counts only redeploys; empty if it counts everything.
        by_script: the values of each of the paper's five figures: of t_react for each success, of IoU for each frame,
            and at most a single value of the others.
        own: the value of each of `OWN_FIGURES` by SUNSET's definitions, if there is one.
    """

    refused: str
    by_script: Mapping[str, Sequence[float]]
    own: Mapping[str, Sequence[float]]


def log_figures(log: Sequence[LogRow]) -> LogFigures:
    """Return the figures of a log, whose rows are in order of time.

    The script ignores the last four rows, and rows more than ten after the last event, which is a row that is not a
    frame. SUNSET's definitions use the 20 s from the first injected fault on.
    """
    rows = list(log[:-_DROPPED_ROWS])
    events = [place for place, row in enumerate(rows) if row.source != EVALUATOR]
    rows = rows[: events[-1] + 1 + _ROWS_AFTER_LAST_EVENT] if events else rows
    redeploys = sum(row.source == PLANNING and "redeploy" in row.strategy for row in rows)
    needed = sum(row.source == EXECUTOR and row.fault in _REDEPLOY_ONLY for row in rows)
    reactions, repeated = _reactions(rows)
    idle = "" if any(row.source == ANALYZER for row in rows) else "no rule was triggered"
    refused = _problem(rows) or idle or repeated
    by_script: dict[str, Sequence[float]] = {"redeploys_unnecessary": (redeploys - needed,)}
    if not refused:
        by_script |= {"t_react_s": reactions, **_counted(rows)}
    return LogFigures(refused, by_script, {} if _problem(log) else _own_figures(log))


def _problem(log: Sequence[LogRow]) -> str:
    if sum(row.source == EVALUATOR for row in log) < _LEAST_FRAMES:
        return f"it has fewer than {_LEAST_FRAMES} frames"
    if not all(0 < row.time_ns < _WALL_NS for row in log):
        return "a time in it is 0 or of a wall clock"
    ascending = all(row.time_ns <= later.time_ns for row, later in pairwise(log))
    return "" if ascending else "its times do not ascend"


def _reactions(rows: Iterable[LogRow]) -> tuple[list[float], str]:
    """Return the times from triggers to successes [s], and why the script refuses the log; empty if it does not."""
    triggered: dict[str, int] = {}
    failed: set[str] = set()
    reactions = []
    problem = ""
    for row in rows:
        if row.source == ANALYZER and not row.strategy:
            if row.rule in triggered and row.rule not in failed:
                problem = problem or f"the rule {row.rule} is triggered again before its outcome"
            triggered[row.rule] = row.time_ns
            failed.discard(row.rule)
        elif row.succeeds and row.rule in triggered:
            reactions.append((row.time_ns - triggered.pop(row.rule)) / 1e9)
        elif row.source == ANALYZER and row.status == FAILED:
            failed.add(row.rule)
    return reactions, problem


def _counted(rows: Sequence[LogRow]) -> dict[str, Sequence[float]]:
    executed = sum(row.source == PLANNING and row.status == EXECUTED for row in rows)
    frames = [row for row in rows if row.source == EVALUATOR]
    gaps_ns = [later.time_ns - row.time_ns for row, later in pairwise(frames)]
    return {
        "f_resolved_per_adaptation": [sum(row.succeeds for row in rows) / executed] if executed else [],
        "t_down_s": [sum(gap for gap in gaps_ns if gap > _LONGEST_GAP_NS) / 1e9],
        "iou": [row.iou for row in frames if not isnan(row.iou)],
    }


def _own_figures(log: Sequence[LogRow]) -> dict[str, Sequence[float]]:
    start_ns = next((row.time_ns for row in log if row.source == EXECUTOR), None)
    if start_ns is None:
        return {}
    seconds = np.array([(row.time_ns - start_ns) / 1e9 for row in log if row.source == EVALUATOR])
    is_measured = (seconds >= 0) & (seconds < DURATION_S)
    ious = np.array([row.iou for row in log if row.source == EVALUATOR])[is_measured]
    return {
        "t_down_s": [downtime(seconds, period_s=PERIOD_S, duration_s=DURATION_S)],
        "iou": [float(ious.mean())] if ious.size else [],
        "iou_all": [float(ious.sum()) * PERIOD_S / DURATION_S],
    }
