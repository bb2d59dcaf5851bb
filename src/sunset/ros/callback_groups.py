"""Callback groups, as in `rclpy.callback_groups`.

A process has one thread of callbacks, so no two of them run at the same time, whatever their groups. A callback
that is a coroutine leaves the thread to others wherever it awaits, those of its own group too; rclpy keeps a
mutually exclusive group until the coroutine ends. The classes are there so that node code keeps its rclpy form.
"""


class CallbackGroup:
    """A set of callbacks of one node."""


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """Callbacks that never run at the same time."""


class ReentrantCallbackGroup(CallbackGroup):
    """Callbacks that might run at the same time, but do not here."""
