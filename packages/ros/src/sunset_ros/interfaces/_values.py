"""The values in a message's fields: numpy arrays of an exact type, lists of an exact length.

The generated modules import these names; they are not part of the public interface.
"""

from collections.abc import Sized
from typing import Final, TypeVar, cast

import numpy as np
import numpy.typing as npt

from sunset_ros.errors import InterfaceError

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
    value.flags.writeable = False
    return value


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
