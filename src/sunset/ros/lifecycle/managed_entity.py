"""Parts of a node that follow its lifecycle, as in `rclpy.lifecycle.managed_entity`."""

from sunset.ros.lifecycle._state_machine import LifecycleState, TransitionCallbackReturn


class ManagedEntity:
    """A part of a node that is told of the node's transitions."""

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """Get ready; `state` is the one before."""
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """Undo `on_configure`; `state` is the one before."""
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """End; `state` is the one before."""
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """Start to work; `state` is the one before."""
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """Undo `on_activate`; `state` is the one before."""
        return TransitionCallbackReturn.SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:  # noqa: ARG002  for subclasses
        """Clean up after an error; `state` is the one before the failed transition."""
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
