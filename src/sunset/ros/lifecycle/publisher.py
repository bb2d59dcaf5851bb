"""Publishers that follow their node's lifecycle, as in `rclpy.lifecycle.publisher`."""

from typing import TypeVar

from sunset.interfaces import Message
from sunset.rmw.core.port import PublisherHandle, QoSProfile
from sunset.ros.lifecycle.managed_entity import SimpleManagedEntity
from sunset.ros.publisher import Publisher

MessageT = TypeVar("MessageT", bound=Message)


class LifecyclePublisher(SimpleManagedEntity, Publisher[MessageT]):
    """Sends only while its node is active; made by `LifecycleNode.create_lifecycle_publisher`."""

    def __init__(
        self, handle: PublisherHandle, msg_type: type[MessageT], topic: str, qos_profile: QoSProfile
    ) -> None:
        SimpleManagedEntity.__init__(self)
        Publisher.__init__(self, handle, msg_type, topic, qos_profile)

    def publish(self, msg: MessageT) -> None:
        """Send a message if the node is active, else drop it; see `Publisher.publish`."""
        if self._enabled:
            super().publish(msg)
