"""The bag player of a live system, which gives the system its time."""

from typing import Any, Final

from sunset.harness.bag_player import BagPlayer
from sunset.interfaces.builtin_interfaces.msg import Time
from sunset.interfaces.rcl_interfaces.msg import FloatingPointRange, IntegerRange
from sunset.interfaces.rosgraph_msgs.msg import Clock as ClockMessage
from sunset.interfaces.stamps import stamp_of
from sunset.ros.clock import Clock
from sunset.ros.time import ClockType

_TICK_S: Final = 0.01
"""Time between two messages on `/clock`, by that clock."""


class LiveBagPlayer(BagPlayer):
    """Publishes `/clock` a hundred times a second from its start on, and stamps what it plays with that time.

    Parameters, besides those of `BagPlayer`, whose times are of `/clock`:
        width, height: the size that frames are played in; 0 for the bag's.
        speed: seconds of `/clock` in a second.
        origin_ns: the system's time, nanoseconds since 1970, at which `/clock` is 0; 0 for the player's start.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._speed = float(self._value("speed"))
        self._steady = Clock(clock_type=ClockType.STEADY_TIME, context=self.context)
        began_ns = self.get_clock().now().nanoseconds
        # from here on by the clock that never jumps
        self._offset_ns = began_ns - (self._value("origin_ns") or began_ns) - self._steady.now_ns()
        # not by /clock: if this node followed that, which it publishes, it would never begin
        self.create_timer(_TICK_S / self._speed, self._tick, clock=self._steady)

    def _declare_parameters(self) -> None:
        super()._declare_parameters()
        size = [IntegerRange(from_value=0, to_value=2**14)]
        speed = [FloatingPointRange(from_value=0.01, to_value=100.0)]
        self._declare("width", 0, "width of the frames in pixels; 0 for the bag's", integer_range=size)
        self._declare("height", 0, "height of the frames in pixels; 0 for the bag's", integer_range=size)
        self._declare("speed", 1.0, "seconds of /clock in a second", floating_point_range=speed)
        self._declare("origin_ns", 0, "system time at which /clock is 0; 0 for the start of this node")

    def _size(self) -> tuple[int, int] | None:
        size = (self._value("height"), self._value("width"))
        return size if all(size) else None

    def _now(self) -> Time:
        # 0 means on /clock that there is no time yet
        return stamp_of(max(1, round((self._steady.now_ns() + self._offset_ns) * self._speed)))

    def _tick(self) -> None:
        self._time.publish(ClockMessage(clock=self._now()))

    def _stamp(self) -> Time:
        return self._now()
