"""The reward of an episode: the utility of its run so far, from the messages that a record would have."""

from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.experiments import Observer
from sunset.metrics import Frames, Timeline, faults_cured, utility
from sunset.recording import RecordedMessage, RunRecord, timeline_of
from sunset.recording.timelines import measured_topics
from sunset.system import (
    DIAGNOSTICS_TOPIC,
    EVALUATION_TOPIC,
    EXPERIMENT,
    LOG_TOPIC,
    RESULT_TOPIC,
    TRUTH_TOPIC,
    full_name,
)
from sunset.system_interfaces.msg import ExperimentLogging, FrameEvaluation
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.stamps import ns_of

PICTURES: Final = (full_name("rgb_camera"), RESULT_TOPIC)
"""What is rendered: colours, and labels."""


class Referee(Observer):
    """Sees the truth of an experiment, and computes its utility so far.

    Args:
        record: the description of the run.

    Attributes:
        pictures: topic → its last image, of those in `PICTURES` that had one.
    """

    def __init__(self, record: RunRecord) -> None:
        super().__init__(self)
        self._record = record
        self._wanted = measured_topics().difference({DIAGNOSTICS_TOPIC}).union(PICTURES)
        self.pictures: dict[str, Image] = {}
        self._events: list[RecordedMessage] = []
        self._began = False
        self._taken: dict[int, int] = {}  # stamp of a frame → when its truth left the bag
        self._frames: list[tuple[int, float]] = []  # when each frame was taken, and its IoU
        self._unknown: list[int] = []  # when each frame without a known class was taken
        self._timeline: Timeline | None = None

    def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
        """Note a message that the utility depends on."""
        if topic in self._wanted:
            super().on_message(time_ns, topic, node, message)

    def write(self, topic: str, time_ns: int, message: Message) -> None:
        """Keep a message, as a `Sink`."""
        if isinstance(message, Image):
            self.pictures[topic] = message
            if topic == TRUTH_TOPIC:
                self._taken[ns_of(message.header.stamp)] = time_ns
        elif topic == EVALUATION_TOPIC and isinstance(message, FrameEvaluation):
            taken_ns = self._taken.get(ns_of(message.header.stamp), time_ns)
            if message.truth.any():
                self._frames.append((taken_ns, message.iou))
            else:
                self._unknown.append(taken_ns)
        else:
            self._events.append(RecordedMessage(topic=topic, time_ns=time_ns, message=message))
            self._began |= topic == LOG_TOPIC
            self._timeline = None

    def utility(self, start_ns: int) -> float:
        """Return the utility as if the run ended now; 0 before the first frame.

        Args:
            start_ns: when the measured time began; the present time if it has not.
        """
        timeline = self._known_timeline(start_ns)
        iou = np.array([iou for _, iou in self._frames], np.float64)
        times = _seconds([time for time, _ in self._frames], start_ns)
        timeline = replace(
            timeline, frames=Frames(times, iou), without_truth=_seconds(self._unknown, start_ns)
        )
        return utility(timeline) or 0.0

    def cured(self, start_ns: int) -> int:
        """Return how many faults are cured; a cure that is in place counts from its beginning."""
        return faults_cured(self._known_timeline(start_ns))

    def _known_timeline(self, start_ns: int) -> Timeline:
        """Return the timeline without its frames."""
        if self._timeline is not None and self._began:
            return self._timeline
        start = ExperimentLogging(timestamp=start_ns, source=EXPERIMENT, rule_name="start")
        events = [*self._events, RecordedMessage(topic=LOG_TOPIC, time_ns=start_ns, message=start)]
        self._timeline = timeline_of(self._record, events)
        return self._timeline


def _seconds(times_ns: list[int], start_ns: int) -> npt.NDArray[np.float64]:
    return (np.array(times_ns, np.int64) - start_ns) / 1e9
