"""Callback groups, as in `rclpy.callback_groups`.

A process has one thread of callbacks, so every group is mutually exclusive; the classes are there so that
node code keeps its rclpy form.
"""

__all__ = ["CallbackGroup", "MutuallyExclusiveCallbackGroup", "ReentrantCallbackGroup"]


class CallbackGroup:
    """A set of callbacks of one node."""


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """Callbacks that never run at the same time."""


class ReentrantCallbackGroup(CallbackGroup):
    """Callbacks that might run at the same time, but do not here."""
