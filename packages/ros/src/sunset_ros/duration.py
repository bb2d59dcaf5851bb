"""Spans of time, as in `rclpy.duration`."""

from functools import total_ordering

from sunset_ros.interfaces.builtin_interfaces.msg import Duration as DurationMessage


@total_ordering
class Duration:
    """A span of time, in whole nanoseconds; may be negative.

    >>> Duration(seconds=1.5).nanoseconds
    1500000000
    """

    __slots__ = ("_nanoseconds",)

    def __init__(self, *, seconds: float = 0, nanoseconds: float = 0) -> None:
        self._nanoseconds = int(seconds * 10**9) + int(nanoseconds)

    @property
    def nanoseconds(self) -> int:
        """The whole span in nanoseconds."""
        return self._nanoseconds

    def __repr__(self) -> str:
        return f"Duration(nanoseconds={self._nanoseconds})"

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Duration):
            return self._nanoseconds == other._nanoseconds
        return NotImplemented

    def __lt__(self, other: object) -> bool:
        if isinstance(other, Duration):
            return self._nanoseconds < other._nanoseconds
        return NotImplemented

    def __hash__(self) -> int:
        return hash(self._nanoseconds)

    def to_msg(self) -> DurationMessage:
        """Return it as a message."""
        seconds, nanoseconds = divmod(self._nanoseconds, 10**9)
        return DurationMessage(sec=seconds, nanosec=nanoseconds)

    @classmethod
    def from_msg(cls, msg: DurationMessage) -> "Duration":
        """Return the duration in a message."""
        return cls(seconds=msg.sec, nanoseconds=msg.nanosec)
