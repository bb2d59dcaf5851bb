"""How the parts of a message look on the wire: plain XCDR1, little endian.

A position counts from the start of the payload, whose first four bytes are the encapsulation header, while
alignment counts from the fourth. The generated modules are composed of these functions; numbers that lie
side by side are packed at once by the `Struct` of their module.

Source: OMG DDS-XTypes 1.3, section 7.4.1 (plain CDR, version 1).
"""

from collections.abc import Sequence
from struct import Struct
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt

from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces._message import Message
from sunset_ros.interfaces._values import array_of, empty

BOOLS: Final = {True: True, False: False}
"""The values of a `bool` field."""

PAD2: Final = tuple(bytes(-position % 2) for position in range(2))
"""`PAD2[position & 1]` is the padding up to the next multiple of 2; `PAD4` and `PAD8` likewise."""

PAD4: Final = tuple(bytes(-position % 4) for position in range(4))
PAD8: Final = tuple(bytes((4 - position) % 8) for position in range(8))

_SIZE: Final = Struct("<I")
_pack_size = _SIZE.pack
_unpack_size = _SIZE.unpack_from

_T = TypeVar("_T", bound=np.generic)
_M = TypeVar("_M", bound=Message)


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


def read_strings(raw: bytes, position: int, size: int) -> tuple[list[str], int]:
    """Return a list of strings and the position behind it."""
    values: list[str] = []
    for _ in range(size):
        value, position = read_string(raw, position)
        values.append(value)
    return values, position


def write_messages(out: bytearray, values: Sequence[_M], kind: type[_M]) -> None:
    """Append the elements of a sequence of messages of a class, without their number."""
    encode = kind.encode_into
    for value in values:
        encode(value, out)


def read_messages(raw: bytes, position: int, size: int, kind: type[_M]) -> tuple[list[_M], int]:
    """Return a list of messages and the position behind it."""
    values: list[_M] = []
    decode = kind.decode_from
    for _ in range(size):
        value, position = decode(raw, position)
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
