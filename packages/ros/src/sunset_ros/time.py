"""Points in time, as in `rclpy.time`."""

from enum import IntEnum
from functools import total_ordering
from typing import overload

from sunset_ros.duration import Duration
from sunset_ros.interfaces.builtin_interfaces.msg import Time as TimeMessage
from sunset_ros.interfaces.stamps import stamp_of


class ClockType(IntEnum):
    """The source of a clock's time."""

    ROS_TIME = 1
    """/clock where the node's parameter `use_sim_time` says so, else the system's clock."""
    SYSTEM_TIME = 2
    STEADY_TIME = 3


@total_ordering
class Time:
    """A point in time of a clock type, in whole nanoseconds of at least 0.

    Raises:
        ValueError: it would be negative.
    """

    __slots__ = ("_clock_type", "_nanoseconds")

    def __init__(
        self, *, seconds: float = 0, nanoseconds: float = 0, clock_type: ClockType = ClockType.SYSTEM_TIME
    ) -> None:
        total = int(seconds * 10**9) + int(nanoseconds)
        if total < 0:
            raise ValueError(f"A point in time must be at least 0 ns, got {total}.")
        self._nanoseconds = total
        self._clock_type = clock_type

    @property
    def nanoseconds(self) -> int:
        """Nanoseconds since the clock's epoch."""
        return self._nanoseconds

    @property
    def clock_type(self) -> ClockType:
        """The type of its clock."""
        return self._clock_type

    def seconds_nanoseconds(self) -> tuple[int, int]:
        """Return whole seconds, and the nanoseconds that remain."""
        return divmod(self._nanoseconds, 10**9)

    def __repr__(self) -> str:
        return f"Time(nanoseconds={self._nanoseconds}, clock_type={self._clock_type.name})"

    def __add__(self, other: Duration) -> "Time":
        if not isinstance(other, Duration):
            return NotImplemented
        return Time(nanoseconds=self._nanoseconds + other.nanoseconds, clock_type=self._clock_type)

    __radd__ = __add__

    @overload
    def __sub__(self, other: "Time") -> Duration: ...
    @overload
    def __sub__(self, other: Duration) -> "Time": ...
    def __sub__(self, other: "Time | Duration") -> "Time | Duration":
        if isinstance(other, Time):
            self._check_same_clock(other)
            return Duration(nanoseconds=self._nanoseconds - other._nanoseconds)
        if isinstance(other, Duration):
            return Time(nanoseconds=self._nanoseconds - other.nanoseconds, clock_type=self._clock_type)
        return NotImplemented

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Time):
            return NotImplemented
        self._check_same_clock(other)
        return self._nanoseconds == other._nanoseconds

    def __lt__(self, other: object) -> bool:
        if not isinstance(other, Time):
            return NotImplemented
        self._check_same_clock(other)
        return self._nanoseconds < other._nanoseconds

    def __hash__(self) -> int:
        return hash((self._nanoseconds, self._clock_type))

    def _check_same_clock(self, other: "Time") -> None:
        if self._clock_type is not other.clock_type:
            raise TypeError(
                f"Times of different clocks cannot be compared: {self._clock_type.name}, {other.clock_type.name}."
            )

    def to_msg(self) -> TimeMessage:
        """Return it as a message."""
        return stamp_of(self._nanoseconds)

    @classmethod
    def from_msg(cls, msg: TimeMessage, clock_type: ClockType = ClockType.ROS_TIME) -> "Time":
        """Return the time in a message."""
        return cls(seconds=msg.sec, nanoseconds=msg.nanosec, clock_type=clock_type)
