"""The bag player of a live system, which gives the system its time."""

from typing import Final

from sunset.harness.bag_player import BagPlayer
from sunset.interfaces.builtin_interfaces.msg import Time
from sunset.interfaces.rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from sunset.interfaces.rosgraph_msgs.msg import Clock as ClockMessage
from sunset.interfaces.stamps import stamp_of
from sunset.ros.clock import Clock
from sunset.ros.context import Context
from sunset.ros.parameter import Parameter
from sunset.ros.time import ClockType

_TICK_S: Final = 0.01
"""Time between two messages on `/clock`, by that clock."""


class LiveBagPlayer(BagPlayer):
    """Publishes `/clock` a hundred times a second from its start on, and stamps what it plays with that time.

    Parameters, besides those of `BagPlayer`, whose times are of `/clock`:
        width, height: the size that frames are played in; 0 for the bag's.
        speed: seconds of `/clock` in a second.
        origin_ns: the system's time, nanoseconds since 1970, at which `/clock` is 0; 0 for the player's start.

    Args:
        context: the context of the process; the default one if None.
        cli_args: ROS arguments.
        parameter_overrides: initial values of parameters.
    """

    def __init__(
        self,
        *,
        context: Context | None = None,
        cli_args: list[str] | None = None,
        parameter_overrides: list[Parameter] | None = None,
    ) -> None:
        super().__init__(context=context, cli_args=cli_args, parameter_overrides=parameter_overrides)
        self._speed = float(self._value("speed"))
        self._steady = Clock(clock_type=ClockType.STEADY_TIME, context=self.context)
        began_ns = self.get_clock().now().nanoseconds
        # from here on by the clock that never jumps
        self._offset_ns = began_ns - (self._value("origin_ns") or began_ns) - self._steady.now_ns()
        # by /clock itself it would never begin, if somebody let this node follow that
        self.create_timer(_TICK_S / self._speed, self._tick, clock=self._steady)

    def _declare_parameters(self) -> None:
        super()._declare_parameters()
        size = {"integer_range": [IntegerRange(from_value=0, to_value=2**14, step=0)]}
        speed = {"floating_point_range": [FloatingPointRange(from_value=0.01, to_value=100.0)]}
        for name, default, description, limits in (
            ("width", 0, "width of the frames in pixels; 0 for the bag's", size),
            ("height", 0, "height of the frames in pixels; 0 for the bag's", size),
            ("speed", 1.0, "seconds of /clock in a second", speed),
            ("origin_ns", 0, "system time at which /clock is 0; 0 for the start of this node", {}),
        ):
            descriptor = ParameterDescriptor(name=name, description=description, read_only=True, **limits)
            self.declare_parameter(name, default, descriptor)

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
