"""The messages of `rcl_interfaces`, generated from their definitions."""

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
    "FloatingPointRange",
    "IntegerRange",
    "ListParametersResult",
    "Log",
    "Parameter",
    "ParameterDescriptor",
    "ParameterEvent",
    "ParameterType",
    "ParameterValue",
    "SetParametersResult",
]

_STRUCT_0 = Struct("<ddd")
_STRUCT_1 = Struct("<qqQ")
_STRUCT_2 = Struct("<B")
_STRUCT_3 = Struct("<I")
_STRUCT_4 = Struct("<B?")
_STRUCT_5 = Struct("<qd")
_STRUCT_6 = Struct("<??")
_STRUCT_7 = Struct("<?")


class FloatingPointRange(Message):
    """rcl_interfaces/msg/FloatingPointRange."""

    __slots__ = ('from_value', 'to_value', 'step')
    __ros_name__ = "rcl_interfaces/msg/FloatingPointRange"
    __ros_fields__ = MappingProxyType({
        "from_value": "float64",
        "to_value": "float64",
        "step": "float64",
    })

    from_value: float
    to_value: float
    step: float

    def __init__(
        self,
        *,
        from_value: float = 0.0,
        to_value: float = 0.0,
        step: float = 0.0,
    ) -> None:
        self.from_value = from_value
        self.to_value = to_value
        self.step = step

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.from_value = self.from_value
        new.to_value = self.to_value
        new.step = self.step
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD8[len(out) & 7]
        out += _STRUCT_0.pack(
            self.from_value,
            self.to_value,
            self.step,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = ((position + 3) & -8) + 4
        (
            new.from_value,
            new.to_value,
            new.step,
        ) = _STRUCT_0.unpack_from(raw, position)
        position += 24
        return new, position


class IntegerRange(Message):
    """rcl_interfaces/msg/IntegerRange."""

    __slots__ = ('from_value', 'to_value', 'step')
    __ros_name__ = "rcl_interfaces/msg/IntegerRange"
    __ros_fields__ = MappingProxyType({
        "from_value": "int64",
        "to_value": "int64",
        "step": "uint64",
    })

    from_value: int
    to_value: int
    step: int

    def __init__(
        self,
        *,
        from_value: int = 0,
        to_value: int = 0,
        step: int = 0,
    ) -> None:
        self.from_value = from_value
        self.to_value = to_value
        self.step = step

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.from_value = self.from_value
        new.to_value = self.to_value
        new.step = self.step
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD8[len(out) & 7]
        out += _STRUCT_1.pack(
            self.from_value,
            self.to_value,
            self.step,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = ((position + 3) & -8) + 4
        (
            new.from_value,
            new.to_value,
            new.step,
        ) = _STRUCT_1.unpack_from(raw, position)
        position += 24
        return new, position


class ListParametersResult(Message):
    """rcl_interfaces/msg/ListParametersResult."""

    __slots__ = ('names', 'prefixes')
    __ros_name__ = "rcl_interfaces/msg/ListParametersResult"
    __ros_fields__ = MappingProxyType({
        "names": "string[]",
        "prefixes": "string[]",
    })

    names: list[str]
    prefixes: list[str]

    def __init__(
        self,
        *,
        names: list[str] | None = None,
        prefixes: list[str] | None = None,
    ) -> None:
        self.names = [] if names is None else names
        self.prefixes = [] if prefixes is None else prefixes

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.names = list(self.names)
            new.prefixes = list(self.prefixes)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        if len(self.names) or len(self.prefixes):
            write_size(out, len(self.names))
            write_strings(out, self.names)
            write_size(out, len(self.prefixes))
            write_strings(out, self.prefixes)
        else:
            out += PAD4[len(out) & 3] + b"\0" * 8

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = (position + 3) & -4
        if raw.startswith(b"\0" * 8, position):
            new.names = []
            new.prefixes = []
            position += 8
        else:
            size, position = read_size(raw, position)
            new.names, position = read_strings(raw, position, size)
            size, position = read_size(raw, position)
            new.prefixes, position = read_strings(raw, position, size)
        return new, position


class Log(Message):
    """rcl_interfaces/msg/Log."""

    __slots__ = ('stamp', 'level', 'name', 'msg', 'file', 'function', 'line')
    __ros_name__ = "rcl_interfaces/msg/Log"
    __ros_fields__ = MappingProxyType({
        "stamp": "builtin_interfaces/Time",
        "level": "uint8",
        "name": "string",
        "msg": "string",
        "file": "string",
        "function": "string",
        "line": "uint32",
    })

    DEBUG = 10
    INFO = 20
    WARN = 30
    ERROR = 40
    FATAL = 50

    stamp: Time
    level: int
    name: str
    msg: str
    file: str
    function: str
    line: int

    def __init__(
        self,
        *,
        stamp: Time | None = None,
        level: int = 0,
        name: str = "",
        msg: str = "",
        file: str = "",
        function: str = "",
        line: int = 0,
    ) -> None:
        self.stamp = Time() if stamp is None else stamp
        self.level = level
        self.name = name
        self.msg = msg
        self.file = file
        self.function = function
        self.line = line

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.stamp = Time.copy(self.stamp)
            new.level = self.level
            new.name = self.name
            new.msg = self.msg
            new.file = self.file
            new.function = self.function
            new.line = self.line
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Time.encode_into(self.stamp, out)
        out += _STRUCT_2.pack(
            self.level,
        )
        write_string(out, self.name)
        write_string(out, self.msg)
        write_string(out, self.file)
        write_string(out, self.function)
        out += PAD4[len(out) & 3]
        out += _STRUCT_3.pack(
            self.line,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.stamp, position = Time.decode_from(raw, position)
        (
            new.level,
        ) = _STRUCT_2.unpack_from(raw, position)
        position += 1
        new.name, position = read_string(raw, position)
        new.msg, position = read_string(raw, position)
        new.file, position = read_string(raw, position)
        new.function, position = read_string(raw, position)
        position = (position + 3) & -4
        (
            new.line,
        ) = _STRUCT_3.unpack_from(raw, position)
        position += 4
        return new, position


class ParameterValue(Message):
    """rcl_interfaces/msg/ParameterValue."""

    __slots__ = ('type', 'bool_value', 'integer_value', 'double_value', 'string_value', 'byte_array_value', 'bool_array_value', 'integer_array_value', 'double_array_value', 'string_array_value')
    __ros_name__ = "rcl_interfaces/msg/ParameterValue"
    __ros_fields__ = MappingProxyType({
        "type": "uint8",
        "bool_value": "bool",
        "integer_value": "int64",
        "double_value": "float64",
        "string_value": "string",
        "byte_array_value": "byte[]",
        "bool_array_value": "bool[]",
        "integer_array_value": "int64[]",
        "double_array_value": "float64[]",
        "string_array_value": "string[]",
    })

    type: int
    bool_value: bool
    integer_value: int
    double_value: float
    string_value: str
    byte_array_value: list[bytes]
    bool_array_value: list[bool]
    integer_array_value: npt.NDArray[np.int64]
    double_array_value: npt.NDArray[np.float64]
    string_array_value: list[str]

    def __init__(
        self,
        *,
        type: int = 0,
        bool_value: bool = False,
        integer_value: int = 0,
        double_value: float = 0.0,
        string_value: str = "",
        byte_array_value: list[bytes] | None = None,
        bool_array_value: list[bool] | None = None,
        integer_array_value: npt.ArrayLike | None = None,
        double_array_value: npt.ArrayLike | None = None,
        string_array_value: list[str] | None = None,
    ) -> None:
        self.type = type
        self.bool_value = bool_value
        self.integer_value = integer_value
        self.double_value = double_value
        self.string_value = string_value
        self.byte_array_value = [] if byte_array_value is None else byte_array_value
        self.bool_array_value = [] if bool_array_value is None else bool_array_value
        self.integer_array_value = empty(INT64) if integer_array_value is None else array_of(integer_array_value, INT64)
        self.double_array_value = empty(FLOAT64) if double_array_value is None else array_of(double_array_value, FLOAT64)
        self.string_array_value = [] if string_array_value is None else string_array_value

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.type = self.type
            new.bool_value = self.bool_value
            new.integer_value = self.integer_value
            new.double_value = self.double_value
            new.string_value = self.string_value
            new.byte_array_value = list(self.byte_array_value)
            new.bool_array_value = list(self.bool_array_value)
            new.integer_array_value = frozen(self.integer_array_value, INT64)
            new.double_array_value = frozen(self.double_array_value, FLOAT64)
            new.string_array_value = list(self.string_array_value)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        out += _STRUCT_4.pack(
            self.type,
            BOOLS[self.bool_value],
        )
        out += PAD8[len(out) & 7]
        out += _STRUCT_5.pack(
            self.integer_value,
            self.double_value,
        )
        write_string(out, self.string_value)
        if len(self.byte_array_value) or len(self.bool_array_value) or len(self.integer_array_value) or len(self.double_array_value) or len(self.string_array_value):
            write_size(out, len(self.byte_array_value))
            write_bytes(out, self.byte_array_value)
            write_size(out, len(self.bool_array_value))
            write_bools(out, self.bool_array_value)
            write_array(out, self.integer_array_value, INT64)
            write_array(out, self.double_array_value, FLOAT64)
            write_size(out, len(self.string_array_value))
            write_strings(out, self.string_array_value)
        else:
            out += PAD4[len(out) & 3] + b"\0" * 20

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (
            new.type,
            new.bool_value,
        ) = _STRUCT_4.unpack_from(raw, position)
        position += 2
        position = ((position + 3) & -8) + 4
        (
            new.integer_value,
            new.double_value,
        ) = _STRUCT_5.unpack_from(raw, position)
        position += 16
        new.string_value, position = read_string(raw, position)
        position = (position + 3) & -4
        if raw.startswith(b"\0" * 20, position):
            new.byte_array_value = []
            new.bool_array_value = []
            new.integer_array_value = empty(INT64)
            new.double_array_value = empty(FLOAT64)
            new.string_array_value = []
            position += 20
        else:
            size, position = read_size(raw, position)
            new.byte_array_value, position = read_bytes(raw, position, size)
            size, position = read_size(raw, position)
            new.bool_array_value, position = read_bools(raw, position, size)
            new.integer_array_value, position = read_array(raw, position, INT64)
            new.double_array_value, position = read_array(raw, position, FLOAT64)
            size, position = read_size(raw, position)
            new.string_array_value, position = read_strings(raw, position, size)
        return new, position


class Parameter(Message):
    """rcl_interfaces/msg/Parameter."""

    __slots__ = ('name', 'value')
    __ros_name__ = "rcl_interfaces/msg/Parameter"
    __ros_fields__ = MappingProxyType({
        "name": "string",
        "value": "rcl_interfaces/ParameterValue",
    })

    name: str
    value: ParameterValue

    def __init__(
        self,
        *,
        name: str = "",
        value: ParameterValue | None = None,
    ) -> None:
        self.name = name
        self.value = ParameterValue() if value is None else value

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.name = self.name
            new.value = ParameterValue.copy(self.value)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        write_string(out, self.name)
        ParameterValue.encode_into(self.value, out)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.name, position = read_string(raw, position)
        new.value, position = ParameterValue.decode_from(raw, position)
        return new, position


class ParameterDescriptor(Message):
    """rcl_interfaces/msg/ParameterDescriptor."""

    __slots__ = ('name', 'type', 'description', 'additional_constraints', 'read_only', 'dynamic_typing', 'floating_point_range', 'integer_range')
    __ros_name__ = "rcl_interfaces/msg/ParameterDescriptor"
    __ros_fields__ = MappingProxyType({
        "name": "string",
        "type": "uint8",
        "description": "string",
        "additional_constraints": "string",
        "read_only": "bool",
        "dynamic_typing": "bool",
        "floating_point_range": "rcl_interfaces/FloatingPointRange[<=1]",
        "integer_range": "rcl_interfaces/IntegerRange[<=1]",
    })

    name: str
    type: int
    description: str
    additional_constraints: str
    read_only: bool
    dynamic_typing: bool
    floating_point_range: list[FloatingPointRange]
    integer_range: list[IntegerRange]

    def __init__(
        self,
        *,
        name: str = "",
        type: int = 0,
        description: str = "",
        additional_constraints: str = "",
        read_only: bool = False,
        dynamic_typing: bool = False,
        floating_point_range: list[FloatingPointRange] | None = None,
        integer_range: list[IntegerRange] | None = None,
    ) -> None:
        self.name = name
        self.type = type
        self.description = description
        self.additional_constraints = additional_constraints
        self.read_only = read_only
        self.dynamic_typing = dynamic_typing
        self.floating_point_range = [] if floating_point_range is None else floating_point_range
        self.integer_range = [] if integer_range is None else integer_range

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.name = self.name
            new.type = self.type
            new.description = self.description
            new.additional_constraints = self.additional_constraints
            new.read_only = self.read_only
            new.dynamic_typing = self.dynamic_typing
            new.floating_point_range = [FloatingPointRange.copy(item) for item in self.floating_point_range]
            new.integer_range = [IntegerRange.copy(item) for item in self.integer_range]
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        write_string(out, self.name)
        out += _STRUCT_2.pack(
            self.type,
        )
        write_string(out, self.description)
        write_string(out, self.additional_constraints)
        out += _STRUCT_6.pack(
            BOOLS[self.read_only],
            BOOLS[self.dynamic_typing],
        )
        if len(self.floating_point_range) or len(self.integer_range):
            write_size(out, len(self.floating_point_range))
            write_messages(out, at_most(self.floating_point_range, 1), FloatingPointRange)
            write_size(out, len(self.integer_range))
            write_messages(out, at_most(self.integer_range, 1), IntegerRange)
        else:
            out += PAD4[len(out) & 3] + b"\0" * 8

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.name, position = read_string(raw, position)
        (
            new.type,
        ) = _STRUCT_2.unpack_from(raw, position)
        position += 1
        new.description, position = read_string(raw, position)
        new.additional_constraints, position = read_string(raw, position)
        (
            new.read_only,
            new.dynamic_typing,
        ) = _STRUCT_6.unpack_from(raw, position)
        position += 2
        position = (position + 3) & -4
        if raw.startswith(b"\0" * 8, position):
            new.floating_point_range = []
            new.integer_range = []
            position += 8
        else:
            size, position = read_size(raw, position)
            new.floating_point_range, position = read_messages(raw, position, size, FloatingPointRange)
            size, position = read_size(raw, position)
            new.integer_range, position = read_messages(raw, position, size, IntegerRange)
        return new, position


class ParameterEvent(Message):
    """rcl_interfaces/msg/ParameterEvent."""

    __slots__ = ('stamp', 'node', 'new_parameters', 'changed_parameters', 'deleted_parameters')
    __ros_name__ = "rcl_interfaces/msg/ParameterEvent"
    __ros_fields__ = MappingProxyType({
        "stamp": "builtin_interfaces/Time",
        "node": "string",
        "new_parameters": "rcl_interfaces/Parameter[]",
        "changed_parameters": "rcl_interfaces/Parameter[]",
        "deleted_parameters": "rcl_interfaces/Parameter[]",
    })

    stamp: Time
    node: str
    new_parameters: list[Parameter]
    changed_parameters: list[Parameter]
    deleted_parameters: list[Parameter]

    def __init__(
        self,
        *,
        stamp: Time | None = None,
        node: str = "",
        new_parameters: list[Parameter] | None = None,
        changed_parameters: list[Parameter] | None = None,
        deleted_parameters: list[Parameter] | None = None,
    ) -> None:
        self.stamp = Time() if stamp is None else stamp
        self.node = node
        self.new_parameters = [] if new_parameters is None else new_parameters
        self.changed_parameters = [] if changed_parameters is None else changed_parameters
        self.deleted_parameters = [] if deleted_parameters is None else deleted_parameters

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.stamp = Time.copy(self.stamp)
            new.node = self.node
            new.new_parameters = [Parameter.copy(item) for item in self.new_parameters]
            new.changed_parameters = [Parameter.copy(item) for item in self.changed_parameters]
            new.deleted_parameters = [Parameter.copy(item) for item in self.deleted_parameters]
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Time.encode_into(self.stamp, out)
        write_string(out, self.node)
        if len(self.new_parameters) or len(self.changed_parameters) or len(self.deleted_parameters):
            write_size(out, len(self.new_parameters))
            write_messages(out, self.new_parameters, Parameter)
            write_size(out, len(self.changed_parameters))
            write_messages(out, self.changed_parameters, Parameter)
            write_size(out, len(self.deleted_parameters))
            write_messages(out, self.deleted_parameters, Parameter)
        else:
            out += PAD4[len(out) & 3] + b"\0" * 12

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.stamp, position = Time.decode_from(raw, position)
        new.node, position = read_string(raw, position)
        position = (position + 3) & -4
        if raw.startswith(b"\0" * 12, position):
            new.new_parameters = []
            new.changed_parameters = []
            new.deleted_parameters = []
            position += 12
        else:
            size, position = read_size(raw, position)
            new.new_parameters, position = read_messages(raw, position, size, Parameter)
            size, position = read_size(raw, position)
            new.changed_parameters, position = read_messages(raw, position, size, Parameter)
            size, position = read_size(raw, position)
            new.deleted_parameters, position = read_messages(raw, position, size, Parameter)
        return new, position


class ParameterType(Message):
    """rcl_interfaces/msg/ParameterType."""

    __slots__ = ()
    __ros_name__ = "rcl_interfaces/msg/ParameterType"
    __ros_fields__ = MappingProxyType({
    })

    PARAMETER_NOT_SET = 0
    PARAMETER_BOOL = 1
    PARAMETER_INTEGER = 2
    PARAMETER_DOUBLE = 3
    PARAMETER_STRING = 4
    PARAMETER_BYTE_ARRAY = 5
    PARAMETER_BOOL_ARRAY = 6
    PARAMETER_INTEGER_ARRAY = 7
    PARAMETER_DOUBLE_ARRAY = 8
    PARAMETER_STRING_ARRAY = 9

    def __init__(self) -> None:
        pass

    def copy(self) -> Self:
        return object.__new__(self.__class__)

    def encode_into(self, out: bytearray) -> None:
        out.append(0)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        return cls(), read_dummy(raw, position)


class SetParametersResult(Message):
    """rcl_interfaces/msg/SetParametersResult."""

    __slots__ = ('successful', 'reason')
    __ros_name__ = "rcl_interfaces/msg/SetParametersResult"
    __ros_fields__ = MappingProxyType({
        "successful": "bool",
        "reason": "string",
    })

    successful: bool
    reason: str

    def __init__(
        self,
        *,
        successful: bool = False,
        reason: str = "",
    ) -> None:
        self.successful = successful
        self.reason = reason

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.successful = self.successful
        new.reason = self.reason
        return new

    def encode_into(self, out: bytearray) -> None:
        out += _STRUCT_7.pack(
            BOOLS[self.successful],
        )
        write_string(out, self.reason)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (
            new.successful,
        ) = _STRUCT_7.unpack_from(raw, position)
        position += 1
        new.reason, position = read_string(raw, position)
        return new, position
