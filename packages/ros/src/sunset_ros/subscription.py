"""Subscriptions, as in `rclpy.subscription`."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeVar

from sunset_ros.interfaces import Message
from sunset_ros.publisher import TopicEndpoint
from sunset_ros.rmw.core.node import SubscriptionHandle

MessageT = TypeVar("MessageT", bound=Message)


@dataclass(eq=False, repr=False)
class Subscription(TopicEndpoint[MessageT]):
    """Receives messages of a type from a topic; made by `Node.create_subscription`."""

    handle: SubscriptionHandle
    callback: Callable[[MessageT], object]

    def get_publisher_count(self) -> int:
        """Return how many publishers' messages arrive here."""
        return self.handle.matched


AnySubscription: TypeAlias = Subscription[Any]
"""A subscription of messages of any type."""
