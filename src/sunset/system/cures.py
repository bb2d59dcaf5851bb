"""When a cure is in place: one answer for the score, for the world that an experiment plays, and for the page."""

from collections.abc import Callable, Sequence
from typing import Final

from sunset.names import ros_text
from sunset.system.current import current_system
from sunset.system.description import Adaptation, Fault
from sunset.system.names import full_name

STATE: Final = ""
"""What stands in the place of a parameter's name for a node's lifecycle state."""

Key = tuple[str, str]
"""A node, without namespace, and a parameter of it, or `STATE`."""


def comparable_text(key: Key, value: object) -> str:
    """Return a parameter's value, or a state, as it is compared: as ROS writes it, a topic by its full name."""
    text = ros_text(value)
    return full_name(text) if key in current_system().topic_parameters else text


def goal_of(step: Adaptation) -> tuple[Key, str] | None:
    """Return what a step of a cure sets, and to what; None of a restart and a redeploy, which set nothing."""
    if step.parameter:
        key = step.node, step.parameter
        return key, comparable_text(key, step.value)
    state = step.kind.goal_state
    return None if state is None else ((step.node, STATE), state)


def is_in_place(fault: Fault, cure: Sequence[Adaptation], setting: Callable[[Key], str | None]) -> bool:
    """Return whether a cure of a fault is in place: all of its steps are done, and undo enough of the fault.

    Args:
        fault: a fault.
        cure: one of its cures; without a goal of every step it is never in place.
        setting: returns what is set, as `comparable_text` writes it; None if that is not known.
    """
    goals = [goal_of(step) for step in cure]
    amounts = [setting((step.node, fault.parameter)) for step in cure]
    return all(goal is not None and setting(goal[0]) == goal[1] for goal in goals) and fault.is_undone(
        setting((fault.node, fault.parameter)), amounts
    )
