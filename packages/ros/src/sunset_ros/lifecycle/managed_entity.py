"""Parts of a node that follow its lifecycle, as in `rclpy.lifecycle.managed_entity`."""

from sunset_ros.lifecycle._state_machine import LifecycleState, TransitionCallbackReturn


class ManagedEntity:
    """A part of a node that takes part in its transitions; each method takes the state before."""

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """Get ready."""
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """Undo `on_configure`."""
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """End."""
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """Start to work."""
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """Undo `on_activate`."""
        return TransitionCallbackReturn.SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """Clean up after an error."""
        return TransitionCallbackReturn.SUCCESS


class SimpleManagedEntity(ManagedEntity):
    """A part that works while its node is active."""

    _enabled = False

    @property
    def is_activated(self) -> bool:
        """Whether it works."""
        return self._enabled

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  the same from all
        """Start to work."""
        self._enabled = True
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  the same from all
        """Stop working."""
        self._enabled = False
        return TransitionCallbackReturn.SUCCESS
