"""Subscriptions, as in `rclpy.subscription`."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeAlias, TypeVar

from sunset_ros.interfaces import Message
from sunset_ros.rmw.core.node import SubscriptionHandle
from sunset_ros.rmw.core.qos import QoSProfile

MessageT = TypeVar("MessageT", bound=Message)


@dataclass(eq=False, repr=False)
class Subscription(Generic[MessageT]):
    """Receives messages of a type from a topic; made by `Node.create_subscription`."""

    handle: SubscriptionHandle
    msg_type: type[MessageT]
    topic_name: str
    callback: Callable[[MessageT], object]
    qos_profile: QoSProfile

    def __repr__(self) -> str:
        return f"<Subscription of {self.topic_name}>"

    @property
    def topic(self) -> str:
        """The fully qualified name of the topic."""
        return self.topic_name

    def get_publisher_count(self) -> int:
        """Return how many publishers' messages arrive here."""
        return self.handle.matched

    def destroy(self) -> None:
        """Leave the graph; prefer `Node.destroy_subscription`."""
        self.handle.destroy()


AnySubscription: TypeAlias = Subscription[Any]
"""A subscription of messages of any type."""
