"""Parts of a node that follow its lifecycle, as in `rclpy.lifecycle`."""

from typing import TypeVar

from sunset_ros.interfaces import Message
from sunset_ros.lifecycle._state_machine import LifecycleState, TransitionCallbackReturn
from sunset_ros.publisher import Publisher

MessageT = TypeVar("MessageT", bound=Message)


class ManagedEntity:
    """A part of a node that takes part in its transitions; each method takes the state before."""

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """Succeed, as the methods for the other transitions."""
        return TransitionCallbackReturn.SUCCESS

    on_cleanup = on_shutdown = on_activate = on_deactivate = on_error = on_configure


class SimpleManagedEntity(ManagedEntity):
    """A part that works while its node is active."""

    _enabled = False

    @property
    def is_activated(self) -> bool:
        """Whether it works."""
        return self._enabled

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start to work."""
        self._enabled = True
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop working."""
        self._enabled = False
        return super().on_deactivate(state)


class LifecyclePublisher(SimpleManagedEntity, Publisher[MessageT]):
    """Sends only while its node is active; made by `LifecycleNode.create_lifecycle_publisher`."""

    def publish(self, msg: MessageT) -> None:
        """Send a message if the node is active, else drop it; see `Publisher.publish`."""
        if self._enabled:
            super().publish(msg)
