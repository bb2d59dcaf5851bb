"""Points in time, as in `rclpy.time`."""

from dataclasses import dataclass
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
@dataclass(frozen=True, slots=True, init=False, eq=False, repr=False)
class Time:
    """A point in time of a clock type, in whole nanoseconds; a negative one raises a `ValueError`."""

    nanoseconds: int
    clock_type: ClockType

    def __init__(
        self, *, seconds: float = 0, nanoseconds: float = 0, clock_type: ClockType = ClockType.SYSTEM_TIME
    ) -> None:
        total = int(seconds * 10**9) + int(nanoseconds)
        if total < 0:
            raise ValueError(f"A point in time must be at least 0 ns, got {total}.")
        object.__setattr__(self, "nanoseconds", total)
        object.__setattr__(self, "clock_type", clock_type)

    def seconds_nanoseconds(self) -> tuple[int, int]:
        """Return whole seconds, and the nanoseconds that remain."""
        return divmod(self.nanoseconds, 10**9)

    def __repr__(self) -> str:
        return f"Time(nanoseconds={self.nanoseconds}, clock_type={self.clock_type.name})"

    def __add__(self, other: Duration) -> "Time":
        if not isinstance(other, Duration):
            return NotImplemented
        return Time(nanoseconds=self.nanoseconds + other.nanoseconds, clock_type=self.clock_type)

    __radd__ = __add__

    @overload
    def __sub__(self, other: "Time") -> Duration: ...
    @overload
    def __sub__(self, other: Duration) -> "Time": ...
    def __sub__(self, other: "Time | Duration") -> "Time | Duration":
        if isinstance(other, Time):
            if self.clock_type is not other.clock_type:
                names = f"{self.clock_type.name}, {other.clock_type.name}"
                raise TypeError(f"Times of different clocks cannot be compared: {names}.")
            return Duration(nanoseconds=self.nanoseconds - other.nanoseconds)
        if isinstance(other, Duration):
            return Time(nanoseconds=self.nanoseconds - other.nanoseconds, clock_type=self.clock_type)
        return NotImplemented

    def __eq__(self, other: object) -> bool:
        return (self - other).nanoseconds == 0 if isinstance(other, Time) else NotImplemented

    def __lt__(self, other: object) -> bool:
        return (self - other).nanoseconds < 0 if isinstance(other, Time) else NotImplemented

    def __hash__(self) -> int:
        return hash((self.nanoseconds, self.clock_type))

    def to_msg(self) -> TimeMessage:
        """Return it as a message."""
        return stamp_of(self.nanoseconds)

    @classmethod
    def from_msg(cls, msg: TimeMessage, clock_type: ClockType = ClockType.ROS_TIME) -> "Time":
        """Return the time in a message."""
        return cls(seconds=msg.sec, nanoseconds=msg.nanosec, clock_type=clock_type)
