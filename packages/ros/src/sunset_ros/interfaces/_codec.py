"""The values in a message's fields, and how they look on the wire: plain XCDR1, little endian.

A position counts from the start of the payload, whose first four bytes are the encapsulation header, while
alignment counts from the fourth. The generated modules are composed of these functions; numbers that lie
side by side are packed at once by the `Struct` of their module.

Source: OMG DDS-XTypes 1.3, section 7.4.1 (plain CDR, version 1).
"""

from collections.abc import Callable, Sequence, Sized
from struct import Struct
from typing import Final, TypeVar, cast

import numpy as np
import numpy.typing as npt

from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces._message import Message

INT8: Final[np.dtype[np.int8]] = np.dtype("<i1")
UINT8: Final[np.dtype[np.uint8]] = np.dtype("<u1")
INT16: Final[np.dtype[np.int16]] = np.dtype("<i2")
UINT16: Final[np.dtype[np.uint16]] = np.dtype("<u2")
INT32: Final[np.dtype[np.int32]] = np.dtype("<i4")
UINT32: Final[np.dtype[np.uint32]] = np.dtype("<u4")
INT64: Final[np.dtype[np.int64]] = np.dtype("<i8")
UINT64: Final[np.dtype[np.uint64]] = np.dtype("<u8")
FLOAT32: Final[np.dtype[np.float32]] = np.dtype("<f4")
FLOAT64: Final[np.dtype[np.float64]] = np.dtype("<f8")

_T = TypeVar("_T", bound=np.generic)
_M = TypeVar("_M", bound=Message)
_I = TypeVar("_I")
_S = TypeVar("_S", bound=Sized)


_EMPTY: Final[dict[object, npt.NDArray[np.generic]]] = {}


def empty(dtype: np.dtype[_T]) -> npt.NDArray[_T]:
    """Return the shared empty array of a type, which is read-only."""
    found = _EMPTY.get(dtype)
    if found is None:
        found = _EMPTY[dtype] = np.zeros(0, dtype)
        found.flags.writeable = False
    return cast("npt.NDArray[_T]", found)


def array_of(value: npt.ArrayLike, dtype: np.dtype[_T]) -> npt.NDArray[_T]:
    """Return `value` as a contiguous array (N,) of `dtype`: itself if it fits, else a converted copy."""
    if isinstance(value, np.ndarray):
        if value.dtype == dtype and value.ndim == 1 and value.flags.c_contiguous:
            return value
        array = value
    elif isinstance(value, bytes | bytearray | memoryview) and dtype == UINT8:
        return np.frombuffer(value, dtype)
    else:
        try:
            array = np.asarray(value)
        except (TypeError, ValueError, OverflowError) as error:
            raise InterfaceError(f"Expected a sequence of {dtype} values: {error}.") from error
    if array.ndim != 1:
        raise InterfaceError(f"Expected a one-dimensional array of {dtype}, got one of shape {array.shape}.")
    if not array.size:
        return empty(dtype)
    _check_numbers(array, dtype)
    return np.ascontiguousarray(array, dtype)


def _check_numbers(array: npt.NDArray[np.number], dtype: np.dtype[_T]) -> None:
    if array.dtype.kind not in ("iuf" if dtype.kind == "f" else "iu"):
        raise InterfaceError(f"Expected an array of {dtype}, got one of {array.dtype}.")
    if dtype.kind == "f":
        finite = array[np.isfinite(array)]
        if (
            array.dtype.itemsize > dtype.itemsize
            and finite.size
            and abs(finite).max() > np.finfo(dtype.name).max
        ):
            raise InterfaceError(f"Expected numbers that fit {dtype}, got {abs(finite).max():g}.")
        return
    limits = np.iinfo(dtype.name)
    low, high = array.min(), array.max()
    if low < limits.min or high > limits.max:
        raise InterfaceError(
            f"Expected numbers from {limits.min} to {limits.max} in an array of {dtype}, got {low} to {high}."
        )


def frozen(value: npt.NDArray[_T], dtype: np.dtype[_T]) -> npt.NDArray[_T]:
    """Return `value` as `array_of` does, marked read-only, so that messages may share it."""
    if value.__class__ is not np.ndarray or value.dtype is not dtype or value.ndim != 1:
        value = array_of(value, dtype)
    if value.size:
        value.flags.writeable = False
    return value


def copied(value: _M, kind: type[Message]) -> _M:
    """Return a copy of a message in a field of its class."""
    if not isinstance(value, kind):
        raise InterfaceError(f"Expected a {kind.__ros_name__}, got {value!r}.")
    return value.copy()


def at_most(value: _S, limit: int) -> _S:
    """Return `value` if it has at most `limit` elements."""
    if len(value) > limit:
        raise InterfaceError(f"Expected at most {limit} elements, got {len(value)}.")
    return value


def exactly(value: _S, size: int) -> _S:
    """Return `value` if it has exactly `size` elements."""
    if len(value) != size:
        raise InterfaceError(f"Expected {size} elements, got {len(value)}.")
    return value


BOOLS: Final = {True: True, False: False}
"""The values of a `bool` field."""

PAD2: Final = tuple(bytes(-position % 2) for position in range(2))
"""`PAD2[position & 1]` is the padding up to the next multiple of 2; `PAD4` and `PAD8` likewise."""

PAD4: Final = tuple(bytes(-position % 4) for position in range(4))
PAD8: Final = tuple(bytes((4 - position) % 8) for position in range(8))

_SIZE: Final = Struct("<I")
_pack_size = _SIZE.pack
_unpack_size = _SIZE.unpack_from


def write_size(out: bytearray, size: int) -> None:
    """Append the number of elements of a sequence."""
    out += PAD4[len(out) & 3]
    out += _pack_size(size)


def read_size(raw: bytes, position: int) -> tuple[int, int]:
    """Return the number of elements of a sequence and the position behind it."""
    position = (position + 3) & -4
    (size,) = _unpack_size(raw, position)
    return size, position + 4


def write_string(out: bytearray, value: str, bound: int = 0) -> None:
    """Append a string of at most `bound` bytes (0: of any length), its length and its terminator."""
    out += PAD4[len(out) & 3]
    if value == "":  # as most strings are
        out += b"\1\0\0\0\0"
        return
    data = value.encode()
    if bound and len(data) > bound:
        raise InterfaceError(f"Expected a string of at most {bound} bytes, got {len(data)}.")
    out += _pack_size(len(data) + 1)
    out += data
    out.append(0)


def read_string(raw: bytes, position: int) -> tuple[str, int]:
    """Return a string and the position behind it."""
    start = ((position + 3) & -4) + 4
    (size,) = _unpack_size(raw, start - 4)
    end = start + size
    if not size or raw[end - 1]:
        raise InterfaceError(f"The string at byte {start} has no terminator.")
    return raw[start : end - 1].decode(), end


def write_numbers(out: bytearray, value: npt.NDArray[_T], dtype: np.dtype[_T]) -> None:
    """Append the elements of an array, without their number."""
    data = array_of(value, dtype)
    if not data.size:
        return
    out += bytes((_start(dtype) - len(out)) % dtype.itemsize)
    out += data.data


def read_numbers(raw: bytes, position: int, dtype: np.dtype[_T], size: int) -> tuple[npt.NDArray[_T], int]:
    """Return an array (size,) that looks at the payload's own bytes, and the position behind it."""
    item = dtype.itemsize
    position += (_start(dtype) - position) % item
    return np.frombuffer(raw, dtype, size, position), position + size * item


def _start(dtype: np.dtype[_T]) -> int:
    """Return a position of elements: the header shifts the grid of 8 bytes, but no smaller grid."""
    return 4 if dtype.itemsize == 8 else 0  # noqa: PLR2004


def write_array(out: bytearray, value: npt.NDArray[_T], dtype: np.dtype[_T]) -> None:
    """Append a sequence of numbers."""
    size = len(value)
    out += PAD4[len(out) & 3] + _pack_size(size)
    if size or value.__class__ is not np.ndarray or value.dtype is not dtype:  # an empty array needs no check
        write_numbers(out, value, dtype)


def read_array(raw: bytes, position: int, dtype: np.dtype[_T]) -> tuple[npt.NDArray[_T], int]:
    """Return a sequence of numbers and the position behind it."""
    position = (position + 3) & -4
    (size,) = _unpack_size(raw, position)
    if not size:
        return empty(dtype), position + 4
    return read_numbers(raw, position + 4, dtype, size)


def write_bools(out: bytearray, values: Sequence[bool]) -> None:
    """Append the elements of a sequence of truth values, without their number."""
    if len(values):
        out += bytes([BOOLS[value] for value in values])


def read_bools(raw: bytes, position: int, size: int) -> tuple[list[bool], int]:
    """Return a list of truth values and the position behind it."""
    end = position + size
    return [value != 0 for value in _exactly(raw, position, end)], end


def write_bytes(out: bytearray, values: Sequence[bytes]) -> None:
    """Append the elements of a sequence of bytes, each a `bytes` of length 1, without their number."""
    if len(values):
        data = b"".join(values)
        if len(data) != len(values):
            raise InterfaceError("Expected elements of exactly one byte each.")
        out += data


def read_bytes(raw: bytes, position: int, size: int) -> tuple[list[bytes], int]:
    """Return a list of bytes, each a `bytes` of length 1, and the position behind it."""
    end = position + size
    return [bytes((value,)) for value in _exactly(raw, position, end)], end


def write_strings(out: bytearray, values: Sequence[str], bound: int = 0) -> None:
    """Append the elements of a sequence of strings, without their number."""
    for value in values:
        write_string(out, value, bound)


def write_messages(out: bytearray, values: Sequence[_M], kind: type[_M]) -> None:
    """Append the elements of a sequence of messages of a class, without their number."""
    encode = kind.encode_into
    for value in values:
        encode(value, out)


def read_items(
    raw: bytes, position: int, size: int, read: Callable[[bytes, int], tuple[_I, int]]
) -> tuple[list[_I], int]:
    """Return a list of strings or messages, each of which `read` reads, and the position behind it."""
    values: list[_I] = []
    for _ in range(size):
        value, position = read(raw, position)
        values.append(value)
    return values, position


def read_dummy(raw: bytes, position: int) -> int:
    """Return the position behind the octet of a message without fields."""
    if position >= len(raw):
        raise InterfaceError("A message without fields needs one octet.")
    return position + 1


def _exactly(raw: bytes, start: int, end: int) -> bytes:
    if end > len(raw):
        raise InterfaceError(f"The sequence at byte {start} is longer than the payload.")
    return raw[start:end]
