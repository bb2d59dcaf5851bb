"""A whole run from its record: what was flown, what happened, and what was logged meanwhile."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from sunset.errors import RecordError
from sunset.interfaces.rcl_interfaces.msg import Log
from sunset.metrics import RunMetrics, Timeline, score
from sunset.recording.reader import read_messages, read_run, read_timeline
from sunset.recording.run_file import check_entries, check_entry, differing_figures, stored_figures
from sunset.recording.timelines import LOG_TOPIC, content_of, start_of
from sunset.recording.values import RUN_FILE
from sunset.texts import shorten

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
        differing: the names of the metrics that are stored otherwise than they were computed.
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
    differing: tuple[str, ...] = ()


def read_stored_run(folder: Path) -> StoredRun:
    """Return what the record of a run tells.

    Raises:
        RecordError: as `read_timeline`; `run.json` lacks something, or has a metric that no run can have; or there
            is nothing to tell, because the managing system failed.
    """
    run, where = read_run(folder), folder / RUN_FILE
    if failed := run.get("manager_failed"):
        raise RecordError(
            f"The run in {folder} has no time line, since its managing system failed: {shorten(str(failed))}"
        )
    try:
        faults = tuple(str(fault["name"]) for fault in check_entry(run, "faults", list, where))
    except (KeyError, TypeError) as error:
        raise RecordError(f"Each of the faults in {where} must have a name.") from error
    entries = check_entries(run, where)
    timeline = read_timeline(folder)
    figures = score(timeline)
    return StoredRun(
        scenario=entries["scenario"],
        faults=faults,
        manager=entries["manager"],
        seed=entries["seed"],
        model=entries["model"],
        valid=entries["valid"],
        reason=entries["reason"],
        timeline=timeline,
        score=figures,
        log=read_log(folder),
        differing=differing_figures(stored_figures(run, where), figures.to_json()),
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
