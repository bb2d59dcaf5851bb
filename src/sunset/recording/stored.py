"""A whole run from its record: what was flown, what happened, and what was logged meanwhile."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from sunset.errors import RecordError
from sunset.interfaces.rcl_interfaces.msg import Log
from sunset.metrics import RunMetrics, Timeline, score
from sunset.recording.reader import read_messages, read_run, read_timeline
from sunset.recording.timelines import LOG_TOPIC, content_of, start_of
from sunset.recording.values import RUN_FILE

__all__ = ["LogLine", "StoredRun", "read_log", "read_stored_run"]

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
        scenario: the scenario's name.
        faults: the names of its faults, in its order.
        manager: the managing system's name.
        seed: of the run.
        model: the segmentation's model.
        valid: whether the run counts.
        reason: why it does not; empty if it does.
        timeline: what was observed.
        score: the metrics, computed from that.
        log: what all nodes logged, in order of time.
    """

    scenario: str
    faults: tuple[str, ...]
    manager: str
    seed: int
    model: str
    valid: bool
    reason: str
    timeline: Timeline
    score: RunMetrics
    log: tuple[LogLine, ...]


def read_stored_run(folder: Path) -> StoredRun:
    """Return what the record of a run tells.

    Raises:
        RecordError: as `read_timeline`; `run.json` lacks something; or there is nothing to tell, because the
            managing system failed.
    """
    run = read_run(folder)
    if failed := run.get("manager_failed"):
        raise RecordError(f"The run in {folder} has no time line, since its managing system failed: {failed}")
    try:
        faults = tuple(str(fault["name"]) for fault in _entry(run, "faults", list, folder))
    except (KeyError, TypeError) as error:
        raise RecordError(f"Each of the faults in {folder / RUN_FILE} must have a name.") from error
    timeline = read_timeline(folder)
    return StoredRun(
        scenario=_entry(run, "scenario", str, folder),
        faults=faults,
        manager=_entry(run, "manager", str, folder),
        seed=_entry(run, "seed", int, folder),
        model=_entry(run, "model", str, folder),
        valid=_entry(run, "valid", bool, folder),
        reason=_entry(run, "reason", str, folder),
        timeline=timeline,
        score=score(timeline),
        log=read_log(folder),
    )


def read_log(folder: Path) -> tuple[LogLine, ...]:
    """Return what the nodes of a run logged, in order of time.

    Raises:
        RecordError: as `read_messages`, or a message does not have the expected type, or the start is missing.
    """
    messages = read_messages(folder, (_ROSOUT, LOG_TOPIC))
    start_ns = start_of([one for one in messages if one.topic == LOG_TOPIC])
    lines = []
    for one in messages:
        if one.topic == _ROSOUT:
            entry = content_of(one, Log)
            severity = _SEVERITIES.get(entry.level, str(entry.level))
            lines.append(LogLine((one.time_ns - start_ns) / 1e9, severity, entry.name, entry.msg))
    return tuple(lines)


def _entry(run: dict[str, Any], key: str, kind: type, folder: Path) -> Any:
    value = run.get(key)
    if not isinstance(value, kind):
        raise RecordError(f"The {key} in {folder / RUN_FILE} must be of type {kind.__name__}, got {value!r}.")
    return value
