"""Parameters, as in `rclpy.parameter`."""

from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from math import isclose
from typing import TypeAlias, cast

import numpy as np
import numpy.typing as npt

from sunset_ros.exceptions import InvalidParameterTypeException
from sunset_ros.interfaces.rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterType,
    ParameterValue,
)
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter as ParameterMessage

Value: TypeAlias = (
    bool | int | float | str | list[bytes] | list[bool] | list[int] | list[float] | list[str] | None
)
"""The values of parameters."""

_Items: TypeAlias = Sequence[object] | npt.NDArray[np.generic]
_INT64 = range(-(2**63), 2**63)


@dataclass(frozen=True, slots=True, init=False, repr=False)
class Parameter:
    """A name with a value of a fixed set of types, None for not set; the type is derived from it if None.

    Raises:
        InvalidParameterTypeException: the value is not of the type, or a parameter cannot hold it.
    """

    class Type(IntEnum):
        """The type of a parameter's value; numbers as in rcl_interfaces/msg/ParameterType."""

        NOT_SET = ParameterType.PARAMETER_NOT_SET
        BOOL = ParameterType.PARAMETER_BOOL
        INTEGER = ParameterType.PARAMETER_INTEGER
        DOUBLE = ParameterType.PARAMETER_DOUBLE
        STRING = ParameterType.PARAMETER_STRING
        BYTE_ARRAY = ParameterType.PARAMETER_BYTE_ARRAY
        BOOL_ARRAY = ParameterType.PARAMETER_BOOL_ARRAY
        INTEGER_ARRAY = ParameterType.PARAMETER_INTEGER_ARRAY
        DOUBLE_ARRAY = ParameterType.PARAMETER_DOUBLE_ARRAY
        STRING_ARRAY = ParameterType.PARAMETER_STRING_ARRAY

        @classmethod
        def from_parameter_value(cls, value: object) -> "Parameter.Type":
            """Return the type of a Python value.

            >>> Parameter.Type.from_parameter_value([1, 2]).name
            'INTEGER_ARRAY'
            """
            if value is None:
                return cls.NOT_SET
            for kind, python in _SCALARS.items():
                if isinstance(value, python):
                    return kind
            if isinstance(value, (list, tuple, array, np.ndarray)):
                return cls._of_sequence(value)
            raise InvalidParameterTypeException(
                f"A parameter cannot hold {value!r}: it must be a bool, int, float or str, or a list of one of these."
            )

        @classmethod
        def _of_sequence(cls, values: Iterable[object]) -> "Parameter.Type":
            items = [item.item() if isinstance(item, np.generic) else item for item in values]
            for kind, python in _ELEMENTS.items():
                if all(isinstance(item, python) for item in items):
                    return kind
            raise InvalidParameterTypeException(
                f"A parameter cannot hold {values!r}: the elements of a list must all be of one type."
            )

        def check(self, value: object) -> bool:
            """Return whether a Python value is of this type; an empty list is of any list type."""
            actual = type(self).from_parameter_value(value)
            return actual is self or (
                self in _ELEMENTS and actual in _ELEMENTS and len(cast("_Items", value)) == 0
            )

    name: str
    type_: Type
    value: Value = field(hash=False)

    def __init__(self, name: str, type_: Type | None = None, value: object = None) -> None:
        if type_ is None:
            type_ = Parameter.Type.from_parameter_value(value)
        elif not isinstance(type_, Parameter.Type):
            raise InvalidParameterTypeException(
                f"The type of parameter {name!r} must be a Parameter.Type, got {type_!r}."
            )
        elif not type_.check(value):
            actual = Parameter.Type.from_parameter_value(value).name
            raise InvalidParameterTypeException(
                f"Parameter {name!r} must be {type_.name}, got {value!r}, which is {actual}."
            )
        normalised = _normalised(type_, value)
        integers = normalised if isinstance(normalised, list) else [normalised]
        if any(isinstance(item, int) and item not in _INT64 for item in integers):
            raise InvalidParameterTypeException(f"Parameter {name!r} must fit into 64 bits, got {value!r}.")
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "type_", type_)
        object.__setattr__(self, "value", normalised)

    def __repr__(self) -> str:
        return f"Parameter(name={self.name!r}, type={self.type_.name}, value={self.value!r})"

    def get_parameter_value(self) -> ParameterValue:
        """Return the value as a message."""
        message = ParameterValue(type=self.type_.value)
        if self.type_ is not Parameter.Type.NOT_SET:
            dtype = _DTYPES.get(self.type_)
            setattr(message, _field(self.type_), self.value if dtype is None else np.array(self.value, dtype))
        return message

    def to_parameter_msg(self) -> ParameterMessage:
        """Return name and value as a message."""
        return ParameterMessage(name=self.name, value=self.get_parameter_value())

    @classmethod
    def from_parameter_msg(cls, param_msg: ParameterMessage) -> "Parameter":
        """Return what a message says; see `parameter_value_to_python`."""
        value = parameter_value_to_python(param_msg.value)
        return cls(param_msg.name, Parameter.Type(param_msg.value.type), value)


_SCALARS = {
    Parameter.Type.BOOL: bool,
    Parameter.Type.INTEGER: int,
    Parameter.Type.DOUBLE: float,
    Parameter.Type.STRING: str,
}
_ELEMENTS = {
    Parameter.Type.BYTE_ARRAY: bytes,
    Parameter.Type.BOOL_ARRAY: bool,
    Parameter.Type.INTEGER_ARRAY: int,
    Parameter.Type.DOUBLE_ARRAY: float,
    Parameter.Type.STRING_ARRAY: str,
}
_DTYPES = {Parameter.Type.INTEGER_ARRAY: np.int64, Parameter.Type.DOUBLE_ARRAY: np.float64}


def parameter_value_to_python(parameter_value: ParameterValue) -> Value:
    """Return the Python value of a message; None for not set.

    Raises:
        InvalidParameterTypeException: the message names no known type.
    """
    try:
        kind = Parameter.Type(parameter_value.type)
    except ValueError as error:
        raise InvalidParameterTypeException(f"Parameter type {parameter_value.type} is unknown.") from error
    if kind is Parameter.Type.NOT_SET:
        return None
    return _normalised(kind, getattr(parameter_value, _field(kind)))


def scalar_of(parameter_value: ParameterValue) -> bool | int | float | str | None:
    """Return the Python value of a message; None for a list, and for an unset value.

    >>> scalar_of(ParameterValue(type=3, double_value=0.5)), scalar_of(ParameterValue(type=9, string_array_value=["a"]))
    (0.5, None)
    """
    number = parameter_value.type
    return getattr(parameter_value, _field(Parameter.Type(number))) if number in _SCALARS else None


def _field(kind: Parameter.Type) -> str:
    """Return the field of `ParameterValue` that holds a value of a type, such as `bool_array_value`."""
    return f"{kind.name.lower()}_value"


def _normalised(kind: Parameter.Type, value: object) -> Value:
    """Return a value of Python's own types, such as an int for an IntEnum."""
    if kind is Parameter.Type.NOT_SET:
        return None
    if kind in _ELEMENTS:
        python = _ELEMENTS[kind]
        items = value.tolist() if isinstance(value, (np.ndarray, array)) else cast("_Items", value)
        return cast("Value", [item if type(item) is python else python(item) for item in items])
    scalar: Value = _SCALARS[kind](value)
    return scalar


def refusal(parameter: Parameter, descriptor: ParameterDescriptor) -> str | None:
    """Return the reason why a descriptor does not admit a value, or None if it does.

    Whether it is read-only is the caller's to check, since a declaration sets such a parameter once.
    """
    expected, name, value = Parameter.Type(descriptor.type), parameter.name, parameter.value
    if not descriptor.dynamic_typing and parameter.type_ is not expected:
        return f"Wrong parameter type for {name}: expected {expected.name}, got {parameter.type_.name} ({value!r})."
    is_double = parameter.type_ is Parameter.Type.DOUBLE
    ranges: Sequence[FloatingPointRange | IntegerRange]
    ranges = descriptor.floating_point_range if is_double else descriptor.integer_range
    if not ranges or not isinstance(value, int | float) or isinstance(value, bool):
        return None
    low, high = sorted((ranges[0].from_value, ranges[0].to_value))
    step, form = ranges[0].step, "g" if is_double else "d"
    if value in {low, high} or (is_double and (isclose(value, low) or isclose(value, high))):
        return None
    if not low <= value <= high:  # also when it is not a number
        return f"Parameter {name} must be from {low:{form}} to {high:{form}}, got {value:{form}}."
    steps = (value - low) / (step or 1)
    if step and not (isclose(steps, round(steps), abs_tol=1e-9) if is_double else (value - low) % step == 0):
        return f"Parameter {name} must be {low:{form}} plus a multiple of {step:{form}}, got {value:{form}}."
    return None
