"""What the messages of a record say of how long something lasted: parameters' values, lifecycle states, faults."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from sunset.interfaces.lifecycle_msgs.msg import TransitionEvent
from sunset.interfaces.parameters import scalar_of
from sunset.interfaces.rcl_interfaces.msg import ParameterEvent, ParameterValue
from sunset.interfaces.stamps import ns_of
from sunset.interfaces.system_interfaces.msg import FaultInjection
from sunset.metrics import Injection
from sunset.names import ros_text
from sunset.recording import RecordedMessage
from sunset.recording.timelines import content_of
from sunset.system import (
    INJECTIONS_TOPIC,
    PARAMETER_TOPICS,
    Adaptation,
    FaultKind,
    current_system,
    full_name,
)
from sunset.viewing.document import Span, StateView


@dataclass(frozen=True, slots=True)
class _Setting:
    """A value that a parameter got; `declared` where a new process gave it its first one."""

    time: float
    value: str
    declared: bool


class States:
    """What holds from when to when in a run.

    Args:
        messages: all of the record, in order of time.
        start_ns: when faults were injected.
        span: the times that are looked at.

    Raises:
        RecordError: a message does not have the expected type.
    """

    def __init__(self, messages: Iterable[RecordedMessage], start_ns: int, span: Span) -> None:
        self._span = span
        self._start_ns = start_ns
        self._settings: dict[tuple[str, str], list[_Setting]] = {}
        self._transitions: dict[str, list[tuple[float, TransitionEvent]]] = {}
        self._injections: dict[str, list[FaultInjection]] = {}
        for message in messages:
            if message.topic in PARAMETER_TOPICS:
                self._note_parameters(self._seconds(message.time_ns), content_of(message, ParameterEvent))
            elif message.topic == INJECTIONS_TOPIC:
                injection = content_of(message, FaultInjection)
                self._injections.setdefault(injection.fault, []).append(injection)
            elif message.topic.endswith(_TRANSITIONS):
                node = message.topic.removesuffix(_TRANSITIONS)
                event = self._seconds(message.time_ns), content_of(message, TransitionEvent)
                self._transitions.setdefault(node, []).append(event)

    def _seconds(self, time_ns: int) -> float:
        return (time_ns - self._start_ns) / 1e9

    def _note_parameters(self, time: float, event: ParameterEvent) -> None:
        for parameters, declared in ((event.new_parameters, True), (event.changed_parameters, False)):
            for parameter in parameters:
                setting = _Setting(time, _text(parameter.value), declared)
                self._settings.setdefault((event.node, parameter.name), []).append(setting)

    def lifecycle(self, node: str) -> list[StateView]:
        """Return the lifecycle states of a managed node, one after the other; nothing of one that reports none."""
        events = self._transitions.get(full_name(node), [])
        start, end = self._span
        states: list[StateView] = []
        ends = [*(time for time, _ in events[1:]), end]
        for (since, event), until in zip(
            events, ends, strict=False
        ):  # without events, there is an end all the same
            first, last = max(since, start), min(until, end)
            state = event.goal_state.label
            if first >= last:
                continue
            if states and states[-1].state == state:
                first = states.pop().since
            states.append(StateView(first, last, state))
        return states

    def fault(self, injected: Injection) -> list[Span]:
        """Return when a fault was there after an injection.

        Where the record does not say when it ended, it was there until the parameter that injects it had its healthy
        value. What lives outside of nodes outlasts a redeploy, so that the first value of a new process does not end
        it.
        """
        onset = injected.time
        if injected.ended is not None:
            return self._spans([(onset, True), (injected.ended, False)])
        injection = [
            one for one in self._injections[injected.fault] if self._seconds(ns_of(one.stamp)) <= onset
        ][-1]  # a fault that comes and goes is injected anew each time
        settings = [
            setting
            for setting in self._settings.get((injection.node, injection.parameter), [])
            if setting.time >= self._seconds(ns_of(injection.stamp))
            and (injection.internal or not setting.declared)
        ]
        known = current_system().faults.get(injected.fault)  # that of a record may be of another version
        return self._spans(
            [
                (onset, True),
                *(
                    (max(setting.time, onset), setting.value != ros_text(known.healthy))
                    if known
                    else (max(setting.time, onset), setting.value == injection.value)
                    for setting in settings
                ),
            ]
        )

    def around(self, name: str, spans: Sequence[Span]) -> list[Span]:
        """Return when a cure was in place of a fault that it cannot end, since it lives in the world."""
        fault = current_system().faults.get(name)
        if fault is None or fault.kind is not FaultKind.EXTERNAL:
            return []
        found: list[Span] = []
        for cure in fault.cures:
            common = list(spans)
            for step in cure:
                common = _intersected(common, self._in_place(step))
            found += common
        return sorted(found)

    def _in_place(self, step: Adaptation) -> list[Span]:
        """Return when a step of a cure was in place."""
        goal = step.kind.goal_state
        if goal is not None:
            return [(state.since, state.until) for state in self.lifecycle(step.node) if state.state == goal]
        settings = self._settings.get((full_name(step.node), step.parameter), [])
        return self._spans([(setting.time, setting.value == ros_text(step.value)) for setting in settings])

    def _spans(self, changes: Sequence[tuple[float, bool]]) -> list[Span]:
        """Return the times from which something held to those at which it stopped, or to the end."""
        start, end = self._span
        spans: list[Span] = []
        since: float | None = None
        for time, holds in changes:
            if holds and since is None:
                since = time
            elif not holds and since is not None:
                spans.append((since, time))
                since = None
        if since is not None:
            spans.append((since, end))
        return [(max(first, start), min(last, end)) for first, last in spans if first < end and last > start]


_TRANSITIONS: Final = "/transition_event"


def _text(value: ParameterValue) -> str:
    """Return a parameter's value as ROS writes it; empty for a list, which no fault and no cure is."""
    scalar = scalar_of(value)
    return "" if scalar is None else ros_text(scalar)


def _intersected(one: Sequence[Span], other: Sequence[Span]) -> list[Span]:
    pairs = [(max(a[0], b[0]), min(a[1], b[1])) for a in one for b in other]
    return [(first, last) for first, last in pairs if first < last]
