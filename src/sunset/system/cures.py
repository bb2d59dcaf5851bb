"""Whether a cure is in place: the same answer for the score, the experiment's world and the page."""

from collections.abc import Callable, Sequence
from typing import Final

from sunset.system.current import current_system
from sunset.system.description import Adaptation, Fault
from sunset.system.names import full_name
from sunset.texts.names import ros_text

STATE: Final = ""
"""The lifecycle state of a node, in place of a parameter's name."""

Key = tuple[str, str]
"""A node, without namespace, and one of its parameters, or `STATE`."""


def comparable_text(key: Key, value: object) -> str:
    """Return a parameter's value, or a state, for comparison: as ROS writes it, topics by their full names."""
    text = ros_text(value)
    return full_name(text) if key in current_system().topic_parameters else text


def goal_of(step: Adaptation) -> tuple[Key, str] | None:
    """Return the parameter or state that a step of a cure sets, and its value; None for restarts and redeploys."""
    if step.parameter:
        key = step.node, step.parameter
        return key, comparable_text(key, step.value)
    state = step.kind.goal_state
    return None if state is None else ((step.node, STATE), state)


def is_in_place(fault: Fault, cure: Sequence[Adaptation], setting: Callable[[Key], str | None]) -> bool:
    """Return whether a cure of a fault is in place: all of its steps are done, and undo enough of the fault.

    Args:
        fault: a fault.
        cure: one of its cures; a cure with a restart or redeploy is never in place.
        setting: returns the current value, as `comparable_text` writes it; None if it is unknown.
    """
    goals = [goal_of(step) for step in cure]
    amounts = [setting((step.node, fault.parameter)) for step in cure]
    return all(goal is not None and setting(goal[0]) == goal[1] for goal in goals) and fault.is_undone(
        setting((fault.node, fault.parameter)), amounts
    )
