"""Sets a node's clock from /clock while its parameter `use_sim_time` is true."""

from collections.abc import Callable
from typing import Final

from sunset_ros.clock import ROSClock
from sunset_ros.interfaces.rosgraph_msgs.msg import Clock as ClockMessage
from sunset_ros.interfaces.stamps import ns_of
from sunset_ros.rmw.core.node import NodeHandle, SubscriptionHandle
from sunset_ros.rmw.core.qos import QoSProfile, ReliabilityPolicy
from sunset_ros.time import ClockType, Time

_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
_END_NS: Final = 2**31 * 10**9
"""The first time that a message cannot express."""


class TimeSource:
    """Sets a node's clock from /clock, and reports messages that are not a time."""

    def __init__(self, node: NodeHandle, clock: ROSClock, on_problem: Callable[[str], object]) -> None:
        self._node = node
        self._clock = clock
        self._on_problem = on_problem
        self._subscription: SubscriptionHandle | None = None

    def use_sim_time(self, active: bool) -> None:
        """Follow /clock, starting at 0 until something comes on it, or the system's clock."""
        if active == (self._subscription is not None):
            return
        if self._subscription is None:
            self._subscription = self._node.create_subscription(
                ClockMessage, "/clock", _QOS, self._on_clock, label="on /clock"
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
            self._on_problem(f"/clock: dropped a time that cannot be, {now_ns} ns.")
