"""Errors that name the field of a message that does not fit its definition."""

import math
import sys
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from sunset_ros.errors import InterfaceError
from sunset_ros.generator.definitions import FieldType, parse_type
from sunset_ros.interfaces._message import Message
from sunset_ros.interfaces._values import array_of

_FLOAT32_MAX: Final = float(np.finfo(np.float32).max)


def misfit(message: Message, error: Exception) -> InterfaceError:
    """Return an error that names the first field that does not fit; `error` is the exception of the codec."""
    found = next(_misfits(message, ""), None)
    if found is None:
        return InterfaceError(f"A {message.__ros_name__} cannot be processed: {error}.")
    path, expected, value = found
    return InterfaceError(
        f"Field {path!r} of {message.__ros_name__} must be {expected}, got {_brief(value)}."
    )


def _misfits(message: Message, prefix: str) -> Iterator[tuple[str, str, object]]:
    package = message.__ros_name__.split("/")[0]
    for name, text in message.__ros_fields__.items():
        kind = parse_type(text, package)
        value = getattr(message, name, None)
        yield from (
            _array(kind, value, prefix + name) if kind.is_array else _element(kind, value, prefix + name)
        )


def _array(kind: FieldType, value: object, path: str) -> Iterator[tuple[str, str, object]]:
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


def _element(kind: FieldType, value: object, path: str) -> Iterator[tuple[str, str, object]]:
    if kind.is_message:
        if isinstance(value, Message) and value.__ros_name__ == kind.base:
            yield from _misfits(value, f"{path}.")
        else:
            yield path, f"a {kind.base}", value
        return
    expected = _expected(kind, value)
    if expected:
        yield path, expected, value


def _expected(kind: FieldType, value: object) -> str:
    """Return a description of the expected value; empty if a primitive value fits."""
    if kind.base == "string":
        return _expected_string(kind, value)
    if kind.base == "bool":
        return "" if isinstance(value, bool | np.bool_) else "True or False"
    if kind.base == "byte":
        return "" if isinstance(value, bytes) and len(value) == 1 else "one byte, such as b'\\x00'"
    return _expected_number(kind, value)


def _expected_number(kind: FieldType, value: object) -> str:
    if kind.base.startswith("float"):
        if not isinstance(value, int | float | np.floating | np.integer):
            return "a number"
        greatest, bits = (_FLOAT32_MAX, 32) if kind.base == "float32" else (sys.float_info.max, 64)
        size: Any = abs(value)  # whole numbers too, of any length
        return f"a number that fits {bits} bits" if greatest < size < math.inf else ""
    limits = np.iinfo(kind.base)
    if isinstance(value, int | np.integer) and limits.min <= int(value) <= limits.max:
        return ""
    return f"a whole number from {limits.min} to {limits.max}"


def _expected_string(kind: FieldType, value: object) -> str:
    if not isinstance(value, str):
        return "a string"
    try:
        size = len(value.encode())
    except UnicodeEncodeError:
        return "a string that UTF-8 can express"
    if kind.string_bound and size > kind.string_bound:
        return f"a string of at most {kind.string_bound} bytes"
    return ""


def _brief(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} and shape {value.shape}"
    text = repr(value)
    return f"{type(value).__name__} {text if len(text) <= 60 else text[:57] + '...'}"  # noqa: PLR2004  one line
