"""The messages of `builtin_interfaces`, generated from their definitions."""

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
    "Duration",
    "Time",
]

_STRUCT_0 = Struct("<iI")


class Duration(Message):
    """builtin_interfaces/msg/Duration."""

    __slots__ = ('sec', 'nanosec')
    __ros_name__ = "builtin_interfaces/msg/Duration"
    __ros_fields__ = MappingProxyType({
        "sec": "int32",
        "nanosec": "uint32",
    })

    sec: int
    nanosec: int

    def __init__(
        self,
        *,
        sec: int = 0,
        nanosec: int = 0,
    ) -> None:
        self.sec = sec
        self.nanosec = nanosec

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.sec = self.sec
        new.nanosec = self.nanosec
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD4[len(out) & 3]
        out += _STRUCT_0.pack(
            self.sec,
            self.nanosec,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = (position + 3) & -4
        (
            new.sec,
            new.nanosec,
        ) = _STRUCT_0.unpack_from(raw, position)
        position += 8
        return new, position


class Time(Message):
    """builtin_interfaces/msg/Time."""

    __slots__ = ('sec', 'nanosec')
    __ros_name__ = "builtin_interfaces/msg/Time"
    __ros_fields__ = MappingProxyType({
        "sec": "int32",
        "nanosec": "uint32",
    })

    sec: int
    nanosec: int

    def __init__(
        self,
        *,
        sec: int = 0,
        nanosec: int = 0,
    ) -> None:
        self.sec = sec
        self.nanosec = nanosec

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.sec = self.sec
        new.nanosec = self.nanosec
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD4[len(out) & 3]
        out += _STRUCT_0.pack(
            self.sec,
            self.nanosec,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = (position + 3) & -4
        (
            new.sec,
            new.nanosec,
        ) = _STRUCT_0.unpack_from(raw, position)
        position += 8
        return new, position
