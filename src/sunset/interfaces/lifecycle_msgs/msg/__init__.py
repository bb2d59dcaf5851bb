"""The messages of `lifecycle_msgs`, generated from their definitions."""

from struct import Struct
from types import MappingProxyType
from typing import Self

import numpy as np
import numpy.typing as npt

from sunset.common.errors import InterfaceError
from sunset.interfaces._check import *
from sunset.interfaces._codec import *
from sunset.interfaces._message import *
from sunset.interfaces._values import *

__all__ = [
    "State",
    "Transition",
    "TransitionDescription",
    "TransitionEvent",
]

_STRUCT_0 = Struct("<B")
_STRUCT_1 = Struct("<Q")


class State(Message):
    """lifecycle_msgs/msg/State."""

    __slots__ = ('id', 'label')
    __ros_name__ = "lifecycle_msgs/msg/State"
    __ros_fields__ = MappingProxyType({
        "id": "uint8",
        "label": "string",
    })

    PRIMARY_STATE_UNKNOWN = 0
    PRIMARY_STATE_UNCONFIGURED = 1
    PRIMARY_STATE_INACTIVE = 2
    PRIMARY_STATE_ACTIVE = 3
    PRIMARY_STATE_FINALIZED = 4
    TRANSITION_STATE_CONFIGURING = 10
    TRANSITION_STATE_CLEANINGUP = 11
    TRANSITION_STATE_SHUTTINGDOWN = 12
    TRANSITION_STATE_ACTIVATING = 13
    TRANSITION_STATE_DEACTIVATING = 14
    TRANSITION_STATE_ERRORPROCESSING = 15

    id: int
    label: str

    def __init__(
        self,
        *,
        id: int = 0,
        label: str = "",
    ) -> None:
        self.id = id
        self.label = label

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.id = self.id
        new.label = self.label
        return new

    def encode_into(self, out: bytearray) -> None:
        out += _STRUCT_0.pack(
            self.id,
        )
        write_string(out, self.label)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (
            new.id,
        ) = _STRUCT_0.unpack_from(raw, position)
        position += 1
        new.label, position = read_string(raw, position)
        return new, position


class Transition(Message):
    """lifecycle_msgs/msg/Transition."""

    __slots__ = ('id', 'label')
    __ros_name__ = "lifecycle_msgs/msg/Transition"
    __ros_fields__ = MappingProxyType({
        "id": "uint8",
        "label": "string",
    })

    TRANSITION_CREATE = 0
    TRANSITION_CONFIGURE = 1
    TRANSITION_CLEANUP = 2
    TRANSITION_ACTIVATE = 3
    TRANSITION_DEACTIVATE = 4
    TRANSITION_UNCONFIGURED_SHUTDOWN = 5
    TRANSITION_INACTIVE_SHUTDOWN = 6
    TRANSITION_ACTIVE_SHUTDOWN = 7
    TRANSITION_DESTROY = 8
    TRANSITION_ON_CONFIGURE_SUCCESS = 10
    TRANSITION_ON_CONFIGURE_FAILURE = 11
    TRANSITION_ON_CONFIGURE_ERROR = 12
    TRANSITION_ON_CLEANUP_SUCCESS = 20
    TRANSITION_ON_CLEANUP_FAILURE = 21
    TRANSITION_ON_CLEANUP_ERROR = 22
    TRANSITION_ON_ACTIVATE_SUCCESS = 30
    TRANSITION_ON_ACTIVATE_FAILURE = 31
    TRANSITION_ON_ACTIVATE_ERROR = 32
    TRANSITION_ON_DEACTIVATE_SUCCESS = 40
    TRANSITION_ON_DEACTIVATE_FAILURE = 41
    TRANSITION_ON_DEACTIVATE_ERROR = 42
    TRANSITION_ON_SHUTDOWN_SUCCESS = 50
    TRANSITION_ON_SHUTDOWN_FAILURE = 51
    TRANSITION_ON_SHUTDOWN_ERROR = 52
    TRANSITION_ON_ERROR_SUCCESS = 60
    TRANSITION_ON_ERROR_FAILURE = 61
    TRANSITION_ON_ERROR_ERROR = 62
    TRANSITION_CALLBACK_SUCCESS = 97
    TRANSITION_CALLBACK_FAILURE = 98
    TRANSITION_CALLBACK_ERROR = 99

    id: int
    label: str

    def __init__(
        self,
        *,
        id: int = 0,
        label: str = "",
    ) -> None:
        self.id = id
        self.label = label

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.id = self.id
        new.label = self.label
        return new

    def encode_into(self, out: bytearray) -> None:
        out += _STRUCT_0.pack(
            self.id,
        )
        write_string(out, self.label)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (
            new.id,
        ) = _STRUCT_0.unpack_from(raw, position)
        position += 1
        new.label, position = read_string(raw, position)
        return new, position


class TransitionDescription(Message):
    """lifecycle_msgs/msg/TransitionDescription."""

    __slots__ = ('transition', 'start_state', 'goal_state')
    __ros_name__ = "lifecycle_msgs/msg/TransitionDescription"
    __ros_fields__ = MappingProxyType({
        "transition": "lifecycle_msgs/Transition",
        "start_state": "lifecycle_msgs/State",
        "goal_state": "lifecycle_msgs/State",
    })

    transition: Transition
    start_state: State
    goal_state: State

    def __init__(
        self,
        *,
        transition: Transition | None = None,
        start_state: State | None = None,
        goal_state: State | None = None,
    ) -> None:
        self.transition = Transition() if transition is None else transition
        self.start_state = State() if start_state is None else start_state
        self.goal_state = State() if goal_state is None else goal_state

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.transition = Transition.copy(self.transition)
            new.start_state = State.copy(self.start_state)
            new.goal_state = State.copy(self.goal_state)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Transition.encode_into(self.transition, out)
        State.encode_into(self.start_state, out)
        State.encode_into(self.goal_state, out)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.transition, position = Transition.decode_from(raw, position)
        new.start_state, position = State.decode_from(raw, position)
        new.goal_state, position = State.decode_from(raw, position)
        return new, position


class TransitionEvent(Message):
    """lifecycle_msgs/msg/TransitionEvent."""

    __slots__ = ('timestamp', 'transition', 'start_state', 'goal_state')
    __ros_name__ = "lifecycle_msgs/msg/TransitionEvent"
    __ros_fields__ = MappingProxyType({
        "timestamp": "uint64",
        "transition": "lifecycle_msgs/Transition",
        "start_state": "lifecycle_msgs/State",
        "goal_state": "lifecycle_msgs/State",
    })

    timestamp: int
    transition: Transition
    start_state: State
    goal_state: State

    def __init__(
        self,
        *,
        timestamp: int = 0,
        transition: Transition | None = None,
        start_state: State | None = None,
        goal_state: State | None = None,
    ) -> None:
        self.timestamp = timestamp
        self.transition = Transition() if transition is None else transition
        self.start_state = State() if start_state is None else start_state
        self.goal_state = State() if goal_state is None else goal_state

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.timestamp = self.timestamp
            new.transition = Transition.copy(self.transition)
            new.start_state = State.copy(self.start_state)
            new.goal_state = State.copy(self.goal_state)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD8[len(out) & 7]
        out += _STRUCT_1.pack(
            self.timestamp,
        )
        Transition.encode_into(self.transition, out)
        State.encode_into(self.start_state, out)
        State.encode_into(self.goal_state, out)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = ((position + 3) & -8) + 4
        (
            new.timestamp,
        ) = _STRUCT_1.unpack_from(raw, position)
        position += 8
        new.transition, position = Transition.decode_from(raw, position)
        new.start_state, position = State.decode_from(raw, position)
        new.goal_state, position = State.decode_from(raw, position)
        return new, position
