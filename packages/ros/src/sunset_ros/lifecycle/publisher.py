"""Publishers that follow their node's lifecycle, as in `rclpy.lifecycle.publisher`."""

from typing import TypeVar

from sunset_ros.interfaces import Message
from sunset_ros.lifecycle.managed_entity import SimpleManagedEntity
from sunset_ros.publisher import Publisher

MessageT = TypeVar("MessageT", bound=Message)


class LifecyclePublisher(SimpleManagedEntity, Publisher[MessageT]):
    """Sends only while its node is active; made by `LifecycleNode.create_lifecycle_publisher`."""

    def publish(self, msg: MessageT) -> None:
        """Send a message if the node is active, else drop it; see `Publisher.publish`."""
        if self._enabled:
            super().publish(msg)
