"""What the nodes of a run logged."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from sunset.interfaces.rcl_interfaces.msg import Log
from sunset.recording.timelines import start_of
from sunset.recording.values import RecordedMessage
from sunset.system import LOG_TOPIC

ROSOUT: Final = "/rosout"
"""The topic on which nodes log."""

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


def log_of(messages: Sequence[RecordedMessage]) -> tuple[LogLine, ...]:
    """Return what the nodes of a run logged, in order of time; other messages on the topic are not a log.

    Raises:
        RecordError: the start is missing, or has another type than expected.
    """
    start_ns = start_of([message for message in messages if message.topic == LOG_TOPIC])
    lines = []
    for message in messages:
        entry = message.message
        if message.topic == ROSOUT and isinstance(entry, Log):
            severity = _SEVERITIES.get(entry.level, str(entry.level))
            lines.append(LogLine((message.time_ns - start_ns) / 1e9, severity, entry.name, entry.msg))
    return tuple(lines)
