"""The services of `type_description_interfaces`, generated from their definitions."""

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
from sunset.interfaces.type_description_interfaces.msg import KeyValue
from sunset.interfaces.type_description_interfaces.msg import TypeDescription
from sunset.interfaces.type_description_interfaces.msg import TypeSource

__all__ = [
    "GetTypeDescription",
]

_STRUCT_0 = Struct("<?")


class GetTypeDescription(Service):
    """type_description_interfaces/srv/GetTypeDescription."""

    __slots__ = ()
    __ros_name__ = "type_description_interfaces/srv/GetTypeDescription"

    class Request(Message):
        """type_description_interfaces/srv/GetTypeDescription_Request."""

        __slots__ = ('type_name', 'type_hash', 'include_type_sources')
        __ros_name__ = "type_description_interfaces/srv/GetTypeDescription_Request"
        __ros_fields__ = MappingProxyType({
            "type_name": "string",
            "type_hash": "string",
            "include_type_sources": "bool",
        })

        type_name: str
        type_hash: str
        include_type_sources: bool

        def __init__(
            self,
            *,
            type_name: str = "",
            type_hash: str = "",
            include_type_sources: bool = True,
        ) -> None:
            self.type_name = type_name
            self.type_hash = type_hash
            self.include_type_sources = include_type_sources

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            new.type_name = self.type_name
            new.type_hash = self.type_hash
            new.include_type_sources = self.include_type_sources
            return new

        def encode_into(self, out: bytearray) -> None:
            write_string(out, self.type_name)
            write_string(out, self.type_hash)
            out += _STRUCT_0.pack(
                BOOLS[self.include_type_sources],
            )

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            new.type_name, position = read_string(raw, position)
            new.type_hash, position = read_string(raw, position)
            (
                new.include_type_sources,
            ) = _STRUCT_0.unpack_from(raw, position)
            position += 1
            return new, position

    class Response(Message):
        """type_description_interfaces/srv/GetTypeDescription_Response."""

        __slots__ = ('successful', 'failure_reason', 'type_description', 'type_sources', 'extra_information')
        __ros_name__ = "type_description_interfaces/srv/GetTypeDescription_Response"
        __ros_fields__ = MappingProxyType({
            "successful": "bool",
            "failure_reason": "string",
            "type_description": "type_description_interfaces/TypeDescription",
            "type_sources": "type_description_interfaces/TypeSource[]",
            "extra_information": "type_description_interfaces/KeyValue[]",
        })

        successful: bool
        failure_reason: str
        type_description: TypeDescription
        type_sources: list[TypeSource]
        extra_information: list[KeyValue]

        def __init__(
            self,
            *,
            successful: bool = False,
            failure_reason: str = "",
            type_description: TypeDescription | None = None,
            type_sources: list[TypeSource] | None = None,
            extra_information: list[KeyValue] | None = None,
        ) -> None:
            self.successful = successful
            self.failure_reason = failure_reason
            self.type_description = TypeDescription() if type_description is None else type_description
            self.type_sources = [] if type_sources is None else type_sources
            self.extra_information = [] if extra_information is None else extra_information

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.successful = self.successful
                new.failure_reason = self.failure_reason
                new.type_description = TypeDescription.copy(self.type_description)
                new.type_sources = [TypeSource.copy(item) for item in self.type_sources]
                new.extra_information = [KeyValue.copy(item) for item in self.extra_information]
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            out += _STRUCT_0.pack(
                BOOLS[self.successful],
            )
            write_string(out, self.failure_reason)
            TypeDescription.encode_into(self.type_description, out)
            if len(self.type_sources) or len(self.extra_information):
                write_size(out, len(self.type_sources))
                write_messages(out, self.type_sources, TypeSource)
                write_size(out, len(self.extra_information))
                write_messages(out, self.extra_information, KeyValue)
            else:
                out += PAD4[len(out) & 3] + b"\0" * 8

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            (
                new.successful,
            ) = _STRUCT_0.unpack_from(raw, position)
            position += 1
            new.failure_reason, position = read_string(raw, position)
            new.type_description, position = TypeDescription.decode_from(raw, position)
            position = (position + 3) & -4
            if raw.startswith(b"\0" * 8, position):
                new.type_sources = []
                new.extra_information = []
                position += 8
            else:
                size, position = read_size(raw, position)
                new.type_sources, position = read_messages(raw, position, size, TypeSource)
                size, position = read_size(raw, position)
                new.extra_information, position = read_messages(raw, position, size, KeyValue)
            return new, position
