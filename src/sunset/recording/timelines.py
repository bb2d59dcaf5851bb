"""From recorded messages to the timeline that the metrics look at."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt

from sunset.errors import RecordError
from sunset.interfaces import Message, type_name
from sunset.interfaces.diagnostic_msgs.msg import DiagnosticArray
from sunset.interfaces.lifecycle_msgs.msg import TransitionEvent
from sunset.interfaces.parameters import scalar_of
from sunset.interfaces.rcl_interfaces.msg import ParameterEvent
from sunset.interfaces.stamps import ns_of
from sunset.interfaces.system_interfaces import msg
from sunset.metrics import (
    NUMBER_OF_CLASSES,
    Command,
    Diagnosis,
    Frames,
    Injection,
    Samples,
    Setting,
    Timeline,
)
from sunset.names import ros_text
from sunset.recording.values import RecordedMessage
from sunset.system import (
    COMMANDS_TOPIC,
    DIAGNOSIS_TOPIC,
    DIAGNOSTICS_TOPIC,
    DURATION_S,
    EVALUATION_TOPIC,
    EXPERIMENT,
    FAULT_ENDS_TOPIC,
    INJECTIONS_TOPIC,
    LOG_TOPIC,
    PARAMETER_TOPICS,
    PERIOD_S,
    RESULT_TOPIC,
    STATE,
    TRUTH_TOPIC,
    current_system,
    full_name,
)

_OTHERS: Final = (
    COMMANDS_TOPIC,
    DIAGNOSIS_TOPIC,
    DIAGNOSTICS_TOPIC,
    EVALUATION_TOPIC,
    FAULT_ENDS_TOPIC,
    INJECTIONS_TOPIC,
    LOG_TOPIC,
    *PARAMETER_TOPICS,
    TRUTH_TOPIC,
)
_TRANSITIONS: Final = "/transition_event"
"""How the topics end on which managed nodes say what their lifecycle states are."""

_ENDING: Final = ("redeploy", "shutdown")  # commands that end a process, so that nothing of it is left

_M = TypeVar("_M", bound=Message)


def measured_topics() -> frozenset[str]:
    """Return the full names of the topics that a timeline is made of; messages on others do not matter."""
    return frozenset({*_topics_of_messages(), *_topics_of_states(), *_OTHERS})


def _topics_of_messages() -> set[str]:
    """Return the topics of which only the times of messages matter."""
    failures = current_system().failures.values()
    return {RESULT_TOPIC, *(full_name(failure.topic) for failure in failures if failure.topic)}


def _topics_of_states() -> dict[str, str]:
    """Return the topic on which each managed node says what its lifecycle state is, with the node."""
    return {f"{node}{_TRANSITIONS}": node for node in current_system().managed_nodes}


def timeline(
    messages: Iterable[RecordedMessage],
    *,
    thresholds: Mapping[str, float],
    duration_s: float = DURATION_S,
    period_s: float = PERIOD_S,
    expected_frames: int = round(DURATION_S / PERIOD_S),
) -> Timeline:
    """Return what the metrics look at, from the messages of one experiment in order of time.

    Time 0 is what the experiment's log gives as its start, the moment at which faults are injected. A
    message's time is when it left its publisher, an injection's and a command's is their stamp. A frame's
    is when its true segmentation left the bag, so that it belongs to the moment at which the picture was
    taken, however late it was evaluated; where the record lacks that, when it was evaluated. Redeploys from before the
    first frame are left out: the system was being brought up, and they leave nothing behind.

    Args:
        messages: those on topics that are not among `measured_topics()` do not matter.
        thresholds: of signals, as `Timeline` has them.
        duration_s: how long the experiment is [s].
        period_s: the expected time between two frames [s].
        expected_frames: how many frames the experiment has.

    Raises:
        RecordError: the log lacks the start, or a message does not have the expected type or content.
    """
    topics: dict[str, list[RecordedMessage]] = {}
    for recorded in messages:
        topics.setdefault(recorded.topic, []).append(recorded)
    start_ns = start_of(topics.get(LOG_TOPIC, []))
    diagnostics = topics.get(DIAGNOSTICS_TOPIC, [])
    evaluated = _evaluated(topics.get(EVALUATION_TOPIC, []), topics.get(TRUTH_TOPIC, []), start_ns)
    return Timeline(
        duration_s=duration_s,
        period_s=period_s,
        message_times={
            topic: _times(recorded, start_ns)
            for topic, recorded in topics.items()
            if topic in _topics_of_messages()
        },
        samples={
            signal.name: _samples(diagnostics, signal.node, signal.key, start_ns)
            for signal in current_system().signals.values()
        },
        thresholds=thresholds,
        injections=_injections(topics.get(INJECTIONS_TOPIC, []), topics.get(FAULT_ENDS_TOPIC, []), start_ns),
        commands=_commands(topics.get(COMMANDS_TOPIC, []), topics.get(TRUTH_TOPIC, []), start_ns),
        settings=_settings(topics, start_ns),
        diagnoses=_diagnoses(topics.get(DIAGNOSIS_TOPIC, []), start_ns),
        frames=_frames([one for one in evaluated if one[1].truth.any()]),
        without_truth=np.array([time for time, one in evaluated if not one.truth.any()], dtype=np.float64),
        expected_frames=expected_frames,
    )


def content_of(recorded: RecordedMessage, kind: type[_M]) -> _M:
    """Return a recorded message, which must be of a type.

    Raises:
        RecordError: it is of another one.
    """
    if not isinstance(recorded.message, kind):
        raise RecordError(
            f"A message on {recorded.topic} must be a {type_name(kind)}, "
            f"got a {type_name(type(recorded.message))}."
        )
    return recorded.message


def _seconds(time_ns: int, start_ns: int) -> float:
    return (time_ns - start_ns) / 1e9


def _times(recorded: Sequence[RecordedMessage], start_ns: int) -> npt.NDArray[np.float64]:
    return np.array([_seconds(message.time_ns, start_ns) for message in recorded], dtype=np.float64)


def start_of(log: Sequence[RecordedMessage]) -> int:
    """Return the moment at which faults are injected, in nanoseconds, from the messages on `LOG_TOPIC`.

    Raises:
        RecordError: they lack it.
    """
    for recorded in log:
        entry = content_of(recorded, msg.ExperimentLogging)
        if (entry.source, entry.rule_name) == (EXPERIMENT, "start"):
            return entry.timestamp
    raise RecordError(f"The record does not say when the experiment began: no 'start' on {LOG_TOPIC}.")


def _samples(diagnostics: Sequence[RecordedMessage], node: str, key: str, start_ns: int) -> Samples:
    found = [
        (_seconds(recorded.time_ns, start_ns), _number(pair.value, node, key))
        for recorded in diagnostics
        for status in content_of(recorded, DiagnosticArray).status
        if status.hardware_id == node
        for pair in status.values
        if pair.key == key
    ]
    times, values = np.array(found, dtype=np.float64).reshape(len(found), 2).T.copy()
    return Samples(times, values)


def _number(text: str, node: str, key: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise RecordError(f"The {key} that {node} reports must be a number, got {text!r}.") from error


def _injections(
    recorded: Sequence[RecordedMessage], ends: Sequence[RecordedMessage], start_ns: int
) -> tuple[Injection, ...]:
    found = [content_of(message, msg.FaultInjection) for message in recorded]
    injections = [
        Injection(
            # live, the clock of the node that injects may be a tick behind that of the node that lets it
            time=max(0.0, _seconds(ns_of(injection.stamp), start_ns)),
            fault=injection.fault,
            failure=injection.failure,
            node=injection.node,
            internal=injection.internal,
            redeploy_only=injection.redeploy_only,
        )
        for injection in found
        if injection.confirmed
    ]
    injections.sort(key=lambda injection: injection.time)
    for recorded_end in ends:
        end = content_of(recorded_end, msg.FaultEnd)
        # nor may the clock of the node that says so be behind that by which the adaptation that ended it was seen
        time = max(0.0, _seconds(max(ns_of(end.stamp), recorded_end.time_ns), start_ns))
        # a fault is there once at a time, so that it is the last that came before
        began = [
            place
            for place, injection in enumerate(injections)
            if injection.fault == end.fault and injection.time <= time
        ]
        if not began:
            continue
        last = injections[began[-1]]
        if last.ended is None:
            injections[began[-1]] = replace(last, ended=time, cause=end.cause)
        elif last.healed is not None and end.cause:
            injections[began[-1]] = replace(last, cured_away=time)
    return tuple(injections)


def _commands(
    recorded: Sequence[RecordedMessage], truths: Sequence[RecordedMessage], start_ns: int
) -> tuple[Command, ...]:
    first_ns = truths[0].time_ns if truths else 0
    found = [content_of(message, msg.Command) for message in recorded]
    commands = [
        Command(
            time=_seconds(ns_of(command.stamp), start_ns),
            client=command.client,
            node=command.node,
            kind=command.kind,
            parameters=tuple(command.parameters),
            values=tuple(command.values),
            successful=command.successful,
        )
        for command in found
        if ns_of(command.stamp) >= first_ns or command.kind not in _ENDING
    ]
    return tuple(sorted(commands, key=lambda command: command.time))


def _settings(topics: Mapping[str, Sequence[RecordedMessage]], start_ns: int) -> tuple[Setting, ...]:
    found = []
    for recorded in chain.from_iterable(topics.get(topic, []) for topic in PARAMETER_TOPICS):
        event, time = content_of(recorded, ParameterEvent), _seconds(recorded.time_ns, start_ns)
        if event.node not in current_system().managed_nodes:
            continue
        for parameters, declared in ((event.new_parameters, True), (event.changed_parameters, False)):
            for parameter in parameters:
                value = scalar_of(parameter.value)
                if value is not None:
                    found.append(Setting(time, event.node, parameter.name, ros_text(value), declared))
    for topic, node in sorted(_topics_of_states().items()):
        for recorded in topics.get(topic, []):
            state = content_of(recorded, TransitionEvent).goal_state.label
            found.append(Setting(_seconds(recorded.time_ns, start_ns), node, STATE, state))
    return tuple(sorted(found, key=lambda setting: setting.time))


def _diagnoses(recorded: Sequence[RecordedMessage], start_ns: int) -> tuple[Diagnosis, ...]:
    """Return what was published on a managing system's own topic; what is not a diagnosis does not count."""
    return tuple(
        Diagnosis(
            _seconds(diagnosis.time_ns, start_ns),
            dict(zip(diagnosis.message.faults, map(float, diagnosis.message.probabilities), strict=False)),
        )
        for diagnosis in recorded
        if isinstance(diagnosis.message, msg.Diagnosis)
    )


def _evaluated(
    evaluations: Sequence[RecordedMessage], truths: Sequence[RecordedMessage], start_ns: int
) -> list[tuple[float, msg.FrameEvaluation]]:
    """Return when each picture was taken [s], with its evaluation, in order of time."""
    taken_ns = {ns_of(content_of(truth, msg.ImageDigest).header.stamp): truth.time_ns for truth in truths}
    found = []
    for recorded in evaluations:
        evaluation = content_of(recorded, msg.FrameEvaluation)
        for row in (evaluation.intersection, evaluation.predicted, evaluation.truth):
            if len(row) != NUMBER_OF_CLASSES:
                raise RecordError(f"A frame's counts must be of {NUMBER_OF_CLASSES} classes, got {len(row)}.")
        time_ns = taken_ns.get(ns_of(evaluation.header.stamp), recorded.time_ns)
        found.append((_seconds(time_ns, start_ns), evaluation))
    return sorted(found, key=lambda item: item[0])


def _frames(found: Sequence[tuple[float, msg.FrameEvaluation]]) -> Frames:
    return Frames(
        times=np.array([time for time, _ in found], dtype=np.float64),
        iou=np.array([evaluation.iou for _, evaluation in found], dtype=np.float64),
        intersection=_counts([evaluation.intersection for _, evaluation in found]),
        predicted=_counts([evaluation.predicted for _, evaluation in found]),
        truth=_counts([evaluation.truth for _, evaluation in found]),
    )


def _counts(rows: Sequence[npt.NDArray[np.uint32]]) -> npt.NDArray[np.int64]:
    return np.array(rows, dtype=np.int64).reshape(len(rows), NUMBER_OF_CLASSES)
