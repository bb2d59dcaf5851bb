"""From recorded messages to the timeline that the metrics are computed from."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt

from sunset.errors import RecordError
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
from sunset.recording.schema import RunRecord
from sunset.recording.values import RecordedMessage
from sunset.system import (
    COMMANDS_TOPIC,
    DIAGNOSIS_TOPIC,
    DIAGNOSTICS_TOPIC,
    EVALUATION_TOPIC,
    EXPERIMENT,
    FAULT_ENDS_TOPIC,
    INJECTIONS_TOPIC,
    LOG_TOPIC,
    PARAMETER_TOPICS,
    RESULT_TOPIC,
    STATE,
    TRUTH_TOPIC,
    Signal,
    current_system,
    full_name,
)
from sunset.system_interfaces import msg
from sunset.texts.names import ros_text
from sunset_ros.interfaces import Message, type_name
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray
from sunset_ros.interfaces.lifecycle_msgs.msg import TransitionEvent
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterEvent
from sunset_ros.interfaces.stamps import ns_of
from sunset_ros.parameter import scalar_of

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
"""The ending of the topics with the lifecycle states of managed nodes."""
_ENDING: Final = ("redeploy", "shutdown")  # commands that end a process with all its settings

_M = TypeVar("_M", bound=Message)


def measured_topics() -> frozenset[str]:
    """Return the full names of the topics that a timeline needs."""
    return frozenset({*_topics_of_messages(), *_topics_of_states(), *_OTHERS})


def _topics_of_messages() -> set[str]:
    """Return the topics whose messages' times matter, and not their content."""
    failures = current_system().failures.values()
    return {RESULT_TOPIC, *(full_name(failure.topic) for failure in failures if failure.topic)}


def _topics_of_states() -> dict[str, str]:
    """Return the managed node of each topic with lifecycle states."""
    return {f"{node}{_TRANSITIONS}": node for node in current_system().managed_nodes}


def timeline_of(run: RunRecord, messages: Iterable[RecordedMessage]) -> Timeline:
    """Return the timeline of a run from its messages in order of time; topics outside of `measured_topics` are ignored.

    Time 0 is the injection. The time of a message is when it left its publisher; the time of injections and commands
    is their stamp, and the time of a frame is when its true segmentation left the bag, if it was recorded. Redeploys
    before the first frame belong to the bring-up, and are left out.

    Raises:
        RecordError: the log lacks the start, or a message has another type or invalid content.
    """
    topics: dict[str, list[RecordedMessage]] = defaultdict(list)
    for recorded in messages:
        topics[recorded.topic].append(recorded)
    start_ns = start_of(topics[LOG_TOPIC])
    times = {
        topic: np.array([_seconds(recorded.time_ns, start_ns) for recorded in timed], dtype=np.float64)
        for topic, timed in topics.items()
        if topic in _topics_of_messages()
    }
    signals = current_system().signals.values()
    evaluated = _evaluated(topics[EVALUATION_TOPIC], topics[TRUTH_TOPIC], start_ns)
    return Timeline(
        duration_s=run.duration_s,
        period_s=run.period_s,
        message_times=times,
        samples={signal.name: _samples(topics[DIAGNOSTICS_TOPIC], signal, start_ns) for signal in signals},
        thresholds=run.thresholds,
        injections=_injections(topics[INJECTIONS_TOPIC], topics[FAULT_ENDS_TOPIC], start_ns),
        commands=_commands(topics[COMMANDS_TOPIC], topics[TRUTH_TOPIC], start_ns),
        settings=_settings(topics, start_ns),
        diagnoses=_diagnoses(topics[DIAGNOSIS_TOPIC], start_ns),
        frames=_frames([frame for frame in evaluated if frame[1].truth.any()]),
        without_truth=np.array(
            [time for time, frame in evaluated if not frame.truth.any()], dtype=np.float64
        ),
        expected_frames=run.expected_frames,
    )


def content_of(recorded: RecordedMessage, kind: type[_M]) -> _M:
    """Return the content of a recorded message.

    Raises:
        RecordError: the message is not of this type.
    """
    if not isinstance(recorded.message, kind):
        raise RecordError(
            f"A message on {recorded.topic} must be a {type_name(kind)}, "
            f"got a {type_name(type(recorded.message))}."
        )
    return recorded.message


def _seconds(time_ns: int, start_ns: int) -> float:
    return (time_ns - start_ns) / 1e9


def start_of(messages: Iterable[RecordedMessage]) -> int:
    """Return the time of the injection, in nanoseconds, from the messages of an experiment.

    Raises:
        RecordError: the experiment's log lacks it.
    """
    for recorded in messages:
        if recorded.topic == LOG_TOPIC:
            entry = content_of(recorded, msg.ExperimentLogging)
            if (entry.source, entry.rule_name) == (EXPERIMENT, "start"):
                return entry.timestamp
    raise RecordError(f"The record does not say when the experiment began: no 'start' on {LOG_TOPIC}.")


def _samples(diagnostics: Sequence[RecordedMessage], signal: Signal, start_ns: int) -> Samples:
    pairs = [
        (_seconds(recorded.time_ns, start_ns), _number(pair.value, signal))
        for recorded in diagnostics
        for status in content_of(recorded, DiagnosticArray).status
        if status.hardware_id == signal.node
        for pair in status.values
        if pair.key == signal.key
    ]
    times, values = np.array(pairs, dtype=np.float64).reshape(len(pairs), 2).T.copy()
    return Samples(times, values)


def _number(text: str, signal: Signal) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise RecordError(
            f"The {signal.key} that {signal.node} reports must be a number, got {text!r}."
        ) from error


def _injections(
    messages: Sequence[RecordedMessage], ends: Sequence[RecordedMessage], start_ns: int
) -> tuple[Injection, ...]:
    injections = [
        Injection(
            # live, the clocks of two nodes may differ by a tick
            time=max(0.0, _seconds(ns_of(injection.stamp), start_ns)),
            fault=injection.fault,
            failure=injection.failure,
            node=injection.node,
            internal=injection.internal,
            redeploy_only=injection.redeploy_only,
        )
        for injection in (content_of(recorded, msg.FaultInjection) for recorded in messages)
        if injection.confirmed
    ]
    injections.sort(key=lambda injection: injection.time)
    for recorded in ends:
        end = content_of(recorded, msg.FaultEnd)
        # live, the adaptation that ended the fault may have been seen after the stamp
        time = max(0.0, _seconds(max(ns_of(end.stamp), recorded.time_ns), start_ns))
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
    messages: Sequence[RecordedMessage], truths: Sequence[RecordedMessage], start_ns: int
) -> tuple[Command, ...]:
    first_ns = truths[0].time_ns if truths else 0
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
        for command in (content_of(recorded, msg.Command) for recorded in messages)
        if ns_of(command.stamp) >= first_ns or command.kind not in _ENDING
    ]
    return tuple(sorted(commands, key=lambda command: command.time))


def _settings(topics: Mapping[str, Sequence[RecordedMessage]], start_ns: int) -> tuple[Setting, ...]:
    settings = []
    for recorded in chain.from_iterable(topics.get(topic, []) for topic in PARAMETER_TOPICS):
        event, time = content_of(recorded, ParameterEvent), _seconds(recorded.time_ns, start_ns)
        if event.node not in current_system().managed_nodes:
            continue
        for parameters, declared in ((event.new_parameters, True), (event.changed_parameters, False)):
            for parameter in parameters:
                value = scalar_of(parameter.value)
                if value is not None:
                    settings.append(Setting(time, event.node, parameter.name, ros_text(value), declared))
    for topic, node in sorted(_topics_of_states().items()):
        for recorded in topics.get(topic, []):
            state = content_of(recorded, TransitionEvent).goal_state.label
            settings.append(Setting(_seconds(recorded.time_ns, start_ns), node, STATE, state))
    return tuple(sorted(settings, key=lambda setting: setting.time))


def _diagnoses(messages: Sequence[RecordedMessage], start_ns: int) -> tuple[Diagnosis, ...]:
    """Return the diagnoses on a managing system's own topic; messages of other types are ignored."""
    return tuple(
        Diagnosis(
            _seconds(recorded.time_ns, start_ns),
            dict(zip(recorded.message.faults, map(float, recorded.message.probabilities), strict=False)),
        )
        for recorded in messages
        if isinstance(recorded.message, msg.Diagnosis)
    )


def _evaluated(
    evaluations: Sequence[RecordedMessage], truths: Sequence[RecordedMessage], start_ns: int
) -> list[tuple[float, msg.FrameEvaluation]]:
    """Return the time of each frame [s], with its evaluation, in order of time."""
    taken_ns = {ns_of(content_of(truth, msg.ImageDigest).header.stamp): truth.time_ns for truth in truths}
    frames = []
    for recorded in evaluations:
        evaluation = content_of(recorded, msg.FrameEvaluation)
        for row in (evaluation.intersection, evaluation.predicted, evaluation.truth):
            if len(row) != NUMBER_OF_CLASSES:
                raise RecordError(f"A frame's counts must be of {NUMBER_OF_CLASSES} classes, got {len(row)}.")
        time_ns = taken_ns.get(ns_of(evaluation.header.stamp), recorded.time_ns)
        frames.append((_seconds(time_ns, start_ns), evaluation))
    return sorted(frames, key=lambda frame: frame[0])


def _frames(evaluated: Sequence[tuple[float, msg.FrameEvaluation]]) -> Frames:
    evaluations = [evaluation for _, evaluation in evaluated]
    return Frames(
        times=np.array([time for time, _ in evaluated], dtype=np.float64),
        iou=np.array([evaluation.iou for evaluation in evaluations], dtype=np.float64),
        intersection=_counts([evaluation.intersection for evaluation in evaluations]),
        predicted=_counts([evaluation.predicted for evaluation in evaluations]),
        truth=_counts([evaluation.truth for evaluation in evaluations]),
    )


def _counts(rows: Sequence[npt.NDArray[np.uint32]]) -> npt.NDArray[np.int64]:
    return np.array(rows, dtype=np.int64).reshape(len(rows), NUMBER_OF_CLASSES)
