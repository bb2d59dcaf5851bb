"""Names on the wire: how ROS 2 calls a topic, a service and a type in DDS."""

import re
from collections.abc import Mapping
from typing import Final, NamedTuple

from sunset.rmw.core.port import EndpointKind

OBSERVER: Final = "observer"
"""A key in the user data of readers that only look on: they are not part of the graph."""

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
    """Return what a writer or reader is in ROS, by its DDS topic and the DDS name of its type.

    None if it is nothing, or a service's second endpoint.

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


def parse_user_data(data: bytes) -> Mapping[str, str]:
    """Return what an endpoint's owner says of it; what is malformed is passed over.

    >>> parse_user_data(b"serviceid= 1.10;typehash=RIHS01_0;")
    {'serviceid': ' 1.10', 'typehash': 'RIHS01_0'}
    """
    pairs = (pair.partition("=") for pair in data.decode("ascii", "replace").split(";"))
    return {key: value for key, _, value in pairs if key}
