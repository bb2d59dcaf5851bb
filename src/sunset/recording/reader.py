"""Reading the messages of a record."""

from collections.abc import Collection
from itertools import zip_longest
from pathlib import Path

from sunset.errors import RecordError
from sunset.metrics import Timeline
from sunset.recording._bag import read_bag
from sunset.recording.schema import RunRecord, read_run
from sunset.recording.timelines import measured_topics, timeline_of
from sunset.recording.values import RecordedMessage, digest_of
from sunset.system import loaded_extensions
from sunset.texts.names import RUN_FILE


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
    for name in recorded.keys() - loaded.keys():
        raise RecordError(
            f"The run in {folder} was made with the extension {name}: name it with --extension, in Python with "
            "extensions."
        )
    for name, checksum in loaded.items():
        if name not in recorded:
            raise RecordError(f"The run in {folder} was made without the extension {name}: leave it out.")
        if recorded[name] != checksum:
            raise RecordError(
                f"The run in {folder} was made with another version of the extension {name}: name that one."
            )


def read_timeline(folder: Path) -> Timeline:
    """Return the timeline of a record, as `read_messages` and `timeline_of`."""
    run = read_run(folder)
    check_extensions(run, folder)
    return timeline_of(run, read_messages(folder, measured_topics()))
