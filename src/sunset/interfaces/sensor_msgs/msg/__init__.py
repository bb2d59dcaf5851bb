"""The messages of `sensor_msgs`, generated from their definitions."""

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
    "CameraInfo",
    "CompressedImage",
    "Image",
    "RegionOfInterest",
]

_STRUCT_0 = Struct("<IIII?")
_STRUCT_1 = Struct("<II")
_STRUCT_2 = Struct("<B")
_STRUCT_3 = Struct("<I")


class RegionOfInterest(Message):
    """sensor_msgs/msg/RegionOfInterest."""

    __slots__ = ('x_offset', 'y_offset', 'height', 'width', 'do_rectify')
    __ros_name__ = "sensor_msgs/msg/RegionOfInterest"
    __ros_fields__ = MappingProxyType({
        "x_offset": "uint32",
        "y_offset": "uint32",
        "height": "uint32",
        "width": "uint32",
        "do_rectify": "bool",
    })

    x_offset: int
    y_offset: int
    height: int
    width: int
    do_rectify: bool

    def __init__(
        self,
        *,
        x_offset: int = 0,
        y_offset: int = 0,
        height: int = 0,
        width: int = 0,
        do_rectify: bool = False,
    ) -> None:
        self.x_offset = x_offset
        self.y_offset = y_offset
        self.height = height
        self.width = width
        self.do_rectify = do_rectify

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.x_offset = self.x_offset
        new.y_offset = self.y_offset
        new.height = self.height
        new.width = self.width
        new.do_rectify = self.do_rectify
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD4[len(out) & 3]
        out += _STRUCT_0.pack(
            self.x_offset,
            self.y_offset,
            self.height,
            self.width,
            BOOLS[self.do_rectify],
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = (position + 3) & -4
        (
            new.x_offset,
            new.y_offset,
            new.height,
            new.width,
            new.do_rectify,
        ) = _STRUCT_0.unpack_from(raw, position)
        position += 17
        return new, position


class CameraInfo(Message):
    """sensor_msgs/msg/CameraInfo."""

    __slots__ = ('header', 'height', 'width', 'distortion_model', 'd', 'k', 'r', 'p', 'binning_x', 'binning_y', 'roi')
    __ros_name__ = "sensor_msgs/msg/CameraInfo"
    __ros_fields__ = MappingProxyType({
        "header": "std_msgs/Header",
        "height": "uint32",
        "width": "uint32",
        "distortion_model": "string",
        "d": "float64[]",
        "k": "float64[9]",
        "r": "float64[9]",
        "p": "float64[12]",
        "binning_x": "uint32",
        "binning_y": "uint32",
        "roi": "sensor_msgs/RegionOfInterest",
    })

    header: Header
    height: int
    width: int
    distortion_model: str
    d: npt.NDArray[np.float64]
    k: npt.NDArray[np.float64]
    r: npt.NDArray[np.float64]
    p: npt.NDArray[np.float64]
    binning_x: int
    binning_y: int
    roi: RegionOfInterest

    def __init__(
        self,
        *,
        header: Header | None = None,
        height: int = 0,
        width: int = 0,
        distortion_model: str = "",
        d: npt.ArrayLike | None = None,
        k: npt.ArrayLike | None = None,
        r: npt.ArrayLike | None = None,
        p: npt.ArrayLike | None = None,
        binning_x: int = 0,
        binning_y: int = 0,
        roi: RegionOfInterest | None = None,
    ) -> None:
        self.header = Header() if header is None else header
        self.height = height
        self.width = width
        self.distortion_model = distortion_model
        self.d = empty(FLOAT64) if d is None else array_of(d, FLOAT64)
        self.k = zeros(FLOAT64, 9) if k is None else array_of(k, FLOAT64)
        self.r = zeros(FLOAT64, 9) if r is None else array_of(r, FLOAT64)
        self.p = zeros(FLOAT64, 12) if p is None else array_of(p, FLOAT64)
        self.binning_x = binning_x
        self.binning_y = binning_y
        self.roi = RegionOfInterest() if roi is None else roi

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.header = Header.copy(self.header)
            new.height = self.height
            new.width = self.width
            new.distortion_model = self.distortion_model
            new.d = frozen(self.d, FLOAT64)
            new.k = frozen(self.k, FLOAT64)
            new.r = frozen(self.r, FLOAT64)
            new.p = frozen(self.p, FLOAT64)
            new.binning_x = self.binning_x
            new.binning_y = self.binning_y
            new.roi = RegionOfInterest.copy(self.roi)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Header.encode_into(self.header, out)
        out += PAD4[len(out) & 3]
        out += _STRUCT_1.pack(
            self.height,
            self.width,
        )
        write_string(out, self.distortion_model)
        write_array(out, self.d, FLOAT64)
        write_numbers(out, exactly(self.k, 9), FLOAT64)
        write_numbers(out, exactly(self.r, 9), FLOAT64)
        write_numbers(out, exactly(self.p, 12), FLOAT64)
        out += PAD4[len(out) & 3]
        out += _STRUCT_1.pack(
            self.binning_x,
            self.binning_y,
        )
        RegionOfInterest.encode_into(self.roi, out)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.header, position = Header.decode_from(raw, position)
        position = (position + 3) & -4
        (
            new.height,
            new.width,
        ) = _STRUCT_1.unpack_from(raw, position)
        position += 8
        new.distortion_model, position = read_string(raw, position)
        new.d, position = read_array(raw, position, FLOAT64)
        new.k, position = read_numbers(raw, position, FLOAT64, 9)
        new.r, position = read_numbers(raw, position, FLOAT64, 9)
        new.p, position = read_numbers(raw, position, FLOAT64, 12)
        position = (position + 3) & -4
        (
            new.binning_x,
            new.binning_y,
        ) = _STRUCT_1.unpack_from(raw, position)
        position += 8
        new.roi, position = RegionOfInterest.decode_from(raw, position)
        return new, position


class CompressedImage(Message):
    """sensor_msgs/msg/CompressedImage."""

    __slots__ = ('header', 'format', 'data')
    __ros_name__ = "sensor_msgs/msg/CompressedImage"
    __ros_fields__ = MappingProxyType({
        "header": "std_msgs/Header",
        "format": "string",
        "data": "uint8[]",
    })

    header: Header
    format: str
    data: npt.NDArray[np.uint8]

    def __init__(
        self,
        *,
        header: Header | None = None,
        format: str = "",
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.header = Header() if header is None else header
        self.format = format
        self.data = empty(UINT8) if data is None else array_of(data, UINT8)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.header = Header.copy(self.header)
            new.format = self.format
            new.data = frozen(self.data, UINT8)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Header.encode_into(self.header, out)
        write_string(out, self.format)
        write_array(out, self.data, UINT8)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.header, position = Header.decode_from(raw, position)
        new.format, position = read_string(raw, position)
        new.data, position = read_array(raw, position, UINT8)
        return new, position


class Image(Message):
    """sensor_msgs/msg/Image."""

    __slots__ = ('header', 'height', 'width', 'encoding', 'is_bigendian', 'step', 'data')
    __ros_name__ = "sensor_msgs/msg/Image"
    __ros_fields__ = MappingProxyType({
        "header": "std_msgs/Header",
        "height": "uint32",
        "width": "uint32",
        "encoding": "string",
        "is_bigendian": "uint8",
        "step": "uint32",
        "data": "uint8[]",
    })

    header: Header
    height: int
    width: int
    encoding: str
    is_bigendian: int
    step: int
    data: npt.NDArray[np.uint8]

    def __init__(
        self,
        *,
        header: Header | None = None,
        height: int = 0,
        width: int = 0,
        encoding: str = "",
        is_bigendian: int = 0,
        step: int = 0,
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.header = Header() if header is None else header
        self.height = height
        self.width = width
        self.encoding = encoding
        self.is_bigendian = is_bigendian
        self.step = step
        self.data = empty(UINT8) if data is None else array_of(data, UINT8)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.header = Header.copy(self.header)
            new.height = self.height
            new.width = self.width
            new.encoding = self.encoding
            new.is_bigendian = self.is_bigendian
            new.step = self.step
            new.data = frozen(self.data, UINT8)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Header.encode_into(self.header, out)
        out += PAD4[len(out) & 3]
        out += _STRUCT_1.pack(
            self.height,
            self.width,
        )
        write_string(out, self.encoding)
        out += _STRUCT_2.pack(
            self.is_bigendian,
        )
        out += PAD4[len(out) & 3]
        out += _STRUCT_3.pack(
            self.step,
        )
        write_array(out, self.data, UINT8)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.header, position = Header.decode_from(raw, position)
        position = (position + 3) & -4
        (
            new.height,
            new.width,
        ) = _STRUCT_1.unpack_from(raw, position)
        position += 8
        new.encoding, position = read_string(raw, position)
        (
            new.is_bigendian,
        ) = _STRUCT_2.unpack_from(raw, position)
        position += 1
        position = (position + 3) & -4
        (
            new.step,
        ) = _STRUCT_3.unpack_from(raw, position)
        position += 4
        new.data, position = read_array(raw, position, UINT8)
        return new, position
