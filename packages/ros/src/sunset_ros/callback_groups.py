"""Callback groups, as in `rclpy.callback_groups`.

A process has a single thread of callbacks, so callbacks of any group never run at the same time. A callback
that is a coroutine leaves the thread to others wherever it awaits, also of its own group; rclpy keeps a
mutually exclusive group until the coroutine ends. The classes are there so that node code keeps its rclpy form.
"""


class CallbackGroup:
    """A set of callbacks of a node."""


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """Callbacks that never run at the same time."""


class ReentrantCallbackGroup(CallbackGroup):
    """Callbacks that might run at the same time, but do not here."""
