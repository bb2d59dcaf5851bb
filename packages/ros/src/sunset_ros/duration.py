"""Spans of time, as in `rclpy.duration`."""

from dataclasses import dataclass

from sunset_ros.interfaces.builtin_interfaces.msg import Duration as DurationMessage


@dataclass(frozen=True, order=True, slots=True, init=False)
class Duration:
    """A span of time, in whole nanoseconds; may be negative.

    >>> Duration(seconds=1.5).nanoseconds
    1500000000
    """

    nanoseconds: int

    def __init__(self, *, seconds: float = 0, nanoseconds: float = 0) -> None:
        object.__setattr__(self, "nanoseconds", int(seconds * 10**9) + int(nanoseconds))

    def to_msg(self) -> DurationMessage:
        """Return it as a message."""
        seconds, nanoseconds = divmod(self.nanoseconds, 10**9)
        return DurationMessage(sec=seconds, nanosec=nanoseconds)

    @classmethod
    def from_msg(cls, msg: DurationMessage) -> "Duration":
        """Return the duration in a message."""
        return cls(seconds=msg.sec, nanoseconds=msg.nanosec)
