"""Names and types on the wire: how ROS 2 calls a topic, a service and a type in DDS, and types for the wheel."""

import re
from functools import cache
from typing import Any, Final, NamedTuple

from cyclonedds.idl import make_idl_struct, types

from sunset.interfaces import FieldType, Message, Service, field_types, get_message, type_name
from sunset.rmw.port import EndpointKind

__all__ = [
    "HEADER_SIZE",
    "RosName",
    "dds_type",
    "dds_type_name",
    "ros_name",
    "service_types",
    "topic_name",
    "topic_names_of_service",
]

HEADER_SIZE: Final = 16
"""Bytes before the fields of a request or response: the client's 64-bit id and its 64-bit running number."""

_HEADER: Final = {"client_id": types.uint64, "sequence_number": types.int64}
_DUMMY: Final = {"structure_needs_at_least_one_member": types.uint8}
_PRIMITIVES: Final[dict[str, Any]] = {
    "bool": bool,
    "byte": types.byte,
    "int8": types.int8,
    "uint8": types.uint8,
    "int16": types.int16,
    "uint16": types.uint16,
    "int32": types.int32,
    "uint32": types.uint32,
    "int64": types.int64,
    "uint64": types.uint64,
    "float32": types.float32,
    "float64": types.float64,
    "string": str,
}
_TYPE_NAME: Final = re.compile(r"(\w+)::(msg|srv)::dds_::(\w+?)(_Request|_Response)?_")


def dds_type_name(name: str) -> str:
    """Return the DDS name of a message.

    >>> dds_type_name("std_srvs/srv/SetBool_Request")
    'std_srvs::srv::dds_::SetBool_Request_'
    """
    package, kind, short = name.split("/")
    return f"{package}::{kind}::dds_::{short}_"


def topic_name(name: str) -> str:
    """Return the DDS topic of a ROS topic.

    >>> topic_name("/uav/image")
    'rt/uav/image'
    """
    return f"rt{name}"


def topic_names_of_service(name: str) -> tuple[str, str]:
    """Return the DDS topics of requests and responses.

    >>> topic_names_of_service("/uav/set")
    ('rq/uav/setRequest', 'rr/uav/setReply')
    """
    return f"rq{name}Request", f"rr{name}Reply"


class RosName(NamedTuple):
    """What a DDS endpoint is in ROS: what it does, on which topic or service, with which type."""

    kind: EndpointKind
    name: str
    type_name: str


def ros_name(topic: str, mangled: str, *, writes: bool) -> RosName | None:
    """Return what an endpoint is in ROS, or None if it is nothing, or a service's second endpoint.

    Args:
        topic: its DDS topic.
        mangled: the DDS name of its type.
        writes: whether it is a writer.

    >>> ros_name("rq/uav/setRequest", "std_srvs::srv::dds_::SetBool_Request_", writes=False)
    RosName(kind=<EndpointKind.SERVICE: 'service'>, name='/uav/set', type_name='std_srvs/srv/SetBool')
    """
    match = _TYPE_NAME.fullmatch(mangled)
    ros_type = f"{match[1]}/{match[2]}/{match[3]}" if match else mangled
    if topic.startswith("rt/"):
        kind = EndpointKind.PUBLISHER if writes else EndpointKind.SUBSCRIPTION
        return RosName(kind, topic[2:], ros_type + (match[4] or "" if match else ""))
    if topic.startswith("rq/") and topic.endswith("Request"):
        kind = EndpointKind.CLIENT if writes else EndpointKind.SERVICE
        return RosName(kind, topic[2 : -len("Request")], ros_type)
    return None


def dds_type(kind: type[Message]) -> Any:
    """Return the wheel's type for a message, against which DDS checks all samples."""
    return _struct(type_name(kind))


def service_types(kind: type[Service]) -> tuple[Any, Any]:
    """Return the wheel's types for the requests and responses of a service, each with its header."""
    request, response = type_name(kind.Request), type_name(kind.Response)
    return _struct(request, with_header=True), _struct(response, with_header=True)


@cache
def _struct(name: str, *, with_header: bool = False) -> Any:
    fields = {field: _field(each) for field, each in field_types(get_message(name)).items()} or _DUMMY
    if with_header:
        fields = _HEADER | fields
    mangled = dds_type_name(name)
    return make_idl_struct(
        mangled.rpartition("::")[2], mangled.replace("::", "."), fields, dataclassify=False
    )


def _field(field: FieldType) -> Any:
    if field.is_message:
        element = _struct(field.base)
    else:
        element = types.bounded_str[field.string_bound] if field.string_bound else _PRIMITIVES[field.base]
    if not field.is_array:
        return element
    if field.size is not None:
        return types.array[element, field.size]
    return types.sequence[element] if field.limit is None else types.sequence[element, field.limit]
