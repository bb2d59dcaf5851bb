"""From the record of a run to the log that the published exemplar would have written.

SUNSET's managing systems write no such log. Each of their adaptations is taken for an executed strategy, which answers
the rule of a current symptom. Each failure has a rule.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Final

import numpy as np

from sunset.evaluation.published.script import (
    ANALYZER,
    EVALUATOR,
    EXECUTED,
    EXECUTOR,
    PLANNING,
    SUCCEEDED,
    LogRow,
)
from sunset.metrics import (
    ExecutedAdaptation,
    Samples,
    Spell,
    Timeline,
    excesses,
    executed_adaptations,
    silences,
)
from sunset.recording import check_extensions, measured_topics, read_messages, read_run, timeline_of
from sunset.recording.timelines import start_of
from sunset.system import ENTROPY_SIGNAL, Failure, current_system, full_name
from sunset.system_interfaces.msg import FaultInjection, FrameEvaluation

_LOOK_S: Final = 0.2  # time between two looks at a symptom [s]
_NEWS_S: Final = 0.15
"""Greatest age of symptoms when a managing system acts [s]; the blackboard is published every 0.1 s."""
_TOLERANCE_S: Final = 1e-6


def log_of_run(folder: Path) -> list[LogRow]:
    """Return the log of a stored run, in order of time.

    Raises:
        RecordError: the record is damaged, or other extensions made it.
    """
    run = read_run(folder)
    check_extensions(run, folder)
    messages = read_messages(folder, measured_topics())
    start_ns = start_of(messages)
    rows = []
    for recorded in messages:
        match recorded.message:
            case FrameEvaluation(iou=iou):
                rows.append(LogRow(recorded.time_ns, EVALUATOR, iou=iou))
            case FaultInjection(fault=fault):
                rows.append(LogRow(recorded.time_ns, EXECUTOR, fault=fault))
    return sorted(rows + rule_rows(timeline_of(run, messages), start_ns), key=lambda row: row.time_ns)


@dataclass(frozen=True, slots=True)
class _Rule:
    """A rule, the nodes whose adaptation answers it (the failing node first), and when its symptom held."""

    name: str
    nodes: tuple[str, ...]
    is_silence: bool
    spells: Sequence[Spell]

    def holds_at(self, time_s: float) -> bool:
        return any(spell.holds <= time_s + _TOLERANCE_S < (spell.ended or inf) for spell in self.spells)


def rule_rows(timeline: Timeline, start_ns: int) -> list[LogRow]:
    """Return the rows of the analyzer and of the planning; `start_ns` is the injection on the experiment's clock.

    An adaptation triggers the rule that it answers, unless that is triggered already. The rule succeeds when a look,
    every 0.2 s, does not see its symptom.
    """
    rules = [_rule(failure, timeline) for failure in current_system().failures.values()]
    rows: list[LogRow] = []
    busy_until: dict[str, float] = {}

    def add(time_s: float, source: str, rule: str = "", strategy: str = "", status: int = 0) -> None:
        rows.append(LogRow(start_ns + round(time_s * 1e9), source, rule, strategy, status))

    for adaptation in executed_adaptations(timeline.commands, until_s=timeline.duration_s):
        time_s = adaptation.time
        strategy = "+".join(adaptation.parameters) or f"{adaptation.kind}_{adaptation.node}"
        rule = _answered(adaptation, rules)
        if rule is not None and busy_until.get(rule.name, -inf) <= time_s:
            add(time_s, ANALYZER, rule.name)
            looks = np.arange(time_s + _LOOK_S, timeline.duration_s + _TOLERANCE_S, _LOOK_S)
            gone_s = next((look for look in looks.tolist() if not rule.holds_at(look)), inf)
            busy_until[rule.name] = gone_s
            if gone_s < inf:
                add(gone_s, ANALYZER, rule.name, strategy, SUCCEEDED)
        add(time_s, PLANNING, "", strategy, EXECUTED)
    return rows


def _rule(failure: Failure, timeline: Timeline) -> _Rule:
    system, end_s = current_system(), timeline.duration_s
    node = system.failing_nodes[failure.name]
    if failure.topic:
        sent = timeline.message_times.get(full_name(failure.topic), np.empty(0))
        return _Rule(f"redeploy_{node}", (node,), True, silences(sent, duration_s=end_s))
    signal = system.signals[failure.signal]
    samples = timeline.samples.get(signal.name, Samples())
    spells = excesses(samples, signal, timeline.thresholds[signal.threshold_name], duration_s=end_s)
    name = "do_recalibration" if signal.name == ENTROPY_SIGNAL.name else signal.name
    return _Rule(name, (node, *system.upstream[node]), False, spells)


def _answered(adaptation: ExecutedAdaptation, rules: Sequence[_Rule]) -> _Rule | None:
    """Return the rule that an adaptation answers; None without a symptom.

    The symptom is a silence of the adapted node, or a signal of this node or of a node downstream. A call that sets
    parameters answers signals first, other adaptations answer silences first.
    """
    node, seen_s = adaptation.node, (adaptation.time, adaptation.time - _NEWS_S)
    able = [rule for rule in rules if node in rule.nodes and any(map(rule.holds_at, seen_s))]
    sets = bool(adaptation.parameters)
    return min(able, key=lambda rule: (rule.is_silence is sets, rule.nodes[0] != node), default=None)
