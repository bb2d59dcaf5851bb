"""What a lifecycle callback returns."""

from enum import IntEnum

from sunset.interfaces.lifecycle_msgs.msg import Transition


class TransitionCallbackReturn(IntEnum):
    """How a transition went."""

    SUCCESS = Transition.TRANSITION_CALLBACK_SUCCESS
    FAILURE = Transition.TRANSITION_CALLBACK_FAILURE
    ERROR = Transition.TRANSITION_CALLBACK_ERROR

    def to_label(self) -> str:
        """Return the label of the transition that follows, such as `transition_success`."""
        return f"transition_{self.name.lower()}"
