"""Reading a record: its messages and timeline, and the run with its figures, log, events and faults."""

import io
from collections.abc import Collection
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import IO, TYPE_CHECKING, Final

from sunset.errors import RecordError
from sunset.files.dataframes import data_frame
from sunset.metrics import Episode, ExecutedAdaptation, RunMetrics, Samples, Timeline
from sunset.metrics.run_metrics import score
from sunset.recording._bag import RecordedMessage, digest_of, read_bag
from sunset.recording.schema import RunRecord, differences, read_run
from sunset.recording.story import Cause, Event, causes_of, events_of, print_story
from sunset.recording.timelines import ROSOUT, LogLine, log_of, measured_topics, timeline_of
from sunset.system import loaded_extensions
from sunset.texts.names import RUN_FILE
from sunset_ros.texts import shorten

if TYPE_CHECKING:
    from pandas import DataFrame

_SUMMARY: Final = (
    *("scenario", "manager", "manager_failed", "seed", "model", "middleware"),
    *("digest", "valid", "reason"),
)


@dataclass(frozen=True)
class StoredRun:
    """A run from its record.

    Attributes:
        folder: the record.
        record: the content of `run.json`.
        timeline: the observations.
        metrics: the figures, computed from the timeline.
        log: the log of all nodes, in order of time.
        differing: the names of the stored figures that differ from `metrics`.
        events: in words, in order of time.
        causes: the faults, with their symptoms and cures.
    """

    folder: Path
    record: RunRecord
    timeline: Timeline
    metrics: RunMetrics
    log: tuple[LogLine, ...]
    differing: tuple[str, ...] = ()
    events: tuple[Event, ...] = field(init=False)
    causes: tuple[Cause, ...] = field(init=False)

    def __post_init__(self) -> None:
        """Describe events and causes now, while the managed system has the extensions of the run."""
        object.__setattr__(self, "events", events_of(self.timeline, self.metrics, self.log))
        object.__setattr__(self, "causes", causes_of(self.timeline, self.metrics, self.record.faults))

    def __str__(self) -> str:
        """Return the time line that `sunset report` prints."""
        text = io.StringIO()
        self.print_story(text)
        return text.getvalue().strip("\n")

    def __repr__(self) -> str:
        """Return scenario, managing system, seed and IoU, without the arrays."""
        run, iou = self.record, self.metrics.iou
        return (
            f"<{'' if run.valid else 'invalid '}run of {run.scenario}, managing system {run.manager}, seed {run.seed}, "
            f"IoU {'N/A' if iou is None else f'{iou:.2f}'}>"
        )

    def print_story(self, file: IO[str] | None = None) -> None:
        """Print the time line on stdout, in colours on a terminal; or as plain text into a file."""
        print_story(self.record, self.events, self.causes, self.metrics, self.differing, file=file)

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
        """Why the run does not count; empty if it does."""
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
        """Return all samples as a data frame of pandas, a row each.

        Its columns are `signal` (`iou`, and the nodes' signals, such as `segmentation_entropy`), `time_s` (from the
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
        """Return the values that `sunset run --json` prints."""
        about: dict[str, object] = {name: getattr(self.record, name) for name in _SUMMARY}
        return about | {"metrics": self.metrics.to_json()}


def read_messages(folder: Path, topics: Collection[str] | None = None) -> tuple[RecordedMessage, ...]:
    """Return the messages of a record in order of time.

    Args:
        folder: the record.
        topics: the full names of the topics that are wanted; None for all.

    Raises:
        RecordError: the record is incomplete, damaged, or of another version.
    """
    expected = read_run(folder).digest
    payloads = list(read_bag(folder))
    digest = digest_of(payloads)
    if digest != expected:
        raise RecordError(
            f"The record {folder} is damaged: {RUN_FILE} gives the digest {expected}, the messages {digest}."
        )
    return tuple(payload.decoded() for payload in payloads if topics is None or payload.topic in topics)


def first_difference(folder: Path, other: Path) -> str:
    """Return where the messages of two records begin to differ, in words; empty if they do not."""
    start_ns = read_run(folder).start_ns or 0
    for payloads in zip_longest(read_bag(folder), read_bag(other)):
        if payloads[0] != payloads[1]:
            first = min(filter(None, payloads), key=lambda payload: payload.time_ns)
            return f"first at {(first.time_ns - start_ns) / 1e9:.2f} s on {first.topic}"
    return ""


def check_extensions(run: RunRecord, folder: Path) -> None:
    """Check that this process has the extensions of a run.

    Raises:
        RecordError: an extension is missing, differs, or was not part of the run.
    """
    loaded = {extension.name: extension.checksum for extension in loaded_extensions()}
    recorded = run.extensions or {}
    for name in recorded | loaded:
        made = f"The run in {folder} was made"
        if name not in loaded:
            raise RecordError(
                f"{made} with the extension {name}: name it with --extension, in Python with extensions."
            )
        if name not in recorded:
            raise RecordError(f"{made} without the extension {name}: leave it out.")
        if recorded[name] != loaded[name]:
            raise RecordError(f"{made} with another version of the extension {name}: name that one.")


def read_timeline(folder: Path) -> Timeline:
    """Return the timeline of a record, as `read_messages` and `timeline_of`."""
    run = read_run(folder)
    check_extensions(run, folder)
    return timeline_of(run, read_messages(folder, measured_topics()))


def read_stored_run(folder: Path) -> StoredRun:
    """Return the run of a record.

    Raises:
        RecordError: as `read_timeline`; or the run failed as a whole, so that there is no time line.
    """
    run = read_run(folder)
    if run.is_empty:
        raise RecordError(
            f"The run in {folder} has no time line, since it failed: {shorten(str(run.manager_failed))}"
        )
    check_extensions(run, folder)
    messages = read_messages(folder, story_topics())
    timeline = timeline_of(run, messages)
    metrics = score(timeline)
    return StoredRun(folder, run, timeline, metrics, log_of(messages), differences(run, metrics))


def story_topics() -> frozenset[str]:
    """Return the full names of the topics that a `StoredRun` needs."""
    return measured_topics() | {ROSOUT}
