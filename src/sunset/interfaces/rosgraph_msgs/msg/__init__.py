"""The messages of `rosgraph_msgs`, generated from their definitions."""

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
from sunset.interfaces.builtin_interfaces.msg import Time

__all__ = [
    "Clock",
]


class Clock(Message):
    """rosgraph_msgs/msg/Clock."""

    __slots__ = ('clock',)
    __ros_name__ = "rosgraph_msgs/msg/Clock"
    __ros_fields__ = MappingProxyType({
        "clock": "builtin_interfaces/Time",
    })

    clock: Time

    def __init__(
        self,
        *,
        clock: Time | None = None,
    ) -> None:
        self.clock = Time() if clock is None else clock

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.clock = Time.copy(self.clock)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Time.encode_into(self.clock, out)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.clock, position = Time.decode_from(raw, position)
        return new, position
