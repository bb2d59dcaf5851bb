"""Publishers, as in `rclpy.publisher`."""

from dataclasses import dataclass
from typing import Any, Generic, TypeAlias, TypeVar

from sunset_ros.interfaces import Message
from sunset_ros.rmw.core.node import PublisherHandle, SubscriptionHandle
from sunset_ros.rmw.core.qos import QoSProfile

MessageT = TypeVar("MessageT", bound=Message)


@dataclass(eq=False, repr=False)
class TopicEndpoint(Generic[MessageT]):
    """A publisher or a subscription."""

    handle: PublisherHandle | SubscriptionHandle
    msg_type: type[MessageT]
    topic_name: str
    qos_profile: QoSProfile

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.topic_name}>"

    @property
    def topic(self) -> str:
        """The fully qualified name of the topic."""
        return self.topic_name

    def destroy(self) -> None:
        """Leave the graph; prefer `Node.destroy_publisher` and `Node.destroy_subscription`."""
        self.handle.destroy()


class Publisher(TopicEndpoint[MessageT]):
    """Sends messages of a type on a topic; made by `Node.create_publisher`."""

    handle: PublisherHandle

    def publish(self, msg: MessageT) -> None:
        """Send a message. It may be changed afterwards, but arrays in it become read-only.

        Raise a `TypeError` for a message of another type, and a `MiddlewareError` once the publisher is destroyed.
        """
        if not isinstance(msg, self.msg_type):
            raise TypeError(
                f"Topic {self.topic_name} carries {self.msg_type.__name__}, got {type(msg).__name__}."
            )
        self.handle.publish(msg)

    def get_subscription_count(self) -> int:
        """Return the number of subscriptions that receive the messages."""
        return self.handle.matched


AnyPublisher: TypeAlias = Publisher[Any]
"""A publisher of messages of any type."""
