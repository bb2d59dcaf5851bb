"""Clocks, as in `rclpy.clock`; they never sleep, since callbacks must not block."""

from collections.abc import Callable
from typing import Final

from sunset_ros.context import Context, get_default_context
from sunset_ros.interfaces.rosgraph_msgs.msg import Clock as ClockMessage
from sunset_ros.interfaces.stamps import ns_of
from sunset_ros.logging import Logger
from sunset_ros.rmw.core.node import NodeHandle, SubscriptionHandle
from sunset_ros.rmw.core.qos import QoSProfile, ReliabilityPolicy
from sunset_ros.time import ClockType, Time

__all__ = ["Clock", "ClockType", "ROSClock", "TimeSource"]

_END_NS: Final = 2**31 * 10**9
"""The first time that a message cannot express."""


class Clock:
    """A clock of its context's middleware, or the default context's."""

    def __init__(
        self, *, clock_type: ClockType = ClockType.SYSTEM_TIME, context: Context | None = None
    ) -> None:
        self.clock_type = clock_type
        self._context = context or get_default_context()

    def __repr__(self) -> str:
        return f"Clock(clock_type={self.clock_type.name})"

    def now(self) -> Time:
        """Return the time; during a simulated callback, the time at which it started."""
        return Time(nanoseconds=self.now_ns(), clock_type=self.clock_type)

    def now_ns(self) -> int:
        """Return the time in nanoseconds."""
        middleware = self._context.middleware
        return middleware.steady_ns() if self.clock_type is ClockType.STEADY_TIME else middleware.now_ns()


class ROSClock(Clock):
    """A clock that may be set by `/clock`."""

    def __init__(self, *, context: Context | None = None) -> None:
        super().__init__(clock_type=ClockType.ROS_TIME, context=context)
        self._override_ns: int | None = None
        self._listeners: list[Callable[[], None]] = []

    @property
    def ros_time_is_active(self) -> bool:
        """Whether it follows `/clock`."""
        return self._override_ns is not None

    def set_ros_time_override(self, time: Time | None) -> None:
        """Set the time from `/clock`; None to follow the system's clock."""
        self._override_ns = None if time is None else time.nanoseconds
        for listener in list(self._listeners):
            listener()

    def add_listener(self, listener: Callable[[], None]) -> None:
        """Call `listener()` whenever the time was set."""
        self._listeners.append(listener)

    def remove_listener(self, listener: Callable[[], None]) -> None:
        """Stop calling `listener()`."""
        if listener in self._listeners:
            self._listeners.remove(listener)

    def now_ns(self) -> int:
        """Return the time in nanoseconds."""
        return super().now_ns() if self._override_ns is None else self._override_ns


class TimeSource:
    """Sets a node's clock from /clock while its parameter `use_sim_time` is true."""

    def __init__(self, node: NodeHandle, clock: ROSClock, logger: Logger) -> None:
        self._node = node
        self._clock = clock
        self._logger = logger
        self._subscription: SubscriptionHandle | None = None

    def use_sim_time(self, active: bool) -> None:
        """Follow /clock, starting at 0 until something comes on it, or the system's clock."""
        if active == (self._subscription is not None):
            return
        if self._subscription is None:
            qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
            self._subscription = self._node.create_subscription(
                ClockMessage, "/clock", qos, self._on_clock, label="on /clock"
            )
            self._clock.set_ros_time_override(Time())
        else:
            self._subscription.destroy()
            self._subscription = None
            self._clock.set_ros_time_override(None)

    def _on_clock(self, message: ClockMessage) -> None:
        now_ns = ns_of(message.clock)
        if 0 <= now_ns < _END_NS:
            self._clock.set_ros_time_override(Time(nanoseconds=now_ns, clock_type=ClockType.ROS_TIME))
        else:
            problem = f"/clock: dropped a time that cannot be, {now_ns} ns."
            self._logger.warning(problem, throttle_duration_sec=10.0)
