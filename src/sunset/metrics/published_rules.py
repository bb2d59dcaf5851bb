"""The rows that the published exemplar's analyzer and planning would have logged of a run observed from outside.

A managing system of SUNSET writes no such log. So every adaptation counts as a strategy that is executed. It answers
the rule whose symptom held then, and there is a rule for each failure.
"""

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Self

import numpy as np

from sunset.metrics.adaptations import ExecutedAdaptation, affects, executed_adaptations
from sunset.metrics.downtime import TOLERANCE_S
from sunset.metrics.published_log import LogRow, LogSource, StrategyStatus
from sunset.metrics.timeline import Samples, Timeline
from sunset.system import SILENCE_S, WINDOW, Failure, MovingMean, current_system, full_name

_LOOK_S: Final = 0.2
"""Time between two looks at a symptom [s]."""
_NEWS_S: Final = 0.15
"""Greatest age of what a managing system acts on [s]: the blackboard is published every 0.1 s."""
_RECALIBRATION: Final = "do_recalibration"


@dataclass(frozen=True, slots=True)
class _Rule:
    """A rule, and when its symptom held.

    Attributes:
        name: as the log has it.
        failure: the failure whose symptom it looks at.
        times: when the symptom began or stopped to hold [s], ascending; it does not hold before the first.
        holds: whether it holds from each of them on.
    """

    name: str
    failure: Failure
    times: Sequence[float]
    holds: Sequence[bool]

    @classmethod
    def of(cls, failure: Failure, timeline: Timeline) -> Self:
        system = current_system()
        if failure.topic:
            sent = timeline.message_times.get(full_name(failure.topic), np.empty(0)).tolist()
            name = f"redeploy_{system.failing_nodes[failure.name]}"
            changes = [
                change
                for last, following in pairwise([*sent, np.inf])
                if following - last > SILENCE_S + TOLERANCE_S
                for change in ((last + SILENCE_S, True), (following, False))
            ]
        else:
            name = _RECALIBRATION if failure.signal == "segmentation_entropy" else failure.signal
            changes = list(_verdicts(failure, timeline))
        return cls(name, failure, [time for time, _ in changes], [holds for _, holds in changes])

    def holds_at(self, time_s: float) -> bool:
        """Return whether the symptom holds at a time."""
        place = bisect_right(self.times, time_s + TOLERANCE_S)
        return place > 0 and self.holds[place - 1]


def _verdicts(failure: Failure, timeline: Timeline) -> Iterator[tuple[float, bool]]:
    """Give at each sample of a failure's signal whether the mean is beyond its threshold, once there is a mean."""
    signal = current_system().signals[failure.signal]
    threshold = timeline.thresholds[signal.threshold_name]
    samples = timeline.samples.get(signal.name, Samples())
    moving = MovingMean(WINDOW.gap_s + TOLERANCE_S)
    for time, value in zip(samples.times.tolist(), samples.values.tolist(), strict=True):
        mean = moving.add(time, value)
        if mean is not None:
            yield time, mean < threshold if signal.below else mean > threshold


def rule_rows(timeline: Timeline, start_ns: int) -> list[LogRow]:
    """Return the rows of the analyzer and of the planning, in order of time.

    A rule triggers with the adaptation that answers it, unless it is triggered already, and succeeds at the first look,
    every 0.2 s, at which its symptom does not hold.

    Args:
        timeline: what was observed.
        start_ns: the time on the experiment's clock that is 0 in the time line.
    """
    rules = [_Rule.of(failure, timeline) for failure in current_system().failures.values()]
    rows: list[LogRow] = []
    busy_until: dict[str, float] = {}

    def add(time_s: float, source: LogSource, rule: str, strategy: str, status: StrategyStatus) -> None:
        rows.append(LogRow(start_ns + round(time_s * 1e9), source, rule, strategy, status))

    for adaptation in executed_adaptations(timeline.commands, until_s=timeline.duration_s):
        time_s, strategy = adaptation.time, _strategy(adaptation)
        rule = _answered(adaptation, rules)
        if rule is not None and busy_until.get(rule.name, -np.inf) <= time_s:
            add(time_s, LogSource.ANALYZER, rule.name, "", StrategyStatus.NOT_SET)
            looks = np.arange(time_s + _LOOK_S, timeline.duration_s + TOLERANCE_S, _LOOK_S)
            gone_s = next((look for look in looks.tolist() if not rule.holds_at(look)), np.inf)
            busy_until[rule.name] = gone_s
            if gone_s < np.inf:
                add(gone_s, LogSource.ANALYZER, rule.name, strategy, StrategyStatus.SUCCEEDED)
        add(time_s, LogSource.PLANNING, "", strategy, StrategyStatus.EXECUTED)
    return sorted(rows, key=lambda row: row.time_ns)


def _strategy(adaptation: ExecutedAdaptation) -> str:
    """Return the name of an adaptation as a strategy, such as `redeploy_camera` or `do_recalibration`."""
    return "+".join(adaptation.parameters) or f"{adaptation.kind}_{adaptation.node}"


def _answered(adaptation: ExecutedAdaptation, rules: Sequence[_Rule]) -> _Rule | None:
    """Return the rule whose symptom held and which an adaptation answers; None if there is none.

    It answers the silence of its own node, or a signal of its node or of one downstream. What sets parameters answers
    signals first, and anything else silences.
    """
    failing = current_system().failing_nodes
    able = [
        rule
        for rule in rules
        if failing[rule.failure.name] == adaptation.node
        or (rule.failure.signal and affects(adaptation.node, rule.failure.name))
    ]
    able.sort(
        key=lambda rule: (
            bool(rule.failure.signal) is not bool(adaptation.parameters),
            failing[rule.failure.name] != adaptation.node,
        )
    )
    seen_s = (adaptation.time, adaptation.time - _NEWS_S)
    return next((rule for rule in able if any(map(rule.holds_at, seen_s))), None)
