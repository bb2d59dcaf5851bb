"""The lifecycle of managed nodes: its states and transitions.

See https://design.ros2.org/articles/node_lifecycle.html; ids and labels are as in lifecycle_msgs.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Final, NamedTuple

from sunset_ros.interfaces.lifecycle_msgs.msg import State as StateMessage
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition as TransitionMessage
from sunset_ros.interfaces.lifecycle_msgs.msg import TransitionDescription


class LifecycleState(NamedTuple):
    """A state of the lifecycle."""

    label: str
    state_id: int


@dataclass(frozen=True, slots=True)
class Transition:
    """A transition between two states.

    Several may have the same label. `start` and `goal` are ids of states; the goal of a requested transition is an
    intermediate state.
    """

    id: int
    label: str
    start: int
    goal: int

    def to_msg(self) -> TransitionDescription:
        """Return it as a message."""
        return TransitionDescription(
            transition=TransitionMessage(id=self.id, label=self.label),
            start_state=state_message(self.start),
            goal_state=state_message(self.goal),
        )


STATES: Final = {
    number: LifecycleState(label, number)
    for number, label in {
        0: "unknown",
        1: "unconfigured",
        2: "inactive",
        3: "active",
        4: "finalized",
        10: "configuring",
        11: "cleaningup",
        12: "shuttingdown",
        13: "activating",
        14: "deactivating",
        15: "errorprocessing",
    }.items()
}
"""Id → state. Those from 10 on are intermediate: they last as long as a callback does."""


def state_message(state_id: int) -> StateMessage:
    """Return the message of a state."""
    return StateMessage(id=state_id, label=STATES[state_id].label)


class TransitionCallbackReturn(IntEnum):
    """The outcome of a transition, which a lifecycle callback returns."""

    SUCCESS = TransitionMessage.TRANSITION_CALLBACK_SUCCESS
    FAILURE = TransitionMessage.TRANSITION_CALLBACK_FAILURE
    ERROR = TransitionMessage.TRANSITION_CALLBACK_ERROR

    def to_label(self) -> str:
        """Return the label of the transition that follows, such as `transition_success`."""
        return f"transition_{self.name.lower()}"


def _outcomes(first_id: int, start: int, success: int, failure: int, error: int) -> tuple[Transition, ...]:
    goals = zip(TransitionCallbackReturn, (success, failure, error), strict=True)
    return tuple(
        Transition(first_id + place, outcome.to_label(), start, goal)
        for place, (outcome, goal) in enumerate(goals)
    )


TRANSITIONS: Final = (
    Transition(1, "configure", 1, 10),
    *_outcomes(10, 10, success=2, failure=1, error=15),
    Transition(2, "cleanup", 2, 11),
    *_outcomes(20, 11, success=1, failure=2, error=15),
    Transition(3, "activate", 2, 13),
    *_outcomes(30, 13, success=3, failure=2, error=15),
    Transition(4, "deactivate", 3, 14),
    *_outcomes(40, 14, success=2, failure=3, error=15),
    Transition(5, "shutdown", 1, 12),
    Transition(6, "shutdown", 2, 12),
    Transition(7, "shutdown", 3, 12),
    *_outcomes(50, 12, success=4, failure=4, error=15),
    *_outcomes(60, 15, success=1, failure=4, error=4),
)
"""All transitions, each beside the outcomes of its intermediate state."""


class StateMachine:
    """The state of a node."""

    def __init__(self) -> None:
        self._state_id = StateMessage.PRIMARY_STATE_UNCONFIGURED

    @property
    def current_state(self) -> tuple[int, str]:
        """Id and label of the state."""
        return self._state_id, STATES[self._state_id].label

    @property
    def state(self) -> LifecycleState:
        """The state."""
        return STATES[self._state_id]

    @property
    def available_transitions(self) -> list[Transition]:
        """The transitions that leave the state."""
        return [transition for transition in TRANSITIONS if transition.start == self._state_id]

    def find(self, label: str = "", transition_id: int = 0) -> Transition | None:
        """Return the transition that leaves the state and has a label, or, if that is empty, an id."""
        transitions = self.available_transitions
        matching = (
            each for each in transitions if (each.label == label if label else each.id == transition_id)
        )
        return next(matching, None)

    def take(self, transition: Transition) -> None:
        """Enter the goal of a transition that leaves the state."""
        self._state_id = transition.goal
