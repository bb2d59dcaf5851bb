"""Messages to payloads and back, and errors that name the field of a message that does not fit its definition."""

import math
import sys
from collections.abc import Iterator
from struct import error as StructError  # noqa: N812  it is a class
from typing import Final, TypeVar, cast

import numpy as np

from sunset_ros.errors import InterfaceError
from sunset_ros.generator.definitions import FieldType
from sunset_ros.interfaces._codec import PAD4, array_of
from sunset_ros.interfaces._message import Message
from sunset_ros.interfaces._registry import field_types

_ENCAPSULATION = b"\x00\x01\x00\x00"
"""Plain CDR, little endian, no options."""

_LARGEST: Final = {"float32": float(np.finfo(np.float32).max), "float64": sys.float_info.max}

_M = TypeVar("_M", bound=Message)
_Misfit = tuple[str, str, object]
"""The path of a field, the expected value in words, and the value."""


def serialize(message: Message) -> bytes:
    """Return a message as a CDR payload: encapsulation header, fields, padded to a multiple of 4 bytes.

    Raises:
        InterfaceError: a field's value does not fit the definition.

    >>> from sunset_ros.interfaces.std_msgs.msg import Bool
    >>> serialize(Bool(data=True)).hex()
    '0001000001000000'
    """
    out = bytearray(_ENCAPSULATION)
    try:
        message.encode_into(out)
    except (
        AttributeError,
        TypeError,
        ValueError,
        LookupError,
        OverflowError,
        StructError,
        InterfaceError,
    ) as error:
        if not isinstance(message, Message):
            raise InterfaceError(f"Only a message can be serialized, got {message!r}.") from error
        raise misfit(message, error) from error
    out += PAD4[len(out) & 3]
    return bytes(out)


def deserialize(raw: bytes | bytearray | memoryview, kind: type[_M]) -> _M:
    """Return the message of class `kind` in a CDR payload.

    Arrays of numbers look at the payload's own bytes, read-only: nothing is copied.

    Args:
        raw: the payload with its encapsulation header; up to 3 bytes may follow the message.
        kind: the message class.

    Raises:
        InterfaceError: the payload is not little-endian CDR, or not a message of this class.
    """
    payload = bytes(raw)
    if payload[:2] != _ENCAPSULATION[:2]:
        raise InterfaceError(
            f"A payload of little-endian CDR starts with 0001, got {payload[:4].hex() or 'nothing'}."
        )
    try:
        message, end = kind.decode_from(payload, len(_ENCAPSULATION))
    except (ValueError, IndexError, OverflowError, StructError, InterfaceError) as error:
        raise InterfaceError(
            f"A payload of {len(payload)} bytes is not a {kind.__ros_name__}: {str(error).rstrip('.')}."
        ) from error
    if not end <= len(payload) < end + 4:
        raise InterfaceError(
            f"A payload of {len(payload)} bytes is not a {kind.__ros_name__}, which ends at byte {end}."
        )
    return message


def misfit(message: Message, error: Exception) -> InterfaceError:
    """Return an error that names the first field that does not fit; `error` is the exception of the codec."""
    found = next(_misfits(message, ""), None)
    if found is None:
        return InterfaceError(f"A {message.__ros_name__} cannot be processed: {error}.")
    path, expected, value = found
    return InterfaceError(
        f"Field {path!r} of {message.__ros_name__} must be {expected}, got {_brief(value)}."
    )


def _misfits(message: Message, prefix: str) -> Iterator[_Misfit]:
    for name, kind in field_types(type(message)).items():
        misfits = _array if kind.is_array else _element
        yield from misfits(kind, getattr(message, name, None), prefix + name)


def _array(kind: FieldType, value: object, path: str) -> Iterator[_Misfit]:
    if kind.is_numpy:
        try:
            value = array_of(value, np.dtype(kind.base))  # type: ignore[arg-type]  # anything may stand there
        except InterfaceError as error:
            yield path, f"an array of {kind.base} ({str(error).rstrip('.')})", value
            return
    elif not isinstance(value, list | tuple):
        yield path, f"a list for {kind}", value
        return
    if kind.size is not None and len(value) != kind.size:
        yield path, f"of {kind.size} elements", value
    elif kind.limit is not None and len(value) > kind.limit:
        yield path, f"of at most {kind.limit} elements", value
    elif not kind.is_numpy:
        for index, item in enumerate(value):
            yield from _element(kind, item, f"{path}[{index}]")


def _element(kind: FieldType, value: object, path: str) -> Iterator[_Misfit]:
    if not kind.is_message:
        expected = _expected(kind, value)
        if expected:
            yield path, expected, value
    elif isinstance(value, Message) and value.__ros_name__ == kind.base:
        yield from _misfits(value, f"{path}.")
    else:
        yield path, f"a {kind.base}", value


def _expected(kind: FieldType, value: object) -> str:
    """Return a description of the expected value; empty if a primitive value fits."""
    if kind.base == "bool":
        return "" if isinstance(value, bool | np.bool_) else "True or False"
    if kind.base == "byte":
        return "" if isinstance(value, bytes) and len(value) == 1 else "one byte, such as b'\\x00'"
    if kind.base == "string":
        return _expected_string(kind, value)
    if kind.base in _LARGEST:
        if not isinstance(value, int | float | np.floating | np.integer):
            return "a number"
        fits = not _LARGEST[kind.base] < abs(cast("float", value)) < math.inf
        return "" if fits else f"a number that fits {kind.base.removeprefix('float')} bits"
    limits = np.iinfo(kind.base)
    fits = isinstance(value, int | np.integer) and limits.min <= int(value) <= limits.max
    return "" if fits else f"a whole number from {limits.min} to {limits.max}"


def _expected_string(kind: FieldType, value: object) -> str:
    if not isinstance(value, str):
        return "a string"
    size = len(value.encode(errors="ignore"))
    if len(value.encode(errors="replace")) > size:
        return "a string that UTF-8 can express"
    return f"a string of at most {kind.string_bound} bytes" if 0 < kind.string_bound < size else ""


def _brief(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} and shape {value.shape}"
    text = repr(value)
    return f"{type(value).__name__} {text if len(text) <= 60 else text[:57] + '...'}"  # noqa: PLR2004  one line
