"""From recorded messages to the timeline that the metrics are computed from, and to the log of the nodes."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt

from sunset.errors import RecordError
from sunset.metrics import (
    NUMBER_OF_CLASSES,
    Command,
    Cost,
    Diagnosis,
    Frames,
    Injection,
    Samples,
    Setting,
    Timeline,
)
from sunset.metrics.timeline import MOST
from sunset.recording._bag import RecordedMessage
from sunset.recording.schema import RunRecord
from sunset.system import (
    COMMANDS_TOPIC,
    COST_TOPIC,
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
from sunset_ros.interfaces.rcl_interfaces.msg import Log, ParameterEvent
from sunset_ros.interfaces.stamps import ns_of
from sunset_ros.parameter import scalar_of

_OTHERS: Final = (
    COMMANDS_TOPIC,
    COST_TOPIC,
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

ROSOUT: Final = "/rosout"
"""The topic on which nodes log."""

_SEVERITIES: Final = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "FATAL"}
"""The numbers of rcl_interfaces/msg/Log."""


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


@dataclass(frozen=True, slots=True)
class LogLine:
    """A line of a node's log.

    Attributes:
        time: in seconds from the injection; negative before it.
        logger: the node's full name with dots in place of slashes, such as `managed_subsystem.camera`.
    """

    time: float
    severity: str
    logger: str
    text: str

    def __str__(self) -> str:
        """Return the text, after the severity unless that is INFO."""
        return self.text if self.severity == "INFO" else f"{self.severity}: {self.text}"


class _Topics:
    """The messages of a run by topic, with times in seconds from the injection on."""

    def __init__(self, messages: Iterable[RecordedMessage]) -> None:
        self.messages: dict[str, list[RecordedMessage]] = {}
        for recorded in messages:
            self.messages.setdefault(recorded.topic, []).append(recorded)
        self._start_ns = start_of(self.messages.get(LOG_TOPIC, ()))

    def seconds(self, time_ns: int) -> float:
        """Return a time of the experiment's clock in seconds from the injection on."""
        return (time_ns - self._start_ns) / 1e9

    def times(self, topic: str) -> npt.NDArray[np.float64]:
        """Return the times of the messages on a topic."""
        return np.array([self.seconds(recorded.time_ns) for recorded in self.messages[topic]], np.float64)

    def of(self, topic: str, kind: type[_M]) -> list[tuple[float, _M]]:
        """Return the messages on a topic, each with its time.

        Raises:
            RecordError: a message is not of this type.
        """
        return [
            (self.seconds(recorded.time_ns), content_of(recorded, kind))
            for recorded in self.messages.get(topic, ())
        ]


def timeline_of(run: RunRecord, messages: Iterable[RecordedMessage]) -> Timeline:
    """Return the timeline of a run from its messages in order of time; topics outside of `measured_topics` are ignored.

    Time 0 is the injection. The time of a message is when it left its publisher; the time of injections and commands
    is their stamp, and the time of a frame is when its true segmentation left the bag, if it was recorded. Redeploys
    before the first frame belong to the bring-up, and are left out.

    Raises:
        RecordError: the log lacks the start, or a message has another type or invalid content.
    """
    topics = _Topics(messages)
    timed = _topics_of_messages()
    evaluated = _evaluated(topics)
    return Timeline(
        duration_s=run.duration_s,
        period_s=run.period_s,
        message_times={topic: topics.times(topic) for topic in topics.messages if topic in timed},
        samples={signal.name: _samples(topics, signal) for signal in current_system().signals.values()},
        thresholds=run.thresholds,
        injections=_injections(topics),
        commands=_commands(topics),
        settings=_settings(topics),
        diagnoses=_diagnoses(topics),
        costs=_costs(topics),
        frames=_frames([frame for frame in evaluated if frame[1].truth.any()]),
        without_truth=np.array(
            [time for time, frame in evaluated if not frame.truth.any()], dtype=np.float64
        ),
        expected_frames=run.expected_frames,
    )


def log_of(messages: Sequence[RecordedMessage]) -> tuple[LogLine, ...]:
    """Return the log of a run's nodes, in order of time.

    Raises:
        RecordError: the messages lack the start of the experiment.
    """
    topics = _Topics(messages)
    entries = [
        (topics.seconds(recorded.time_ns), recorded.message) for recorded in topics.messages.get(ROSOUT, ())
    ]
    return tuple(
        LogLine(time, _SEVERITIES.get(entry.level, str(entry.level)), entry.name, entry.msg)
        for time, entry in entries
        if isinstance(entry, Log)  # a managing system may publish anything there
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


def _samples(topics: _Topics, signal: Signal) -> Samples:
    pairs = [
        (time, _number(pair.value, signal))
        for time, diagnostics in topics.of(DIAGNOSTICS_TOPIC, DiagnosticArray)
        for status in diagnostics.status
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


def _injections(topics: _Topics) -> tuple[Injection, ...]:
    injections = [
        Injection(
            # live, the clocks of two nodes may differ by a tick
            time=max(0.0, topics.seconds(ns_of(injection.stamp))),
            fault=injection.fault,
            failure=injection.failure,
            node=injection.node,
            internal=injection.internal,
            redeploy_only=injection.redeploy_only,
        )
        for _, injection in topics.of(INJECTIONS_TOPIC, msg.FaultInjection)
        if injection.confirmed
    ]
    injections.sort(key=lambda injection: injection.time)
    for seen, end in topics.of(FAULT_ENDS_TOPIC, msg.FaultEnd):
        # live, the adaptation that ended the fault may have been seen after the stamp
        time = max(0.0, topics.seconds(ns_of(end.stamp)), seen)
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


def _commands(topics: _Topics) -> tuple[Command, ...]:
    truths = topics.messages.get(TRUTH_TOPIC)
    first_ns = truths[0].time_ns if truths else 0
    commands = [
        Command(
            time=topics.seconds(ns_of(command.stamp)),
            client=command.client,
            node=command.node,
            kind=command.kind,
            parameters=tuple(command.parameters),
            values=tuple(command.values),
            successful=command.successful,
        )
        for _, command in topics.of(COMMANDS_TOPIC, msg.Command)
        if ns_of(command.stamp) >= first_ns or command.kind not in _ENDING
    ]
    return tuple(sorted(commands, key=lambda command: command.time))


def _settings(topics: _Topics) -> tuple[Setting, ...]:
    settings = [
        Setting(time, event.node, parameter.name, ros_text(value), declared)
        for topic in PARAMETER_TOPICS
        for time, event in topics.of(topic, ParameterEvent)
        if event.node in current_system().managed_nodes
        for parameters, declared in ((event.new_parameters, True), (event.changed_parameters, False))
        for parameter in parameters
        if (value := scalar_of(parameter.value)) is not None
    ]
    settings += [
        Setting(time, node, STATE, transition.goal_state.label)
        for topic, node in sorted(_topics_of_states().items())
        for time, transition in topics.of(topic, TransitionEvent)
    ]
    return tuple(sorted(settings, key=lambda setting: setting.time))


def _diagnoses(topics: _Topics) -> tuple[Diagnosis, ...]:
    """Return the diagnoses on a managing system's own topic; messages of other types are ignored."""
    return tuple(
        Diagnosis(
            topics.seconds(recorded.time_ns),
            dict(zip(recorded.message.faults, map(float, recorded.message.probabilities), strict=False)),
        )
        for recorded in topics.messages.get(DIAGNOSIS_TOPIC, ())
        if isinstance(recorded.message, msg.Diagnosis)
    )


def _costs(topics: _Topics) -> tuple[Cost, ...]:
    """Return the costs on a managing system's own topic, wrong numbers as 0; messages of other types are ignored."""
    return tuple(
        Cost(
            topics.seconds(recorded.time_ns),
            cost.model,
            cost.tokens_in,
            cost.tokens_out,
            *(value if 0 <= value <= MOST else 0.0 for value in (cost.price, cost.think_s)),
        )
        for recorded in topics.messages.get(COST_TOPIC, ())
        if isinstance(cost := recorded.message, msg.Cost)
    )


def _evaluated(topics: _Topics) -> list[tuple[float, msg.FrameEvaluation]]:
    """Return the time of each frame [s], with its evaluation, in order of time."""
    taken = {ns_of(truth.header.stamp): time for time, truth in topics.of(TRUTH_TOPIC, msg.ImageDigest)}
    frames = [
        (taken.get(ns_of(evaluation.header.stamp), time), evaluation)
        for time, evaluation in topics.of(EVALUATION_TOPIC, msg.FrameEvaluation)
    ]
    return sorted(frames, key=lambda frame: frame[0])


def _frames(evaluated: Sequence[tuple[float, msg.FrameEvaluation]]) -> Frames:
    evaluations = [evaluation for _, evaluation in evaluated]
    counts = {
        name: np.array([getattr(evaluation, name) for evaluation in evaluations], np.int64)
        for name in ("intersection", "predicted", "truth")
    }
    return Frames(
        times=np.array([time for time, _ in evaluated], np.float64),
        iou=np.array([evaluation.iou for evaluation in evaluations], np.float64),
        **{name: rows.reshape(-1, NUMBER_OF_CLASSES) for name, rows in counts.items()},
    )
