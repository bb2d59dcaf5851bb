"""The messages of `geometry_msgs`, generated from their definitions."""

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
    "Quaternion",
    "Transform",
    "TransformStamped",
    "Vector3",
]

_STRUCT_0 = Struct("<dddd")
_STRUCT_1 = Struct("<ddd")


class Quaternion(Message):
    """geometry_msgs/msg/Quaternion."""

    __slots__ = ('x', 'y', 'z', 'w')
    __ros_name__ = "geometry_msgs/msg/Quaternion"
    __ros_fields__ = MappingProxyType({
        "x": "float64",
        "y": "float64",
        "z": "float64",
        "w": "float64",
    })

    x: float
    y: float
    z: float
    w: float

    def __init__(
        self,
        *,
        x: float = 0.0,
        y: float = 0.0,
        z: float = 0.0,
        w: float = 1.0,
    ) -> None:
        self.x = x
        self.y = y
        self.z = z
        self.w = w

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.x = self.x
        new.y = self.y
        new.z = self.z
        new.w = self.w
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD8[len(out) & 7]
        out += _STRUCT_0.pack(
            self.x,
            self.y,
            self.z,
            self.w,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = ((position + 3) & -8) + 4
        (
            new.x,
            new.y,
            new.z,
            new.w,
        ) = _STRUCT_0.unpack_from(raw, position)
        position += 32
        return new, position


class Vector3(Message):
    """geometry_msgs/msg/Vector3."""

    __slots__ = ('x', 'y', 'z')
    __ros_name__ = "geometry_msgs/msg/Vector3"
    __ros_fields__ = MappingProxyType({
        "x": "float64",
        "y": "float64",
        "z": "float64",
    })

    x: float
    y: float
    z: float

    def __init__(
        self,
        *,
        x: float = 0.0,
        y: float = 0.0,
        z: float = 0.0,
    ) -> None:
        self.x = x
        self.y = y
        self.z = z

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.x = self.x
        new.y = self.y
        new.z = self.z
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD8[len(out) & 7]
        out += _STRUCT_1.pack(
            self.x,
            self.y,
            self.z,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = ((position + 3) & -8) + 4
        (
            new.x,
            new.y,
            new.z,
        ) = _STRUCT_1.unpack_from(raw, position)
        position += 24
        return new, position


class Transform(Message):
    """geometry_msgs/msg/Transform."""

    __slots__ = ('translation', 'rotation')
    __ros_name__ = "geometry_msgs/msg/Transform"
    __ros_fields__ = MappingProxyType({
        "translation": "geometry_msgs/Vector3",
        "rotation": "geometry_msgs/Quaternion",
    })

    translation: Vector3
    rotation: Quaternion

    def __init__(
        self,
        *,
        translation: Vector3 | None = None,
        rotation: Quaternion | None = None,
    ) -> None:
        self.translation = Vector3() if translation is None else translation
        self.rotation = Quaternion() if rotation is None else rotation

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.translation = Vector3.copy(self.translation)
            new.rotation = Quaternion.copy(self.rotation)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Vector3.encode_into(self.translation, out)
        Quaternion.encode_into(self.rotation, out)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.translation, position = Vector3.decode_from(raw, position)
        new.rotation, position = Quaternion.decode_from(raw, position)
        return new, position


class TransformStamped(Message):
    """geometry_msgs/msg/TransformStamped."""

    __slots__ = ('header', 'child_frame_id', 'transform')
    __ros_name__ = "geometry_msgs/msg/TransformStamped"
    __ros_fields__ = MappingProxyType({
        "header": "std_msgs/Header",
        "child_frame_id": "string",
        "transform": "geometry_msgs/Transform",
    })

    header: Header
    child_frame_id: str
    transform: Transform

    def __init__(
        self,
        *,
        header: Header | None = None,
        child_frame_id: str = "",
        transform: Transform | None = None,
    ) -> None:
        self.header = Header() if header is None else header
        self.child_frame_id = child_frame_id
        self.transform = Transform() if transform is None else transform

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.header = Header.copy(self.header)
            new.child_frame_id = self.child_frame_id
            new.transform = Transform.copy(self.transform)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Header.encode_into(self.header, out)
        write_string(out, self.child_frame_id)
        Transform.encode_into(self.transform, out)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.header, position = Header.decode_from(raw, position)
        new.child_frame_id, position = read_string(raw, position)
        new.transform, position = Transform.decode_from(raw, position)
        return new, position
