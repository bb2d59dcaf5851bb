"""A whole run from its record: what was run, what happened, and what was logged meanwhile."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from sunset.dataframes import data_frame
from sunset.errors import RecordError
from sunset.interfaces.rcl_interfaces.msg import Log
from sunset.metrics import Episode, ExecutedAdaptation, RunMetrics, Samples, Timeline, score
from sunset.recording.reader import check_extensions, read_messages, timeline_of
from sunset.recording.schema import RUN_FILE, RunRecord, differing_figures, read_run, stored_figures
from sunset.recording.timelines import LOG_TOPIC, content_of, measured_topics, start_of
from sunset.recording.values import RecordedMessage
from sunset.texts import shorten

if TYPE_CHECKING:
    from pandas import DataFrame

_ROSOUT: Final = "/rosout"
_INFO: Final = 20
_SEVERITIES: Final = {10: "DEBUG", _INFO: "INFO", 30: "WARN", 40: "ERROR", 50: "FATAL"}
"""As rcl_interfaces/msg/Log numbers them."""


@dataclass(frozen=True, slots=True)
class LogLine:
    """What a node logged.

    Attributes:
        time: when it was logged, in seconds from the injection on; negative before it.
        severity: such as `INFO` or `WARN`.
        logger: whose it is: the node's full name with dots in place of slashes, such as `managed_subsystem.camera`.
        text: what it says.
    """

    time: float
    severity: str
    logger: str
    text: str

    def __str__(self) -> str:
        """Return the text, behind the severity if that is another than INFO."""
        return self.text if self.severity == _SEVERITIES[_INFO] else f"{self.severity}: {self.text}"


@dataclass(frozen=True, slots=True)
class StoredRun:
    """A run, as its record tells it.

    Attributes:
        record: what was run.
        timeline: what was observed.
        metrics: the figures, computed from that.
        log: what all nodes logged, in order of time.
        differing: the names of the metrics that are stored otherwise than they were computed.
    """

    folder: Path
    record: RunRecord
    timeline: Timeline
    metrics: RunMetrics
    log: tuple[LogLine, ...]
    differing: tuple[str, ...] = ()

    @property
    def digest(self) -> str:
        """SHA-256 of the record's messages, in hexadecimal."""
        return self.record.digest

    @property
    def valid(self) -> bool:
        """Whether the run counts; if not, `reason` says why."""
        return self.record.valid

    @property
    def reason(self) -> str:
        """Why the run does not count; empty where it does."""
        return self.record.reason

    @property
    def episodes(self) -> tuple[Episode, ...]:
        """The episodes of failures, in order of time."""
        return self.metrics.failures

    @property
    def adaptations(self) -> tuple[ExecutedAdaptation, ...]:
        """The adaptations that were executed, in order of time."""
        return self.metrics.executed

    def to_frame(self) -> "DataFrame":
        """Return what was measured over time as a data frame of pandas: one row a sample.

        Its columns are `signal` (`iou`, and what nodes report, such as `segmentation_entropy`), `time_s` (from the
        injection on) and `value`.

        Raises:
            MissingExtraError: pandas is not installed.
        """
        frames = self.timeline.frames
        signals = {"iou": Samples(frames.times, frames.iou), **self.timeline.samples}
        return data_frame(
            {"signal": signal, "time_s": time, "value": value}
            for signal, samples in signals.items()
            for time, value in zip(samples.times, samples.values, strict=True)
        )

    def summary(self) -> dict[str, object]:
        """Return what `sunset run --json` prints."""
        names = (
            "scenario",
            "manager",
            "manager_failed",
            "seed",
            "model",
            "middleware",
            "digest",
            "valid",
            "reason",
        )
        return {name: getattr(self.record, name) for name in names} | {"metrics": self.metrics.to_json()}


def read_stored_run(folder: Path) -> StoredRun:
    """Return what the record of a run tells.

    Raises:
        RecordError: as `read_timeline`; `run.json` has a metric that no run can have; or there is nothing to tell,
            because it failed.
    """
    run = read_run(folder)
    if run.manager_failed is not None:
        raise RecordError(
            f"The run in {folder} has no time line, since it failed: {shorten(run.manager_failed)}"
        )
    check_extensions(run, folder)
    messages = read_messages(folder, told_topics())
    timeline = timeline_of(run, messages)
    figures = score(timeline)
    return StoredRun(
        folder=folder,
        record=run,
        timeline=timeline,
        metrics=figures,
        log=log_of(messages),
        differing=differing_figures(stored_figures(run, folder / RUN_FILE), figures.to_json()),
    )


def read_log(folder: Path) -> tuple[LogLine, ...]:
    """Return what the nodes of a run logged, in order of time.

    Raises:
        RecordError: as `read_messages`, or a message does not have the expected type, or the start is missing.
    """
    return log_of(read_messages(folder, (_ROSOUT, LOG_TOPIC)))


def told_topics() -> frozenset[str]:
    """Return the full names of the topics that a `StoredRun` is made of."""
    return measured_topics() | {_ROSOUT}


def log_of(messages: Sequence[RecordedMessage]) -> tuple[LogLine, ...]:
    """Return what the nodes of a run logged, from messages that are read already; as `read_log`."""
    start_ns = start_of([one for one in messages if one.topic == LOG_TOPIC])
    lines = []
    for one in messages:
        if one.topic == _ROSOUT:
            entry = content_of(one, Log)
            severity = _SEVERITIES.get(entry.level, str(entry.level))
            lines.append(LogLine((one.time_ns - start_ns) / 1e9, severity, entry.name, entry.msg))
    return tuple(lines)
