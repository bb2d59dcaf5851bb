"""The rows that the published exemplar's analyzer and planning would have logged of a run observed from outside.

A managing system of SUNSET writes no such log. So every adaptation counts as a strategy that is executed. It answers
the rule whose symptom held then, and there is a rule for each failure.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self

import numpy as np

from sunset.metrics.adaptations import ExecutedAdaptation, affects, executed_adaptations
from sunset.metrics.downtime import TOLERANCE_S
from sunset.metrics.episodes import Spell, silent_spells, spells_beyond
from sunset.metrics.published_log import LogRow, LogSource, StrategyStatus
from sunset.metrics.timeline import Samples, Timeline
from sunset.system import ENTROPY_SIGNAL, Failure, current_system, full_name

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
        spells: over which the symptom held.
    """

    name: str
    failure: Failure
    spells: Sequence[Spell]

    @classmethod
    def of(cls, failure: Failure, timeline: Timeline) -> Self:
        system = current_system()
        if failure.topic:
            sent = timeline.message_times.get(full_name(failure.topic), np.empty(0)).tolist()
            name = f"redeploy_{system.failing_nodes[failure.name]}"
            spells = silent_spells([*sent, np.inf])
        else:
            name = _RECALIBRATION if failure.signal == ENTROPY_SIGNAL.name else failure.signal
            signal = system.signals[failure.signal]
            samples = timeline.samples.get(signal.name, Samples())
            spells = spells_beyond(samples, signal, timeline.thresholds[signal.threshold_name])
        return cls(name, failure, spells)

    def holds_at(self, time_s: float) -> bool:
        """Return whether the symptom holds at a time."""
        latest = time_s + TOLERANCE_S
        return any(
            spell.holds <= latest and (spell.ended is None or latest < spell.ended) for spell in self.spells
        )


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
