"""The messages of `diagnostic_msgs`, generated from their definitions."""

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
from sunset.interfaces.std_msgs.msg import Header

__all__ = [
    "DiagnosticArray",
    "DiagnosticStatus",
    "KeyValue",
]

_STRUCT_0 = Struct("<c")


class KeyValue(Message):
    """diagnostic_msgs/msg/KeyValue."""

    __slots__ = ('key', 'value')
    __ros_name__ = "diagnostic_msgs/msg/KeyValue"
    __ros_fields__ = MappingProxyType({
        "key": "string",
        "value": "string",
    })

    key: str
    value: str

    def __init__(
        self,
        *,
        key: str = "",
        value: str = "",
    ) -> None:
        self.key = key
        self.value = value

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.key = self.key
        new.value = self.value
        return new

    def encode_into(self, out: bytearray) -> None:
        write_string(out, self.key)
        write_string(out, self.value)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.key, position = read_string(raw, position)
        new.value, position = read_string(raw, position)
        return new, position


class DiagnosticStatus(Message):
    """diagnostic_msgs/msg/DiagnosticStatus."""

    __slots__ = ('level', 'name', 'message', 'hardware_id', 'values')
    __ros_name__ = "diagnostic_msgs/msg/DiagnosticStatus"
    __ros_fields__ = MappingProxyType({
        "level": "byte",
        "name": "string",
        "message": "string",
        "hardware_id": "string",
        "values": "diagnostic_msgs/KeyValue[]",
    })

    OK = bytes([0])
    WARN = bytes([1])
    ERROR = bytes([2])
    STALE = bytes([3])

    level: bytes
    name: str
    message: str
    hardware_id: str
    values: list[KeyValue]

    def __init__(
        self,
        *,
        level: bytes = b"\x00",
        name: str = "",
        message: str = "",
        hardware_id: str = "",
        values: list[KeyValue] | None = None,
    ) -> None:
        self.level = level
        self.name = name
        self.message = message
        self.hardware_id = hardware_id
        self.values = [] if values is None else values

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.level = self.level
            new.name = self.name
            new.message = self.message
            new.hardware_id = self.hardware_id
            new.values = [KeyValue.copy(item) for item in self.values]
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        out += _STRUCT_0.pack(
            self.level,
        )
        write_string(out, self.name)
        write_string(out, self.message)
        write_string(out, self.hardware_id)
        write_size(out, len(self.values))
        write_messages(out, self.values, KeyValue)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (
            new.level,
        ) = _STRUCT_0.unpack_from(raw, position)
        position += 1
        new.name, position = read_string(raw, position)
        new.message, position = read_string(raw, position)
        new.hardware_id, position = read_string(raw, position)
        size, position = read_size(raw, position)
        new.values, position = read_messages(raw, position, size, KeyValue)
        return new, position


class DiagnosticArray(Message):
    """diagnostic_msgs/msg/DiagnosticArray."""

    __slots__ = ('header', 'status')
    __ros_name__ = "diagnostic_msgs/msg/DiagnosticArray"
    __ros_fields__ = MappingProxyType({
        "header": "std_msgs/Header",
        "status": "diagnostic_msgs/DiagnosticStatus[]",
    })

    header: Header
    status: list[DiagnosticStatus]

    def __init__(
        self,
        *,
        header: Header | None = None,
        status: list[DiagnosticStatus] | None = None,
    ) -> None:
        self.header = Header() if header is None else header
        self.status = [] if status is None else status

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.header = Header.copy(self.header)
            new.status = [DiagnosticStatus.copy(item) for item in self.status]
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Header.encode_into(self.header, out)
        write_size(out, len(self.status))
        write_messages(out, self.status, DiagnosticStatus)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.header, position = Header.decode_from(raw, position)
        size, position = read_size(raw, position)
        new.status, position = read_messages(raw, position, size, DiagnosticStatus)
        return new, position
