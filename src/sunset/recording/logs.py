"""The log of a run's nodes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from sunset.recording.timelines import start_of
from sunset.recording.values import RecordedMessage
from sunset_ros.interfaces.rcl_interfaces.msg import Log

ROSOUT: Final = "/rosout"
"""The topic on which nodes log."""

_SEVERITIES: Final = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "FATAL"}
"""The numbers of rcl_interfaces/msg/Log."""


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


def log_of(messages: Sequence[RecordedMessage]) -> tuple[LogLine, ...]:
    """Return the log of a run's nodes, in order of time.

    Raises:
        RecordError: the messages lack the start of the experiment.
    """
    start_ns = start_of(messages)
    lines = []
    for recorded in messages:
        entry = recorded.message
        if recorded.topic == ROSOUT and isinstance(entry, Log):
            severity = _SEVERITIES.get(entry.level, str(entry.level))
            lines.append(LogLine((recorded.time_ns - start_ns) / 1e9, severity, entry.name, entry.msg))
    return tuple(lines)
