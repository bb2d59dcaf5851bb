"""The messages of `std_msgs`, generated from their definitions."""

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
    "Bool",
    "Empty",
    "Float32",
    "Float64",
    "Float64MultiArray",
    "Header",
    "Int32",
    "Int8",
    "MultiArrayDimension",
    "MultiArrayLayout",
    "String",
    "UInt64",
]

_STRUCT_0 = Struct("<?")
_STRUCT_1 = Struct("<f")
_STRUCT_2 = Struct("<d")
_STRUCT_3 = Struct("<II")
_STRUCT_4 = Struct("<I")
_STRUCT_5 = Struct("<i")
_STRUCT_6 = Struct("<b")
_STRUCT_7 = Struct("<Q")


class Bool(Message):
    """std_msgs/msg/Bool."""

    __slots__ = ('data',)
    __ros_name__ = "std_msgs/msg/Bool"
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


class Empty(Message):
    """std_msgs/msg/Empty."""

    __slots__ = ()
    __ros_name__ = "std_msgs/msg/Empty"
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


class Float32(Message):
    """std_msgs/msg/Float32."""

    __slots__ = ('data',)
    __ros_name__ = "std_msgs/msg/Float32"
    __ros_fields__ = MappingProxyType({
        "data": "float32",
    })

    data: float

    def __init__(
        self,
        *,
        data: float = 0.0,
    ) -> None:
        self.data = data

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.data = self.data
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD4[len(out) & 3]
        out += _STRUCT_1.pack(
            self.data,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = (position + 3) & -4
        (
            new.data,
        ) = _STRUCT_1.unpack_from(raw, position)
        position += 4
        return new, position


class Float64(Message):
    """std_msgs/msg/Float64."""

    __slots__ = ('data',)
    __ros_name__ = "std_msgs/msg/Float64"
    __ros_fields__ = MappingProxyType({
        "data": "float64",
    })

    data: float

    def __init__(
        self,
        *,
        data: float = 0.0,
    ) -> None:
        self.data = data

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.data = self.data
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD8[len(out) & 7]
        out += _STRUCT_2.pack(
            self.data,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = ((position + 3) & -8) + 4
        (
            new.data,
        ) = _STRUCT_2.unpack_from(raw, position)
        position += 8
        return new, position


class MultiArrayDimension(Message):
    """std_msgs/msg/MultiArrayDimension."""

    __slots__ = ('label', 'size', 'stride')
    __ros_name__ = "std_msgs/msg/MultiArrayDimension"
    __ros_fields__ = MappingProxyType({
        "label": "string",
        "size": "uint32",
        "stride": "uint32",
    })

    label: str
    size: int
    stride: int

    def __init__(
        self,
        *,
        label: str = "",
        size: int = 0,
        stride: int = 0,
    ) -> None:
        self.label = label
        self.size = size
        self.stride = stride

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.label = self.label
        new.size = self.size
        new.stride = self.stride
        return new

    def encode_into(self, out: bytearray) -> None:
        write_string(out, self.label)
        out += PAD4[len(out) & 3]
        out += _STRUCT_3.pack(
            self.size,
            self.stride,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.label, position = read_string(raw, position)
        position = (position + 3) & -4
        (
            new.size,
            new.stride,
        ) = _STRUCT_3.unpack_from(raw, position)
        position += 8
        return new, position


class MultiArrayLayout(Message):
    """std_msgs/msg/MultiArrayLayout."""

    __slots__ = ('dim', 'data_offset')
    __ros_name__ = "std_msgs/msg/MultiArrayLayout"
    __ros_fields__ = MappingProxyType({
        "dim": "std_msgs/MultiArrayDimension[]",
        "data_offset": "uint32",
    })

    dim: list[MultiArrayDimension]
    data_offset: int

    def __init__(
        self,
        *,
        dim: list[MultiArrayDimension] | None = None,
        data_offset: int = 0,
    ) -> None:
        self.dim = [] if dim is None else dim
        self.data_offset = data_offset

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.dim = [MultiArrayDimension.copy(item) for item in self.dim]
            new.data_offset = self.data_offset
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        write_size(out, len(self.dim))
        write_messages(out, self.dim, MultiArrayDimension)
        out += PAD4[len(out) & 3]
        out += _STRUCT_4.pack(
            self.data_offset,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        size, position = read_size(raw, position)
        new.dim, position = read_messages(raw, position, size, MultiArrayDimension)
        position = (position + 3) & -4
        (
            new.data_offset,
        ) = _STRUCT_4.unpack_from(raw, position)
        position += 4
        return new, position


class Float64MultiArray(Message):
    """std_msgs/msg/Float64MultiArray."""

    __slots__ = ('layout', 'data')
    __ros_name__ = "std_msgs/msg/Float64MultiArray"
    __ros_fields__ = MappingProxyType({
        "layout": "std_msgs/MultiArrayLayout",
        "data": "float64[]",
    })

    layout: MultiArrayLayout
    data: npt.NDArray[np.float64]

    def __init__(
        self,
        *,
        layout: MultiArrayLayout | None = None,
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.layout = MultiArrayLayout() if layout is None else layout
        self.data = empty(FLOAT64) if data is None else array_of(data, FLOAT64)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.layout = MultiArrayLayout.copy(self.layout)
            new.data = frozen(self.data, FLOAT64)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        MultiArrayLayout.encode_into(self.layout, out)
        write_array(out, self.data, FLOAT64)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.layout, position = MultiArrayLayout.decode_from(raw, position)
        new.data, position = read_array(raw, position, FLOAT64)
        return new, position


class Header(Message):
    """std_msgs/msg/Header."""

    __slots__ = ('stamp', 'frame_id')
    __ros_name__ = "std_msgs/msg/Header"
    __ros_fields__ = MappingProxyType({
        "stamp": "builtin_interfaces/Time",
        "frame_id": "string",
    })

    stamp: Time
    frame_id: str

    def __init__(
        self,
        *,
        stamp: Time | None = None,
        frame_id: str = "",
    ) -> None:
        self.stamp = Time() if stamp is None else stamp
        self.frame_id = frame_id

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.stamp = Time.copy(self.stamp)
            new.frame_id = self.frame_id
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Time.encode_into(self.stamp, out)
        write_string(out, self.frame_id)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.stamp, position = Time.decode_from(raw, position)
        new.frame_id, position = read_string(raw, position)
        return new, position


class Int32(Message):
    """std_msgs/msg/Int32."""

    __slots__ = ('data',)
    __ros_name__ = "std_msgs/msg/Int32"
    __ros_fields__ = MappingProxyType({
        "data": "int32",
    })

    data: int

    def __init__(
        self,
        *,
        data: int = 0,
    ) -> None:
        self.data = data

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.data = self.data
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD4[len(out) & 3]
        out += _STRUCT_5.pack(
            self.data,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = (position + 3) & -4
        (
            new.data,
        ) = _STRUCT_5.unpack_from(raw, position)
        position += 4
        return new, position


class Int8(Message):
    """std_msgs/msg/Int8."""

    __slots__ = ('data',)
    __ros_name__ = "std_msgs/msg/Int8"
    __ros_fields__ = MappingProxyType({
        "data": "int8",
    })

    data: int

    def __init__(
        self,
        *,
        data: int = 0,
    ) -> None:
        self.data = data

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.data = self.data
        return new

    def encode_into(self, out: bytearray) -> None:
        out += _STRUCT_6.pack(
            self.data,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (
            new.data,
        ) = _STRUCT_6.unpack_from(raw, position)
        position += 1
        return new, position


class String(Message):
    """std_msgs/msg/String."""

    __slots__ = ('data',)
    __ros_name__ = "std_msgs/msg/String"
    __ros_fields__ = MappingProxyType({
        "data": "string",
    })

    data: str

    def __init__(
        self,
        *,
        data: str = "",
    ) -> None:
        self.data = data

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.data = self.data
        return new

    def encode_into(self, out: bytearray) -> None:
        write_string(out, self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.data, position = read_string(raw, position)
        return new, position


class UInt64(Message):
    """std_msgs/msg/UInt64."""

    __slots__ = ('data',)
    __ros_name__ = "std_msgs/msg/UInt64"
    __ros_fields__ = MappingProxyType({
        "data": "uint64",
    })

    data: int

    def __init__(
        self,
        *,
        data: int = 0,
    ) -> None:
        self.data = data

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.data = self.data
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD8[len(out) & 7]
        out += _STRUCT_7.pack(
            self.data,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = ((position + 3) & -8) + 4
        (
            new.data,
        ) = _STRUCT_7.unpack_from(raw, position)
        position += 8
        return new, position
