"""Sets a node's clock from /clock while its parameter `use_sim_time` is true."""

from sunset.interfaces import Message
from sunset.interfaces.rosgraph_msgs.msg import Clock as ClockMessage
from sunset.rmw.port import NodeHandle, QoSProfile, ReliabilityPolicy, SubscriptionHandle
from sunset.ros.clock import ROSClock
from sunset.ros.time import Time

__all__ = ["TimeSource"]

_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class TimeSource:
    """Sets a clock from /clock."""

    def __init__(self, node: NodeHandle, clock: ROSClock) -> None:
        self._node = node
        self._clock = clock
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

    def _on_clock(self, message: Message) -> None:
        if isinstance(message, ClockMessage):
            self._clock.set_ros_time_override(Time.from_msg(message.clock))
