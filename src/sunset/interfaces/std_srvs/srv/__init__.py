"""The services of `std_srvs`, generated from their definitions."""

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
    "Empty",
    "SetBool",
    "Trigger",
]

_STRUCT_0 = Struct("<?")


class Empty(Service):
    """std_srvs/srv/Empty."""

    __slots__ = ()
    __ros_name__ = "std_srvs/srv/Empty"

    class Request(Message):
        """std_srvs/srv/Empty_Request."""

        __slots__ = ()
        __ros_name__ = "std_srvs/srv/Empty_Request"
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
        """std_srvs/srv/Empty_Response."""

        __slots__ = ()
        __ros_name__ = "std_srvs/srv/Empty_Response"
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


class SetBool(Service):
    """std_srvs/srv/SetBool."""

    __slots__ = ()
    __ros_name__ = "std_srvs/srv/SetBool"

    class Request(Message):
        """std_srvs/srv/SetBool_Request."""

        __slots__ = ('data',)
        __ros_name__ = "std_srvs/srv/SetBool_Request"
        __ros_fields__ = MappingProxyType({
            "data": "bool",
        })

        data: bool

        def __init__(
            self,
            *,
            data: bool = False,
        ) -> None:
            self.data = data

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            new.data = self.data
            return new

        def encode_into(self, out: bytearray) -> None:
            out += _STRUCT_0.pack(
                BOOLS[self.data],
            )

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            (
                new.data,
            ) = _STRUCT_0.unpack_from(raw, position)
            position += 1
            return new, position

    class Response(Message):
        """std_srvs/srv/SetBool_Response."""

        __slots__ = ('success', 'message')
        __ros_name__ = "std_srvs/srv/SetBool_Response"
        __ros_fields__ = MappingProxyType({
            "success": "bool",
            "message": "string",
        })

        success: bool
        message: str

        def __init__(
            self,
            *,
            success: bool = False,
            message: str = "",
        ) -> None:
            self.success = success
            self.message = message

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            new.success = self.success
            new.message = self.message
            return new

        def encode_into(self, out: bytearray) -> None:
            out += _STRUCT_0.pack(
                BOOLS[self.success],
            )
            write_string(out, self.message)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            (
                new.success,
            ) = _STRUCT_0.unpack_from(raw, position)
            position += 1
            new.message, position = read_string(raw, position)
            return new, position


class Trigger(Service):
    """std_srvs/srv/Trigger."""

    __slots__ = ()
    __ros_name__ = "std_srvs/srv/Trigger"

    class Request(Message):
        """std_srvs/srv/Trigger_Request."""

        __slots__ = ()
        __ros_name__ = "std_srvs/srv/Trigger_Request"
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
        """std_srvs/srv/Trigger_Response."""

        __slots__ = ('success', 'message')
        __ros_name__ = "std_srvs/srv/Trigger_Response"
        __ros_fields__ = MappingProxyType({
            "success": "bool",
            "message": "string",
        })

        success: bool
        message: str

        def __init__(
            self,
            *,
            success: bool = False,
            message: str = "",
        ) -> None:
            self.success = success
            self.message = message

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            new.success = self.success
            new.message = self.message
            return new

        def encode_into(self, out: bytearray) -> None:
            out += _STRUCT_0.pack(
                BOOLS[self.success],
            )
            write_string(out, self.message)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            (
                new.success,
            ) = _STRUCT_0.unpack_from(raw, position)
            position += 1
            new.message, position = read_string(raw, position)
            return new, position
