"""The services of `rcl_interfaces`, generated from their definitions."""

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
from sunset.interfaces.rcl_interfaces.msg import ListParametersResult
from sunset.interfaces.rcl_interfaces.msg import Parameter
from sunset.interfaces.rcl_interfaces.msg import ParameterDescriptor
from sunset.interfaces.rcl_interfaces.msg import ParameterValue
from sunset.interfaces.rcl_interfaces.msg import SetParametersResult

__all__ = [
    "DescribeParameters",
    "GetParameterTypes",
    "GetParameters",
    "ListParameters",
    "SetParameters",
    "SetParametersAtomically",
]

_STRUCT_0 = Struct("<Q")


class DescribeParameters(Service):
    """rcl_interfaces/srv/DescribeParameters."""

    __slots__ = ()
    __ros_name__ = "rcl_interfaces/srv/DescribeParameters"

    class Request(Message):
        """rcl_interfaces/srv/DescribeParameters_Request."""

        __slots__ = ('names',)
        __ros_name__ = "rcl_interfaces/srv/DescribeParameters_Request"
        __ros_fields__ = MappingProxyType({
            "names": "string[]",
        })

        names: list[str]

        def __init__(
            self,
            *,
            names: list[str] | None = None,
        ) -> None:
            self.names = [] if names is None else names

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.names = list(self.names)
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_size(out, len(self.names))
            write_strings(out, self.names)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            size, position = read_size(raw, position)
            new.names, position = read_strings(raw, position, size)
            return new, position

    class Response(Message):
        """rcl_interfaces/srv/DescribeParameters_Response."""

        __slots__ = ('descriptors',)
        __ros_name__ = "rcl_interfaces/srv/DescribeParameters_Response"
        __ros_fields__ = MappingProxyType({
            "descriptors": "rcl_interfaces/ParameterDescriptor[]",
        })

        descriptors: list[ParameterDescriptor]

        def __init__(
            self,
            *,
            descriptors: list[ParameterDescriptor] | None = None,
        ) -> None:
            self.descriptors = [] if descriptors is None else descriptors

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.descriptors = [ParameterDescriptor.copy(item) for item in self.descriptors]
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_size(out, len(self.descriptors))
            write_messages(out, self.descriptors, ParameterDescriptor)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            size, position = read_size(raw, position)
            new.descriptors, position = read_messages(raw, position, size, ParameterDescriptor)
            return new, position


class GetParameterTypes(Service):
    """rcl_interfaces/srv/GetParameterTypes."""

    __slots__ = ()
    __ros_name__ = "rcl_interfaces/srv/GetParameterTypes"

    class Request(Message):
        """rcl_interfaces/srv/GetParameterTypes_Request."""

        __slots__ = ('names',)
        __ros_name__ = "rcl_interfaces/srv/GetParameterTypes_Request"
        __ros_fields__ = MappingProxyType({
            "names": "string[]",
        })

        names: list[str]

        def __init__(
            self,
            *,
            names: list[str] | None = None,
        ) -> None:
            self.names = [] if names is None else names

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.names = list(self.names)
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_size(out, len(self.names))
            write_strings(out, self.names)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            size, position = read_size(raw, position)
            new.names, position = read_strings(raw, position, size)
            return new, position

    class Response(Message):
        """rcl_interfaces/srv/GetParameterTypes_Response."""

        __slots__ = ('types',)
        __ros_name__ = "rcl_interfaces/srv/GetParameterTypes_Response"
        __ros_fields__ = MappingProxyType({
            "types": "uint8[]",
        })

        types: npt.NDArray[np.uint8]

        def __init__(
            self,
            *,
            types: npt.ArrayLike | None = None,
        ) -> None:
            self.types = empty(UINT8) if types is None else array_of(types, UINT8)

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.types = frozen(self.types, UINT8)
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_array(out, self.types, UINT8)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            new.types, position = read_array(raw, position, UINT8)
            return new, position


class GetParameters(Service):
    """rcl_interfaces/srv/GetParameters."""

    __slots__ = ()
    __ros_name__ = "rcl_interfaces/srv/GetParameters"

    class Request(Message):
        """rcl_interfaces/srv/GetParameters_Request."""

        __slots__ = ('names',)
        __ros_name__ = "rcl_interfaces/srv/GetParameters_Request"
        __ros_fields__ = MappingProxyType({
            "names": "string[]",
        })

        names: list[str]

        def __init__(
            self,
            *,
            names: list[str] | None = None,
        ) -> None:
            self.names = [] if names is None else names

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.names = list(self.names)
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_size(out, len(self.names))
            write_strings(out, self.names)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            size, position = read_size(raw, position)
            new.names, position = read_strings(raw, position, size)
            return new, position

    class Response(Message):
        """rcl_interfaces/srv/GetParameters_Response."""

        __slots__ = ('values',)
        __ros_name__ = "rcl_interfaces/srv/GetParameters_Response"
        __ros_fields__ = MappingProxyType({
            "values": "rcl_interfaces/ParameterValue[]",
        })

        values: list[ParameterValue]

        def __init__(
            self,
            *,
            values: list[ParameterValue] | None = None,
        ) -> None:
            self.values = [] if values is None else values

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.values = [ParameterValue.copy(item) for item in self.values]
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_size(out, len(self.values))
            write_messages(out, self.values, ParameterValue)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            size, position = read_size(raw, position)
            new.values, position = read_messages(raw, position, size, ParameterValue)
            return new, position


class ListParameters(Service):
    """rcl_interfaces/srv/ListParameters."""

    __slots__ = ()
    __ros_name__ = "rcl_interfaces/srv/ListParameters"

    class Request(Message):
        """rcl_interfaces/srv/ListParameters_Request."""

        __slots__ = ('prefixes', 'depth')
        __ros_name__ = "rcl_interfaces/srv/ListParameters_Request"
        __ros_fields__ = MappingProxyType({
            "prefixes": "string[]",
            "depth": "uint64",
        })

        DEPTH_RECURSIVE = 0

        prefixes: list[str]
        depth: int

        def __init__(
            self,
            *,
            prefixes: list[str] | None = None,
            depth: int = 0,
        ) -> None:
            self.prefixes = [] if prefixes is None else prefixes
            self.depth = depth

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.prefixes = list(self.prefixes)
                new.depth = self.depth
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_size(out, len(self.prefixes))
            write_strings(out, self.prefixes)
            out += PAD8[len(out) & 7]
            out += _STRUCT_0.pack(
                self.depth,
            )

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            size, position = read_size(raw, position)
            new.prefixes, position = read_strings(raw, position, size)
            position = ((position + 3) & -8) + 4
            (
                new.depth,
            ) = _STRUCT_0.unpack_from(raw, position)
            position += 8
            return new, position

    class Response(Message):
        """rcl_interfaces/srv/ListParameters_Response."""

        __slots__ = ('result',)
        __ros_name__ = "rcl_interfaces/srv/ListParameters_Response"
        __ros_fields__ = MappingProxyType({
            "result": "rcl_interfaces/ListParametersResult",
        })

        result: ListParametersResult

        def __init__(
            self,
            *,
            result: ListParametersResult | None = None,
        ) -> None:
            self.result = ListParametersResult() if result is None else result

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.result = ListParametersResult.copy(self.result)
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            ListParametersResult.encode_into(self.result, out)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            new.result, position = ListParametersResult.decode_from(raw, position)
            return new, position


class SetParameters(Service):
    """rcl_interfaces/srv/SetParameters."""

    __slots__ = ()
    __ros_name__ = "rcl_interfaces/srv/SetParameters"

    class Request(Message):
        """rcl_interfaces/srv/SetParameters_Request."""

        __slots__ = ('parameters',)
        __ros_name__ = "rcl_interfaces/srv/SetParameters_Request"
        __ros_fields__ = MappingProxyType({
            "parameters": "rcl_interfaces/Parameter[]",
        })

        parameters: list[Parameter]

        def __init__(
            self,
            *,
            parameters: list[Parameter] | None = None,
        ) -> None:
            self.parameters = [] if parameters is None else parameters

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.parameters = [Parameter.copy(item) for item in self.parameters]
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_size(out, len(self.parameters))
            write_messages(out, self.parameters, Parameter)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            size, position = read_size(raw, position)
            new.parameters, position = read_messages(raw, position, size, Parameter)
            return new, position

    class Response(Message):
        """rcl_interfaces/srv/SetParameters_Response."""

        __slots__ = ('results',)
        __ros_name__ = "rcl_interfaces/srv/SetParameters_Response"
        __ros_fields__ = MappingProxyType({
            "results": "rcl_interfaces/SetParametersResult[]",
        })

        results: list[SetParametersResult]

        def __init__(
            self,
            *,
            results: list[SetParametersResult] | None = None,
        ) -> None:
            self.results = [] if results is None else results

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.results = [SetParametersResult.copy(item) for item in self.results]
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_size(out, len(self.results))
            write_messages(out, self.results, SetParametersResult)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            size, position = read_size(raw, position)
            new.results, position = read_messages(raw, position, size, SetParametersResult)
            return new, position


class SetParametersAtomically(Service):
    """rcl_interfaces/srv/SetParametersAtomically."""

    __slots__ = ()
    __ros_name__ = "rcl_interfaces/srv/SetParametersAtomically"

    class Request(Message):
        """rcl_interfaces/srv/SetParametersAtomically_Request."""

        __slots__ = ('parameters',)
        __ros_name__ = "rcl_interfaces/srv/SetParametersAtomically_Request"
        __ros_fields__ = MappingProxyType({
            "parameters": "rcl_interfaces/Parameter[]",
        })

        parameters: list[Parameter]

        def __init__(
            self,
            *,
            parameters: list[Parameter] | None = None,
        ) -> None:
            self.parameters = [] if parameters is None else parameters

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.parameters = [Parameter.copy(item) for item in self.parameters]
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            write_size(out, len(self.parameters))
            write_messages(out, self.parameters, Parameter)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            size, position = read_size(raw, position)
            new.parameters, position = read_messages(raw, position, size, Parameter)
            return new, position

    class Response(Message):
        """rcl_interfaces/srv/SetParametersAtomically_Response."""

        __slots__ = ('result',)
        __ros_name__ = "rcl_interfaces/srv/SetParametersAtomically_Response"
        __ros_fields__ = MappingProxyType({
            "result": "rcl_interfaces/SetParametersResult",
        })

        result: SetParametersResult

        def __init__(
            self,
            *,
            result: SetParametersResult | None = None,
        ) -> None:
            self.result = SetParametersResult() if result is None else result

        def copy(self) -> Self:
            new = object.__new__(self.__class__)
            try:
                new.result = SetParametersResult.copy(self.result)
            except (AttributeError, TypeError, InterfaceError) as error:
                raise misfit(self, error) from error
            return new

        def encode_into(self, out: bytearray) -> None:
            SetParametersResult.encode_into(self.result, out)

        @classmethod
        def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
            new = object.__new__(cls)
            new.result, position = SetParametersResult.decode_from(raw, position)
            return new, position
