"""The services of `lifecycle_msgs`, generated from their definitions."""

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
from sunset.interfaces.lifecycle_msgs.msg import State
from sunset.interfaces.lifecycle_msgs.msg import Transition
from sunset.interfaces.lifecycle_msgs.msg import TransitionDescription

__all__ = [
    "ChangeState",
    "GetAvailableStates",
    "GetAvailableTransitions",
    "GetState",
]

_STRUCT_0 = Struct("<?")


class ChangeState(Service):
    """lifecycle_msgs/srv/ChangeState."""

    __slots__ = ()
    __ros_name__ = "lifecycle_msgs/srv/ChangeState"

    class Request(Message):
        """lifecycle_msgs/srv/ChangeState_Request."""

        __slots__ = ('transition',)
        __ros_name__ = "lifecycle_msgs/srv/ChangeState_Request"
        __ros_fields__ = MappingProxyType({
            "transition": "lifecycle_msgs/Transition",
        })

        transition: Transition

        def __init__(
            self,
            *,
            transition: Transition | None = None,
        ) -> None:
            self.transition = Transition() if transition is None else transition

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.transition = Transition.copy(self.transition)
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            Transition.encode_into(self.transition, out)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            new.transition, position = Transition.decode_from(raw, position)
            return new, position

    class Response(Message):
        """lifecycle_msgs/srv/ChangeState_Response."""

        __slots__ = ('success',)
        __ros_name__ = "lifecycle_msgs/srv/ChangeState_Response"
        __ros_fields__ = MappingProxyType({
            "success": "bool",
        })

        success: bool

        def __init__(
            self,
            *,
            success: bool = False,
        ) -> None:
            self.success = success

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            new.success = self.success
            return new

        def encode_into(self, out: bytearray) -> None:
            out += _STRUCT_0.pack(
                BOOLS[self.success],
            )

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            (
                new.success,
            ) = _STRUCT_0.unpack_from(raw, position)
            position += 1
            return new, position


class GetAvailableStates(Service):
    """lifecycle_msgs/srv/GetAvailableStates."""

    __slots__ = ()
    __ros_name__ = "lifecycle_msgs/srv/GetAvailableStates"

    class Request(Message):
        """lifecycle_msgs/srv/GetAvailableStates_Request."""

        __slots__ = ()
        __ros_name__ = "lifecycle_msgs/srv/GetAvailableStates_Request"
        __ros_fields__ = MappingProxyType({
        })

        def __init__(self) -> None:
            pass

        def copy(self) -> Self:
            return object.__new__(self.__class__)

        def encode_into(self, out: bytearray) -> None:
            out.append(0)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            return cls(), read_dummy(raw, position)

    class Response(Message):
        """lifecycle_msgs/srv/GetAvailableStates_Response."""

        __slots__ = ('available_states',)
        __ros_name__ = "lifecycle_msgs/srv/GetAvailableStates_Response"
        __ros_fields__ = MappingProxyType({
            "available_states": "lifecycle_msgs/State[]",
        })

        available_states: list[State]

        def __init__(
            self,
            *,
            available_states: list[State] | None = None,
        ) -> None:
            self.available_states = [] if available_states is None else available_states

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.available_states = [State.copy(item) for item in self.available_states]
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_size(out, len(self.available_states))
            write_messages(out, self.available_states, State)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            size, position = read_size(raw, position)
            new.available_states, position = read_messages(raw, position, size, State)
            return new, position


class GetAvailableTransitions(Service):
    """lifecycle_msgs/srv/GetAvailableTransitions."""

    __slots__ = ()
    __ros_name__ = "lifecycle_msgs/srv/GetAvailableTransitions"

    class Request(Message):
        """lifecycle_msgs/srv/GetAvailableTransitions_Request."""

        __slots__ = ()
        __ros_name__ = "lifecycle_msgs/srv/GetAvailableTransitions_Request"
        __ros_fields__ = MappingProxyType({
        })

        def __init__(self) -> None:
            pass

        def copy(self) -> Self:
            return object.__new__(self.__class__)

        def encode_into(self, out: bytearray) -> None:
            out.append(0)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            return cls(), read_dummy(raw, position)

    class Response(Message):
        """lifecycle_msgs/srv/GetAvailableTransitions_Response."""

        __slots__ = ('available_transitions',)
        __ros_name__ = "lifecycle_msgs/srv/GetAvailableTransitions_Response"
        __ros_fields__ = MappingProxyType({
            "available_transitions": "lifecycle_msgs/TransitionDescription[]",
        })

        available_transitions: list[TransitionDescription]

        def __init__(
            self,
            *,
            available_transitions: list[TransitionDescription] | None = None,
        ) -> None:
            self.available_transitions = [] if available_transitions is None else available_transitions

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.available_transitions = [TransitionDescription.copy(item) for item in self.available_transitions]
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_size(out, len(self.available_transitions))
            write_messages(out, self.available_transitions, TransitionDescription)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            size, position = read_size(raw, position)
            new.available_transitions, position = read_messages(raw, position, size, TransitionDescription)
            return new, position


class GetState(Service):
    """lifecycle_msgs/srv/GetState."""

    __slots__ = ()
    __ros_name__ = "lifecycle_msgs/srv/GetState"

    class Request(Message):
        """lifecycle_msgs/srv/GetState_Request."""

        __slots__ = ()
        __ros_name__ = "lifecycle_msgs/srv/GetState_Request"
        __ros_fields__ = MappingProxyType({
        })

        def __init__(self) -> None:
            pass

        def copy(self) -> Self:
            return object.__new__(self.__class__)

        def encode_into(self, out: bytearray) -> None:
            out.append(0)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            return cls(), read_dummy(raw, position)

    class Response(Message):
        """lifecycle_msgs/srv/GetState_Response."""

        __slots__ = ('current_state',)
        __ros_name__ = "lifecycle_msgs/srv/GetState_Response"
        __ros_fields__ = MappingProxyType({
            "current_state": "lifecycle_msgs/State",
        })

        current_state: State

        def __init__(
            self,
            *,
            current_state: State | None = None,
        ) -> None:
            self.current_state = State() if current_state is None else current_state

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.current_state = State.copy(self.current_state)
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            State.encode_into(self.current_state, out)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            new.current_state, position = State.decode_from(raw, position)
            return new, position
