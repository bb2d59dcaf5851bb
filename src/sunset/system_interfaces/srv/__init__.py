"""The services of `system_interfaces`, generated from their definitions."""

from struct import Struct
from types import MappingProxyType
from typing import Self

import numpy as np
import numpy.typing as npt

from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces._codec import *
from sunset_ros.interfaces._message import *
from sunset_ros.interfaces._serialization import *

__all__ = [
    "Redeploy",
]

_STRUCT_0 = Struct("<?")


class Redeploy(Service):
    """system_interfaces/srv/Redeploy."""

    __slots__ = ()
    __ros_name__ = "system_interfaces/srv/Redeploy"

    class Request(Message):
        """system_interfaces/srv/Redeploy_Request."""

        __slots__ = ('node',)
        __ros_name__ = "system_interfaces/srv/Redeploy_Request"
        __ros_fields__ = MappingProxyType({"node": "string"})

        node: str

        def __init__(self, *, node: str = "") -> None:
            self.node = node

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.node = self.node
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_string(out, self.node)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            new.node, position = read_string(raw, position)
            return new, position

    class Response(Message):
        """system_interfaces/srv/Redeploy_Response."""

        __slots__ = ('success', 'message')
        __ros_name__ = "system_interfaces/srv/Redeploy_Response"
        __ros_fields__ = MappingProxyType({"success": "bool", "message": "string"})

        success: bool
        message: str

        def __init__(self, *, success: bool = False, message: str = "") -> None:
            self.success = success
            self.message = message

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.success = self.success
                new.message = self.message
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            out += _STRUCT_0.pack(BOOLS[self.success])
            write_string(out, self.message)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            (new.success, ) = _STRUCT_0.unpack_from(raw, position)
            position += 1
            new.message, position = read_string(raw, position)
            return new, position
