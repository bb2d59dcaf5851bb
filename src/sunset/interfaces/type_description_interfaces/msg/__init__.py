"""The messages of `type_description_interfaces`, generated from their definitions."""

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

__all__ = [
    "Field",
    "FieldType",
    "IndividualTypeDescription",
    "KeyValue",
    "TypeDescription",
    "TypeSource",
]

_STRUCT_0 = Struct("<B")
_STRUCT_1 = Struct("<QQ")


class FieldType(Message):
    """type_description_interfaces/msg/FieldType."""

    __slots__ = ('type_id', 'capacity', 'string_capacity', 'nested_type_name')
    __ros_name__ = "type_description_interfaces/msg/FieldType"
    __ros_fields__ = MappingProxyType({
        "type_id": "uint8",
        "capacity": "uint64",
        "string_capacity": "uint64",
        "nested_type_name": "string<=255",
    })

    FIELD_TYPE_NOT_SET = 0
    FIELD_TYPE_NESTED_TYPE = 1
    FIELD_TYPE_INT8 = 2
    FIELD_TYPE_UINT8 = 3
    FIELD_TYPE_INT16 = 4
    FIELD_TYPE_UINT16 = 5
    FIELD_TYPE_INT32 = 6
    FIELD_TYPE_UINT32 = 7
    FIELD_TYPE_INT64 = 8
    FIELD_TYPE_UINT64 = 9
    FIELD_TYPE_FLOAT = 10
    FIELD_TYPE_DOUBLE = 11
    FIELD_TYPE_LONG_DOUBLE = 12
    FIELD_TYPE_CHAR = 13
    FIELD_TYPE_WCHAR = 14
    FIELD_TYPE_BOOLEAN = 15
    FIELD_TYPE_BYTE = 16
    FIELD_TYPE_STRING = 17
    FIELD_TYPE_WSTRING = 18
    FIELD_TYPE_FIXED_STRING = 19
    FIELD_TYPE_FIXED_WSTRING = 20
    FIELD_TYPE_BOUNDED_STRING = 21
    FIELD_TYPE_BOUNDED_WSTRING = 22
    FIELD_TYPE_NESTED_TYPE_ARRAY = 49
    FIELD_TYPE_INT8_ARRAY = 50
    FIELD_TYPE_UINT8_ARRAY = 51
    FIELD_TYPE_INT16_ARRAY = 52
    FIELD_TYPE_UINT16_ARRAY = 53
    FIELD_TYPE_INT32_ARRAY = 54
    FIELD_TYPE_UINT32_ARRAY = 55
    FIELD_TYPE_INT64_ARRAY = 56
    FIELD_TYPE_UINT64_ARRAY = 57
    FIELD_TYPE_FLOAT_ARRAY = 58
    FIELD_TYPE_DOUBLE_ARRAY = 59
    FIELD_TYPE_LONG_DOUBLE_ARRAY = 60
    FIELD_TYPE_CHAR_ARRAY = 61
    FIELD_TYPE_WCHAR_ARRAY = 62
    FIELD_TYPE_BOOLEAN_ARRAY = 63
    FIELD_TYPE_BYTE_ARRAY = 64
    FIELD_TYPE_STRING_ARRAY = 65
    FIELD_TYPE_WSTRING_ARRAY = 66
    FIELD_TYPE_FIXED_STRING_ARRAY = 67
    FIELD_TYPE_FIXED_WSTRING_ARRAY = 68
    FIELD_TYPE_BOUNDED_STRING_ARRAY = 69
    FIELD_TYPE_BOUNDED_WSTRING_ARRAY = 70
    FIELD_TYPE_NESTED_TYPE_BOUNDED_SEQUENCE = 97
    FIELD_TYPE_INT8_BOUNDED_SEQUENCE = 98
    FIELD_TYPE_UINT8_BOUNDED_SEQUENCE = 99
    FIELD_TYPE_INT16_BOUNDED_SEQUENCE = 100
    FIELD_TYPE_UINT16_BOUNDED_SEQUENCE = 101
    FIELD_TYPE_INT32_BOUNDED_SEQUENCE = 102
    FIELD_TYPE_UINT32_BOUNDED_SEQUENCE = 103
    FIELD_TYPE_INT64_BOUNDED_SEQUENCE = 104
    FIELD_TYPE_UINT64_BOUNDED_SEQUENCE = 105
    FIELD_TYPE_FLOAT_BOUNDED_SEQUENCE = 106
    FIELD_TYPE_DOUBLE_BOUNDED_SEQUENCE = 107
    FIELD_TYPE_LONG_DOUBLE_BOUNDED_SEQUENCE = 108
    FIELD_TYPE_CHAR_BOUNDED_SEQUENCE = 109
    FIELD_TYPE_WCHAR_BOUNDED_SEQUENCE = 110
    FIELD_TYPE_BOOLEAN_BOUNDED_SEQUENCE = 111
    FIELD_TYPE_BYTE_BOUNDED_SEQUENCE = 112
    FIELD_TYPE_STRING_BOUNDED_SEQUENCE = 113
    FIELD_TYPE_WSTRING_BOUNDED_SEQUENCE = 114
    FIELD_TYPE_FIXED_STRING_BOUNDED_SEQUENCE = 115
    FIELD_TYPE_FIXED_WSTRING_BOUNDED_SEQUENCE = 116
    FIELD_TYPE_BOUNDED_STRING_BOUNDED_SEQUENCE = 117
    FIELD_TYPE_BOUNDED_WSTRING_BOUNDED_SEQUENCE = 118
    FIELD_TYPE_NESTED_TYPE_UNBOUNDED_SEQUENCE = 145
    FIELD_TYPE_INT8_UNBOUNDED_SEQUENCE = 146
    FIELD_TYPE_UINT8_UNBOUNDED_SEQUENCE = 147
    FIELD_TYPE_INT16_UNBOUNDED_SEQUENCE = 148
    FIELD_TYPE_UINT16_UNBOUNDED_SEQUENCE = 149
    FIELD_TYPE_INT32_UNBOUNDED_SEQUENCE = 150
    FIELD_TYPE_UINT32_UNBOUNDED_SEQUENCE = 151
    FIELD_TYPE_INT64_UNBOUNDED_SEQUENCE = 152
    FIELD_TYPE_UINT64_UNBOUNDED_SEQUENCE = 153
    FIELD_TYPE_FLOAT_UNBOUNDED_SEQUENCE = 154
    FIELD_TYPE_DOUBLE_UNBOUNDED_SEQUENCE = 155
    FIELD_TYPE_LONG_DOUBLE_UNBOUNDED_SEQUENCE = 156
    FIELD_TYPE_CHAR_UNBOUNDED_SEQUENCE = 157
    FIELD_TYPE_WCHAR_UNBOUNDED_SEQUENCE = 158
    FIELD_TYPE_BOOLEAN_UNBOUNDED_SEQUENCE = 159
    FIELD_TYPE_BYTE_UNBOUNDED_SEQUENCE = 160
    FIELD_TYPE_STRING_UNBOUNDED_SEQUENCE = 161
    FIELD_TYPE_WSTRING_UNBOUNDED_SEQUENCE = 162
    FIELD_TYPE_FIXED_STRING_UNBOUNDED_SEQUENCE = 163
    FIELD_TYPE_FIXED_WSTRING_UNBOUNDED_SEQUENCE = 164
    FIELD_TYPE_BOUNDED_STRING_UNBOUNDED_SEQUENCE = 165
    FIELD_TYPE_BOUNDED_WSTRING_UNBOUNDED_SEQUENCE = 166

    type_id: int
    capacity: int
    string_capacity: int
    nested_type_name: str

    def __init__(
        self,
        *,
        type_id: int = 0,
        capacity: int = 0,
        string_capacity: int = 0,
        nested_type_name: str = "",
    ) -> None:
        self.type_id = type_id
        self.capacity = capacity
        self.string_capacity = string_capacity
        self.nested_type_name = nested_type_name

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.type_id = self.type_id
        new.capacity = self.capacity
        new.string_capacity = self.string_capacity
        new.nested_type_name = self.nested_type_name
        return new

    def encode_into(self, out: bytearray) -> None:
        out += _STRUCT_0.pack(
            self.type_id,
        )
        out += PAD8[len(out) & 7]
        out += _STRUCT_1.pack(
            self.capacity,
            self.string_capacity,
        )
        write_string(out, self.nested_type_name, 255)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (
            new.type_id,
        ) = _STRUCT_0.unpack_from(raw, position)
        position += 1
        position = ((position + 3) & -8) + 4
        (
            new.capacity,
            new.string_capacity,
        ) = _STRUCT_1.unpack_from(raw, position)
        position += 16
        new.nested_type_name, position = read_string(raw, position)
        return new, position


class Field(Message):
    """type_description_interfaces/msg/Field."""

    __slots__ = ('name', 'type', 'default_value')
    __ros_name__ = "type_description_interfaces/msg/Field"
    __ros_fields__ = MappingProxyType({
        "name": "string",
        "type": "type_description_interfaces/FieldType",
        "default_value": "string",
    })

    name: str
    type: FieldType
    default_value: str

    def __init__(
        self,
        *,
        name: str = "",
        type: FieldType | None = None,
        default_value: str = "",
    ) -> None:
        self.name = name
        self.type = FieldType() if type is None else type
        self.default_value = default_value

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.name = self.name
            new.type = FieldType.copy(self.type)
            new.default_value = self.default_value
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        write_string(out, self.name)
        FieldType.encode_into(self.type, out)
        write_string(out, self.default_value)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.name, position = read_string(raw, position)
        new.type, position = FieldType.decode_from(raw, position)
        new.default_value, position = read_string(raw, position)
        return new, position


class IndividualTypeDescription(Message):
    """type_description_interfaces/msg/IndividualTypeDescription."""

    __slots__ = ('type_name', 'fields')
    __ros_name__ = "type_description_interfaces/msg/IndividualTypeDescription"
    __ros_fields__ = MappingProxyType({
        "type_name": "string<=255",
        "fields": "type_description_interfaces/Field[]",
    })

    type_name: str
    fields: list[Field]

    def __init__(
        self,
        *,
        type_name: str = "",
        fields: list[Field] | None = None,
    ) -> None:
        self.type_name = type_name
        self.fields = [] if fields is None else fields

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.type_name = self.type_name
            new.fields = [Field.copy(item) for item in self.fields]
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        write_string(out, self.type_name, 255)
        write_size(out, len(self.fields))
        write_messages(out, self.fields, Field)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.type_name, position = read_string(raw, position)
        size, position = read_size(raw, position)
        new.fields, position = read_messages(raw, position, size, Field)
        return new, position


class KeyValue(Message):
    """type_description_interfaces/msg/KeyValue."""

    __slots__ = ('key', 'value')
    __ros_name__ = "type_description_interfaces/msg/KeyValue"
    __ros_fields__ = MappingProxyType({
        "key": "string",
        "value": "string",
    })

    key: str
    value: str

    def __init__(
        self,
        *,
        key: str = "",
        value: str = "",
    ) -> None:
        self.key = key
        self.value = value

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.key = self.key
        new.value = self.value
        return new

    def encode_into(self, out: bytearray) -> None:
        write_string(out, self.key)
        write_string(out, self.value)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.key, position = read_string(raw, position)
        new.value, position = read_string(raw, position)
        return new, position


class TypeDescription(Message):
    """type_description_interfaces/msg/TypeDescription."""

    __slots__ = ('type_description', 'referenced_type_descriptions')
    __ros_name__ = "type_description_interfaces/msg/TypeDescription"
    __ros_fields__ = MappingProxyType({
        "type_description": "type_description_interfaces/IndividualTypeDescription",
        "referenced_type_descriptions": "type_description_interfaces/IndividualTypeDescription[]",
    })

    type_description: IndividualTypeDescription
    referenced_type_descriptions: list[IndividualTypeDescription]

    def __init__(
        self,
        *,
        type_description: IndividualTypeDescription | None = None,
        referenced_type_descriptions: list[IndividualTypeDescription] | None = None,
    ) -> None:
        self.type_description = IndividualTypeDescription() if type_description is None else type_description
        self.referenced_type_descriptions = [] if referenced_type_descriptions is None else referenced_type_descriptions

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.type_description = IndividualTypeDescription.copy(self.type_description)
            new.referenced_type_descriptions = [IndividualTypeDescription.copy(item) for item in self.referenced_type_descriptions]
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        IndividualTypeDescription.encode_into(self.type_description, out)
        write_size(out, len(self.referenced_type_descriptions))
        write_messages(out, self.referenced_type_descriptions, IndividualTypeDescription)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.type_description, position = IndividualTypeDescription.decode_from(raw, position)
        size, position = read_size(raw, position)
        new.referenced_type_descriptions, position = read_messages(raw, position, size, IndividualTypeDescription)
        return new, position


class TypeSource(Message):
    """type_description_interfaces/msg/TypeSource."""

    __slots__ = ('type_name', 'encoding', 'raw_file_contents')
    __ros_name__ = "type_description_interfaces/msg/TypeSource"
    __ros_fields__ = MappingProxyType({
        "type_name": "string",
        "encoding": "string",
        "raw_file_contents": "string",
    })

    type_name: str
    encoding: str
    raw_file_contents: str

    def __init__(
        self,
        *,
        type_name: str = "",
        encoding: str = "",
        raw_file_contents: str = "",
    ) -> None:
        self.type_name = type_name
        self.encoding = encoding
        self.raw_file_contents = raw_file_contents

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        new.type_name = self.type_name
        new.encoding = self.encoding
        new.raw_file_contents = self.raw_file_contents
        return new

    def encode_into(self, out: bytearray) -> None:
        write_string(out, self.type_name)
        write_string(out, self.encoding)
        write_string(out, self.raw_file_contents)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.type_name, position = read_string(raw, position)
        new.encoding, position = read_string(raw, position)
        new.raw_file_contents, position = read_string(raw, position)
        return new, position
