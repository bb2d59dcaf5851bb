"""The messages of `tf2_msgs`, generated from their definitions."""

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
from sunset.interfaces.geometry_msgs.msg import TransformStamped

__all__ = [
    "TFMessage",
]


class TFMessage(Message):
    """tf2_msgs/msg/TFMessage."""

    __slots__ = ('transforms',)
    __ros_name__ = "tf2_msgs/msg/TFMessage"
    __ros_fields__ = MappingProxyType({
        "transforms": "geometry_msgs/TransformStamped[]",
    })

    transforms: list[TransformStamped]

    def __init__(
        self,
        *,
        transforms: list[TransformStamped] | None = None,
    ) -> None:
        self.transforms = [] if transforms is None else transforms

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.transforms = [TransformStamped.copy(item) for item in self.transforms]
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        write_size(out, len(self.transforms))
        write_messages(out, self.transforms, TransformStamped)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        size, position = read_size(raw, position)
        new.transforms, position = read_messages(raw, position, size, TransformStamped)
        return new, position
