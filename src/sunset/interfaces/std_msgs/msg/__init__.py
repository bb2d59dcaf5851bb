"""The messages of `std_msgs`, written by scripts/generate_interfaces."""

from struct import Struct
from types import MappingProxyType
from typing import Self

import numpy as np
import numpy.typing as npt

from sunset.errors import InterfaceError
from sunset.interfaces._check import misfit
from sunset.interfaces._codec import (
    BOOLS,
    PAD2,
    PAD4,
    PAD8,
    read_array,
    read_bytes,
    read_dummy,
    read_messages,
    read_size,
    read_string,
    write_array,
    write_bytes,
    write_messages,
    write_size,
    write_string,
)
from sunset.interfaces._message import Message
from sunset.interfaces._values import (
    FLOAT32,
    FLOAT64,
    INT8,
    INT16,
    INT32,
    INT64,
    UINT8,
    UINT16,
    UINT32,
    UINT64,
    array_of,
    empty,
    frozen,
)
from sunset.interfaces.builtin_interfaces.msg import Time

__all__ = [
    "Bool",
    "Byte",
    "ByteMultiArray",
    "Char",
    "ColorRGBA",
    "Empty",
    "Float32",
    "Float32MultiArray",
    "Float64",
    "Float64MultiArray",
    "Header",
    "Int8",
    "Int8MultiArray",
    "Int16",
    "Int16MultiArray",
    "Int32",
    "Int32MultiArray",
    "Int64",
    "Int64MultiArray",
    "MultiArrayDimension",
    "MultiArrayLayout",
    "String",
    "UInt8",
    "UInt8MultiArray",
    "UInt16",
    "UInt16MultiArray",
    "UInt32",
    "UInt32MultiArray",
    "UInt64",
    "UInt64MultiArray",
]

_STRUCT_0 = Struct("<?")
_STRUCT_1 = Struct("<c")
_STRUCT_2 = Struct("<II")
_STRUCT_3 = Struct("<I")
_STRUCT_4 = Struct("<B")
_STRUCT_5 = Struct("<ffff")
_STRUCT_6 = Struct("<f")
_STRUCT_7 = Struct("<d")
_STRUCT_8 = Struct("<b")
_STRUCT_9 = Struct("<h")
_STRUCT_10 = Struct("<i")
_STRUCT_11 = Struct("<q")
_STRUCT_12 = Struct("<H")
_STRUCT_13 = Struct("<Q")


class Bool(Message):
    """std_msgs/msg/Bool."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/Bool"
    __ros_fields__ = MappingProxyType(
        {
            "data": "bool",
        }
    )

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
        out += _STRUCT_0.pack(BOOLS[self.data])

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (new.data,) = _STRUCT_0.unpack_from(raw, position)
        position += 1
        return new, position


class Byte(Message):
    """std_msgs/msg/Byte."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/Byte"
    __ros_fields__ = MappingProxyType(
        {
            "data": "byte",
        }
    )

    data: bytes

    def __init__(
        self,
        *,
        data: bytes = b"\x00",
    ) -> None:
        self.data = data

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.data = self.data
        return new

    def encode_into(self, out: bytearray) -> None:
        out += _STRUCT_1.pack(self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (new.data,) = _STRUCT_1.unpack_from(raw, position)
        position += 1
        return new, position


class MultiArrayDimension(Message):
    """std_msgs/msg/MultiArrayDimension."""

    __slots__ = (
        "label",
        "size",
        "stride",
    )
    __ros_name__ = "std_msgs/msg/MultiArrayDimension"
    __ros_fields__ = MappingProxyType(
        {
            "label": "string",
            "size": "uint32",
            "stride": "uint32",
        }
    )

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
        out += _STRUCT_2.pack(
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
        ) = _STRUCT_2.unpack_from(raw, position)
        position += 8
        return new, position


class MultiArrayLayout(Message):
    """std_msgs/msg/MultiArrayLayout."""

    __slots__ = (
        "data_offset",
        "dim",
    )
    __ros_name__ = "std_msgs/msg/MultiArrayLayout"
    __ros_fields__ = MappingProxyType(
        {
            "dim": "std_msgs/MultiArrayDimension[]",
            "data_offset": "uint32",
        }
    )

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
        out += _STRUCT_3.pack(self.data_offset)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        size, position = read_size(raw, position)
        new.dim, position = read_messages(raw, position, size, MultiArrayDimension)
        position = (position + 3) & -4
        (new.data_offset,) = _STRUCT_3.unpack_from(raw, position)
        position += 4
        return new, position


class ByteMultiArray(Message):
    """std_msgs/msg/ByteMultiArray."""

    __slots__ = (
        "data",
        "layout",
    )
    __ros_name__ = "std_msgs/msg/ByteMultiArray"
    __ros_fields__ = MappingProxyType(
        {
            "layout": "std_msgs/MultiArrayLayout",
            "data": "byte[]",
        }
    )

    layout: MultiArrayLayout
    data: list[bytes]

    def __init__(
        self,
        *,
        layout: MultiArrayLayout | None = None,
        data: list[bytes] | None = None,
    ) -> None:
        self.layout = MultiArrayLayout() if layout is None else layout
        self.data = [] if data is None else data

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.layout = MultiArrayLayout.copy(self.layout)
            new.data = list(self.data)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        MultiArrayLayout.encode_into(self.layout, out)
        write_size(out, len(self.data))
        write_bytes(out, self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.layout, position = MultiArrayLayout.decode_from(raw, position)
        size, position = read_size(raw, position)
        new.data, position = read_bytes(raw, position, size)
        return new, position


class Char(Message):
    """std_msgs/msg/Char."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/Char"
    __ros_fields__ = MappingProxyType(
        {
            "data": "uint8",
        }
    )

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
        out += _STRUCT_4.pack(self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (new.data,) = _STRUCT_4.unpack_from(raw, position)
        position += 1
        return new, position


class ColorRGBA(Message):
    """std_msgs/msg/ColorRGBA."""

    __slots__ = (
        "a",
        "b",
        "g",
        "r",
    )
    __ros_name__ = "std_msgs/msg/ColorRGBA"
    __ros_fields__ = MappingProxyType(
        {
            "r": "float32",
            "g": "float32",
            "b": "float32",
            "a": "float32",
        }
    )

    r: float
    g: float
    b: float
    a: float

    def __init__(
        self,
        *,
        r: float = 0.0,
        g: float = 0.0,
        b: float = 0.0,
        a: float = 0.0,
    ) -> None:
        self.r = r
        self.g = g
        self.b = b
        self.a = a

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.r = self.r
        new.g = self.g
        new.b = self.b
        new.a = self.a
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD4[len(out) & 3]
        out += _STRUCT_5.pack(
            self.r,
            self.g,
            self.b,
            self.a,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = (position + 3) & -4
        (
            new.r,
            new.g,
            new.b,
            new.a,
        ) = _STRUCT_5.unpack_from(raw, position)
        position += 16
        return new, position


class Empty(Message):
    """std_msgs/msg/Empty."""

    __slots__ = ()
    __ros_name__ = "std_msgs/msg/Empty"
    __ros_fields__ = MappingProxyType({})

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

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/Float32"
    __ros_fields__ = MappingProxyType(
        {
            "data": "float32",
        }
    )

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
        out += _STRUCT_6.pack(self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = (position + 3) & -4
        (new.data,) = _STRUCT_6.unpack_from(raw, position)
        position += 4
        return new, position


class Float32MultiArray(Message):
    """std_msgs/msg/Float32MultiArray."""

    __slots__ = (
        "data",
        "layout",
    )
    __ros_name__ = "std_msgs/msg/Float32MultiArray"
    __ros_fields__ = MappingProxyType(
        {
            "layout": "std_msgs/MultiArrayLayout",
            "data": "float32[]",
        }
    )

    layout: MultiArrayLayout
    data: npt.NDArray[np.float32]

    def __init__(
        self,
        *,
        layout: MultiArrayLayout | None = None,
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.layout = MultiArrayLayout() if layout is None else layout
        self.data = empty(FLOAT32) if data is None else array_of(data, FLOAT32)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.layout = MultiArrayLayout.copy(self.layout)
            new.data = frozen(self.data, FLOAT32)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        MultiArrayLayout.encode_into(self.layout, out)
        write_array(out, self.data, FLOAT32)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.layout, position = MultiArrayLayout.decode_from(raw, position)
        new.data, position = read_array(raw, position, FLOAT32)
        return new, position


class Float64(Message):
    """std_msgs/msg/Float64."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/Float64"
    __ros_fields__ = MappingProxyType(
        {
            "data": "float64",
        }
    )

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
        out += _STRUCT_7.pack(self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = ((position + 3) & -8) + 4
        (new.data,) = _STRUCT_7.unpack_from(raw, position)
        position += 8
        return new, position


class Float64MultiArray(Message):
    """std_msgs/msg/Float64MultiArray."""

    __slots__ = (
        "data",
        "layout",
    )
    __ros_name__ = "std_msgs/msg/Float64MultiArray"
    __ros_fields__ = MappingProxyType(
        {
            "layout": "std_msgs/MultiArrayLayout",
            "data": "float64[]",
        }
    )

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

    __slots__ = (
        "frame_id",
        "stamp",
    )
    __ros_name__ = "std_msgs/msg/Header"
    __ros_fields__ = MappingProxyType(
        {
            "stamp": "builtin_interfaces/Time",
            "frame_id": "string",
        }
    )

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


class Int8(Message):
    """std_msgs/msg/Int8."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/Int8"
    __ros_fields__ = MappingProxyType(
        {
            "data": "int8",
        }
    )

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
        out += _STRUCT_8.pack(self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (new.data,) = _STRUCT_8.unpack_from(raw, position)
        position += 1
        return new, position


class Int8MultiArray(Message):
    """std_msgs/msg/Int8MultiArray."""

    __slots__ = (
        "data",
        "layout",
    )
    __ros_name__ = "std_msgs/msg/Int8MultiArray"
    __ros_fields__ = MappingProxyType(
        {
            "layout": "std_msgs/MultiArrayLayout",
            "data": "int8[]",
        }
    )

    layout: MultiArrayLayout
    data: npt.NDArray[np.int8]

    def __init__(
        self,
        *,
        layout: MultiArrayLayout | None = None,
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.layout = MultiArrayLayout() if layout is None else layout
        self.data = empty(INT8) if data is None else array_of(data, INT8)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.layout = MultiArrayLayout.copy(self.layout)
            new.data = frozen(self.data, INT8)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        MultiArrayLayout.encode_into(self.layout, out)
        write_array(out, self.data, INT8)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.layout, position = MultiArrayLayout.decode_from(raw, position)
        new.data, position = read_array(raw, position, INT8)
        return new, position


class Int16(Message):
    """std_msgs/msg/Int16."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/Int16"
    __ros_fields__ = MappingProxyType(
        {
            "data": "int16",
        }
    )

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
        out += PAD2[len(out) & 1]
        out += _STRUCT_9.pack(self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = (position + 1) & -2
        (new.data,) = _STRUCT_9.unpack_from(raw, position)
        position += 2
        return new, position


class Int16MultiArray(Message):
    """std_msgs/msg/Int16MultiArray."""

    __slots__ = (
        "data",
        "layout",
    )
    __ros_name__ = "std_msgs/msg/Int16MultiArray"
    __ros_fields__ = MappingProxyType(
        {
            "layout": "std_msgs/MultiArrayLayout",
            "data": "int16[]",
        }
    )

    layout: MultiArrayLayout
    data: npt.NDArray[np.int16]

    def __init__(
        self,
        *,
        layout: MultiArrayLayout | None = None,
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.layout = MultiArrayLayout() if layout is None else layout
        self.data = empty(INT16) if data is None else array_of(data, INT16)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.layout = MultiArrayLayout.copy(self.layout)
            new.data = frozen(self.data, INT16)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        MultiArrayLayout.encode_into(self.layout, out)
        write_array(out, self.data, INT16)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.layout, position = MultiArrayLayout.decode_from(raw, position)
        new.data, position = read_array(raw, position, INT16)
        return new, position


class Int32(Message):
    """std_msgs/msg/Int32."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/Int32"
    __ros_fields__ = MappingProxyType(
        {
            "data": "int32",
        }
    )

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
        out += _STRUCT_10.pack(self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = (position + 3) & -4
        (new.data,) = _STRUCT_10.unpack_from(raw, position)
        position += 4
        return new, position


class Int32MultiArray(Message):
    """std_msgs/msg/Int32MultiArray."""

    __slots__ = (
        "data",
        "layout",
    )
    __ros_name__ = "std_msgs/msg/Int32MultiArray"
    __ros_fields__ = MappingProxyType(
        {
            "layout": "std_msgs/MultiArrayLayout",
            "data": "int32[]",
        }
    )

    layout: MultiArrayLayout
    data: npt.NDArray[np.int32]

    def __init__(
        self,
        *,
        layout: MultiArrayLayout | None = None,
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.layout = MultiArrayLayout() if layout is None else layout
        self.data = empty(INT32) if data is None else array_of(data, INT32)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.layout = MultiArrayLayout.copy(self.layout)
            new.data = frozen(self.data, INT32)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        MultiArrayLayout.encode_into(self.layout, out)
        write_array(out, self.data, INT32)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.layout, position = MultiArrayLayout.decode_from(raw, position)
        new.data, position = read_array(raw, position, INT32)
        return new, position


class Int64(Message):
    """std_msgs/msg/Int64."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/Int64"
    __ros_fields__ = MappingProxyType(
        {
            "data": "int64",
        }
    )

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
        out += _STRUCT_11.pack(self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = ((position + 3) & -8) + 4
        (new.data,) = _STRUCT_11.unpack_from(raw, position)
        position += 8
        return new, position


class Int64MultiArray(Message):
    """std_msgs/msg/Int64MultiArray."""

    __slots__ = (
        "data",
        "layout",
    )
    __ros_name__ = "std_msgs/msg/Int64MultiArray"
    __ros_fields__ = MappingProxyType(
        {
            "layout": "std_msgs/MultiArrayLayout",
            "data": "int64[]",
        }
    )

    layout: MultiArrayLayout
    data: npt.NDArray[np.int64]

    def __init__(
        self,
        *,
        layout: MultiArrayLayout | None = None,
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.layout = MultiArrayLayout() if layout is None else layout
        self.data = empty(INT64) if data is None else array_of(data, INT64)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.layout = MultiArrayLayout.copy(self.layout)
            new.data = frozen(self.data, INT64)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        MultiArrayLayout.encode_into(self.layout, out)
        write_array(out, self.data, INT64)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.layout, position = MultiArrayLayout.decode_from(raw, position)
        new.data, position = read_array(raw, position, INT64)
        return new, position


class String(Message):
    """std_msgs/msg/String."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/String"
    __ros_fields__ = MappingProxyType(
        {
            "data": "string",
        }
    )

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


class UInt8(Message):
    """std_msgs/msg/UInt8."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/UInt8"
    __ros_fields__ = MappingProxyType(
        {
            "data": "uint8",
        }
    )

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
        out += _STRUCT_4.pack(self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (new.data,) = _STRUCT_4.unpack_from(raw, position)
        position += 1
        return new, position


class UInt8MultiArray(Message):
    """std_msgs/msg/UInt8MultiArray."""

    __slots__ = (
        "data",
        "layout",
    )
    __ros_name__ = "std_msgs/msg/UInt8MultiArray"
    __ros_fields__ = MappingProxyType(
        {
            "layout": "std_msgs/MultiArrayLayout",
            "data": "uint8[]",
        }
    )

    layout: MultiArrayLayout
    data: npt.NDArray[np.uint8]

    def __init__(
        self,
        *,
        layout: MultiArrayLayout | None = None,
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.layout = MultiArrayLayout() if layout is None else layout
        self.data = empty(UINT8) if data is None else array_of(data, UINT8)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.layout = MultiArrayLayout.copy(self.layout)
            new.data = frozen(self.data, UINT8)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        MultiArrayLayout.encode_into(self.layout, out)
        write_array(out, self.data, UINT8)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.layout, position = MultiArrayLayout.decode_from(raw, position)
        new.data, position = read_array(raw, position, UINT8)
        return new, position


class UInt16(Message):
    """std_msgs/msg/UInt16."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/UInt16"
    __ros_fields__ = MappingProxyType(
        {
            "data": "uint16",
        }
    )

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
        out += PAD2[len(out) & 1]
        out += _STRUCT_12.pack(self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = (position + 1) & -2
        (new.data,) = _STRUCT_12.unpack_from(raw, position)
        position += 2
        return new, position


class UInt16MultiArray(Message):
    """std_msgs/msg/UInt16MultiArray."""

    __slots__ = (
        "data",
        "layout",
    )
    __ros_name__ = "std_msgs/msg/UInt16MultiArray"
    __ros_fields__ = MappingProxyType(
        {
            "layout": "std_msgs/MultiArrayLayout",
            "data": "uint16[]",
        }
    )

    layout: MultiArrayLayout
    data: npt.NDArray[np.uint16]

    def __init__(
        self,
        *,
        layout: MultiArrayLayout | None = None,
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.layout = MultiArrayLayout() if layout is None else layout
        self.data = empty(UINT16) if data is None else array_of(data, UINT16)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.layout = MultiArrayLayout.copy(self.layout)
            new.data = frozen(self.data, UINT16)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        MultiArrayLayout.encode_into(self.layout, out)
        write_array(out, self.data, UINT16)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.layout, position = MultiArrayLayout.decode_from(raw, position)
        new.data, position = read_array(raw, position, UINT16)
        return new, position


class UInt32(Message):
    """std_msgs/msg/UInt32."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/UInt32"
    __ros_fields__ = MappingProxyType(
        {
            "data": "uint32",
        }
    )

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
        out += _STRUCT_3.pack(self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = (position + 3) & -4
        (new.data,) = _STRUCT_3.unpack_from(raw, position)
        position += 4
        return new, position


class UInt32MultiArray(Message):
    """std_msgs/msg/UInt32MultiArray."""

    __slots__ = (
        "data",
        "layout",
    )
    __ros_name__ = "std_msgs/msg/UInt32MultiArray"
    __ros_fields__ = MappingProxyType(
        {
            "layout": "std_msgs/MultiArrayLayout",
            "data": "uint32[]",
        }
    )

    layout: MultiArrayLayout
    data: npt.NDArray[np.uint32]

    def __init__(
        self,
        *,
        layout: MultiArrayLayout | None = None,
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.layout = MultiArrayLayout() if layout is None else layout
        self.data = empty(UINT32) if data is None else array_of(data, UINT32)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.layout = MultiArrayLayout.copy(self.layout)
            new.data = frozen(self.data, UINT32)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        MultiArrayLayout.encode_into(self.layout, out)
        write_array(out, self.data, UINT32)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.layout, position = MultiArrayLayout.decode_from(raw, position)
        new.data, position = read_array(raw, position, UINT32)
        return new, position


class UInt64(Message):
    """std_msgs/msg/UInt64."""

    __slots__ = ("data",)
    __ros_name__ = "std_msgs/msg/UInt64"
    __ros_fields__ = MappingProxyType(
        {
            "data": "uint64",
        }
    )

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
        out += _STRUCT_13.pack(self.data)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = ((position + 3) & -8) + 4
        (new.data,) = _STRUCT_13.unpack_from(raw, position)
        position += 8
        return new, position


class UInt64MultiArray(Message):
    """std_msgs/msg/UInt64MultiArray."""

    __slots__ = (
        "data",
        "layout",
    )
    __ros_name__ = "std_msgs/msg/UInt64MultiArray"
    __ros_fields__ = MappingProxyType(
        {
            "layout": "std_msgs/MultiArrayLayout",
            "data": "uint64[]",
        }
    )

    layout: MultiArrayLayout
    data: npt.NDArray[np.uint64]

    def __init__(
        self,
        *,
        layout: MultiArrayLayout | None = None,
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.layout = MultiArrayLayout() if layout is None else layout
        self.data = empty(UINT64) if data is None else array_of(data, UINT64)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.layout = MultiArrayLayout.copy(self.layout)
            new.data = frozen(self.data, UINT64)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        MultiArrayLayout.encode_into(self.layout, out)
        write_array(out, self.data, UINT64)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.layout, position = MultiArrayLayout.decode_from(raw, position)
        new.data, position = read_array(raw, position, UINT64)
        return new, position
