"""Reading the record of a run."""

import json
import reprlib
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, Final

from sunset.errors import RecordError
from sunset.input_files import read_text
from sunset.metrics import Timeline
from sunset.recording._bag import read_bag
from sunset.recording.run_file import check_number
from sunset.recording.timelines import measured_topics, timeline
from sunset.recording.values import RECORD_VERSION, RUN_FILE, RecordedMessage, digest_of
from sunset.system import current_system, loaded_extensions
from sunset.texts import printable_json

__all__ = ["read_messages", "read_run", "read_timeline"]

_TIMELINE_KEYS: Final = (
    "duration_s",
    "expected_frames",
    "period_s",
)


def read_run(folder: Path) -> dict[str, Any]:
    """Return what `run.json` of a record says.

    Raises:
        RecordError: the folder is no complete record, `run.json` is damaged, or of another version.
    """
    file = Path(folder) / RUN_FILE
    try:
        run = printable_json(json.loads(read_text(file)))
    except FileNotFoundError as error:
        raise RecordError(f"{folder} is no complete record: {RUN_FILE} is missing.") from error
    except OSError as error:
        raise RecordError(f"The file {file} cannot be read: {error.strerror}.") from error
    except (RecursionError, ValueError) as error:
        raise RecordError(f"The file {file} is damaged: {error}.") from error
    version = run.get("record_version") if isinstance(run, dict) else None
    if version != RECORD_VERSION:
        raise RecordError(
            f"The record {folder} is of version {reprlib.repr(version)}, expected {RECORD_VERSION}; "
            "read it with the SUNSET that wrote it, or run it again."
        )
    return dict(run)


def read_messages(folder: Path, topics: Collection[str] | None = None) -> tuple[RecordedMessage, ...]:
    """Return the messages of a record in order of time.

    Args:
        folder: the record.
        topics: the full names of the topics that are wanted; None for all.

    Raises:
        RecordError: the record is missing, incomplete, damaged, or of another version.
    """
    folder = Path(folder)
    expected = read_run(folder).get("digest")
    payloads = list(read_bag(folder))
    found = digest_of(payloads)
    if found != expected:
        raise RecordError(
            f"The record {folder} is damaged: {RUN_FILE} gives the digest {expected}, the messages {found}."
        )
    return tuple(payload.decoded() for payload in payloads if topics is None or payload.topic in topics)


def check_extensions(flown: object, folder: Path) -> None:
    """Check that this process describes the system that a run was flown with.

    Args:
        flown: name → checksum, as `run.json` has them.
        folder: the record.

    Raises:
        RecordError: an extension is missing, too many, or another one of the same name.
    """
    loaded = {extension.name: extension.checksum for extension in loaded_extensions()}
    recorded = flown if isinstance(flown, Mapping) else {}
    for name in recorded.keys() - loaded.keys():
        raise RecordError(
            f"The run in {folder} was flown with the extension {name}: name it with --extension."
        )
    for name, checksum in loaded.items():
        if name not in recorded:
            raise RecordError(f"The run in {folder} was flown without the extension {name}: leave it out.")
        if recorded[name] != checksum:
            raise RecordError(
                f"The run in {folder} was flown with another version of the extension {name}: name that one."
            )


def read_timeline(folder: Path) -> Timeline:
    """Return what the metrics look at, from a record.

    Raises:
        RecordError: as `read_messages`; `run.json` lacks a key, or as `timeline`.
    """
    run = read_run(folder)
    for key in _TIMELINE_KEYS:
        check_number(run, key, Path(folder) / RUN_FILE)
    check_extensions(run.get("extensions", {}), folder)
    signals = current_system().signals.values()
    calibrated = [signal.threshold_name for signal in signals if signal.calibrated]
    for key in calibrated:
        check_number(run, key, Path(folder) / RUN_FILE)
    thresholds = {key: run[key] for key in calibrated}
    messages = read_messages(folder, measured_topics())
    return timeline(messages, thresholds=thresholds, **{key: run[key] for key in _TIMELINE_KEYS})
