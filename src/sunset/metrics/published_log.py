"""A log as the published exemplar's managing system writes one of itself, and what the paper's script makes of it.

The script takes other quantities than `score`, by the same names; `docs/metrics.md` has both.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum, IntEnum
from itertools import pairwise
from typing import Annotated, Final, Self

from msgspec import Meta

from sunset.metrics.limits import MOST, Amount, Count

SCRIPT_FIGURES: Final = (
    "f_resolved_per_adaptation",
    "t_react_s",
    "redeploys_unnecessary",
    "t_down_s",
    "iou",
)
"""What the script takes, by the names that the paper's table has in this package."""

_LONGEST_GAP_NS: Final = 200_000_000
_DROPPED_ROWS: Final = 4
_ROWS_AFTER_LAST_EVENT: Final = 10
_LEAST_FRAMES: Final = 10
_REDEPLOY_ONLY: Final = frozenset({"hardware_disconnect", "memory_leakage", "gpu_failure"})
WALL_NS: Final = 10**18
"""A time from here on is of a wall clock, which no experiment's clock reaches in 31 years."""


class LogSource(Enum):
    """Who writes a row, in the log's words."""

    EVALUATOR = "/evaluator_log"
    SCENARIO_EXECUTOR = "scenario_executor"
    ANALYZER = "analyzer"
    PLANNING = "planning"


class StrategyStatus(IntEnum):
    """What a row of the analyzer or of the planning says of a strategy; of a rule that triggers, `NOT_SET`."""

    NOT_SET = 0
    EXECUTED = 1
    SUCCEEDED = 3
    FAILED = 4
    """And the rule goes on."""
    RESOLVED = 5


@dataclass(frozen=True, slots=True)
class LogRow:
    """One row of a log.

    Attributes:
        time_ns: when, on the experiment's clock.
        source: who writes it; None of a row that no figure looks at.
        rule: of the analyzer, which rule triggers or has an outcome.
        strategy: of the planning, what is executed; of the analyzer, what the outcome is of.
        status: of that, one of `StrategyStatus`.
        iou: of the evaluator, the frame's IoU; NaN of one without truth.
        fault: of the scenario executor, the injected fault.
    """

    time_ns: int
    source: LogSource | None
    rule: str = ""
    strategy: str = ""
    status: int = StrategyStatus.NOT_SET
    iou: float = 0.0
    fault: str = ""

    @property
    def triggers(self) -> bool:
        """Whether a rule triggers."""
        return self.source is LogSource.ANALYZER and not self.strategy

    @property
    def succeeds(self) -> bool:
        """Whether a rule succeeds."""
        return self.source is LogSource.ANALYZER and self.status in {
            StrategyStatus.SUCCEEDED,
            StrategyStatus.RESOLVED,
        }

    @property
    def executes(self) -> bool:
        """Whether a strategy is executed."""
        return self.source is LogSource.PLANNING and self.status == StrategyStatus.EXECUTED

    @property
    def redeploys(self) -> bool:
        """Whether it is a redeploy, as the script tells one."""
        return self.source is LogSource.PLANNING and "redeploy" in self.strategy


@dataclass(frozen=True, slots=True)
class Pool:
    """Values that are averaged with those of other logs: how many, their sum, and the sum of their squares.

    >>> (Pool.of([1.0, 2.0]) + Pool.of([3.0])).mean
    2.0
    """

    number: Count = 0
    total: Amount = 0.0
    squares: Annotated[float, Meta(ge=0, le=MOST**2)] = 0.0

    @classmethod
    def of(cls, values: Iterable[float]) -> Self:
        """Return the pool of these values."""
        known = list(values)
        return cls(len(known), math.fsum(known), math.fsum(value * value for value in known))

    def __add__(self, other: "Pool") -> "Pool":
        """Return the pool of both pools' values."""
        return Pool(self.number + other.number, self.total + other.total, self.squares + other.squares)

    @property
    def mean(self) -> float:
        """Their mean; there must be one."""
        return self.total / self.number

    @property
    def deviation(self) -> float:
        """Their standard deviation, division by n; there must be one."""
        return math.sqrt(max(0.0, self.squares / self.number - self.mean**2))


@dataclass(frozen=True, slots=True, kw_only=True)
class LogFigures:
    """What the script takes from one log.

    Attributes:
        refused: why it counts only the redeploys of this log; empty if it counts all.
        executed: strategies that were executed.
        succeeded: rules that succeeded.
        reactions_s: from a rule's trigger to its success [s].
        redeploys: strategies that are redeploys.
        redeploys_unnecessary: those, less injected faults that only a redeploy cures, which can be more.
        t_down_s: sum of the gaps of more than 0.2 s between two frames [s].
        ious: each frame's IoU.
    """

    refused: str = ""
    executed: Count
    succeeded: Count
    reactions_s: Pool
    redeploys: Count
    redeploys_unnecessary: Annotated[int, Meta(ge=-MOST, le=MOST)]
    t_down_s: Amount
    ious: Pool


def log_figures(log: Sequence[LogRow]) -> LogFigures:
    """Return what the paper's script takes from a log whose rows are in order of time."""
    rows = _cut(log)
    frames = [row for row in rows if row.source is LogSource.EVALUATOR]
    gaps_ns = [later.time_ns - row.time_ns for row, later in pairwise(frames)]
    redeploys = sum(row.redeploys for row in rows)
    needed = sum(row.source is LogSource.SCENARIO_EXECUTOR and row.fault in _REDEPLOY_ONLY for row in rows)
    reactions, repeated = _reactions(rows)
    return LogFigures(
        refused=_refusal(rows, len(frames)) or repeated,
        executed=sum(row.executes for row in rows),
        succeeded=sum(row.succeeds for row in rows),
        reactions_s=Pool.of(reactions),
        redeploys=redeploys,
        redeploys_unnecessary=redeploys - needed,
        t_down_s=sum(gap for gap in gaps_ns if gap > _LONGEST_GAP_NS) / 1e9,
        ious=Pool.of(row.iou for row in frames if not math.isnan(row.iou)),
    )


def _cut(log: Sequence[LogRow]) -> list[LogRow]:
    """Return what is looked at of a log: little of what follows the last row that is not a frame."""
    rows = list(log[:-_DROPPED_ROWS])
    events = [place for place, row in enumerate(rows) if row.source is not LogSource.EVALUATOR]
    return rows[: events[-1] + 1 + _ROWS_AFTER_LAST_EVENT] if events else rows


def _refusal(rows: Sequence[LogRow], frames: int) -> str:
    """Return why the script refuses a log that was cut; empty if it does not."""
    if frames < _LEAST_FRAMES:
        return f"it has fewer than {_LEAST_FRAMES} frames"
    if not any(row.source is LogSource.ANALYZER for row in rows):
        return "no rule was triggered"
    if any(math.isnan(row.iou) for row in rows):
        return "a frame in it has no truth"
    if any(row.time_ns == 0 for row in rows):
        return "a time in it is 0"
    if any(row.time_ns >= WALL_NS for row in rows):
        return "a time in it is of a wall clock"
    return ""


def _reactions(rows: Sequence[LogRow]) -> tuple[list[float], str]:
    """Return the times from each rule's trigger to its success [s], and what is wrong with the triggers."""
    triggered: dict[str, int] = {}
    failed: set[str] = set()
    reactions = []
    problem = ""
    for row in rows:
        if row.triggers:
            if row.rule in triggered and row.rule not in failed:
                problem = problem or f"the rule {row.rule} is triggered again before its outcome"
            triggered[row.rule] = row.time_ns
            failed.discard(row.rule)
        elif row.succeeds and row.rule in triggered:
            reactions.append((row.time_ns - triggered.pop(row.rule)) / 1e9)
        elif row.source is LogSource.ANALYZER and row.status == StrategyStatus.FAILED:
            failed.add(row.rule)
    return reactions, problem
