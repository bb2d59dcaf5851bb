"""Names of topics, services and types of ROS 2 in DDS."""

import re
from collections.abc import Mapping
from typing import Final, NamedTuple

from sunset_ros.rmw.core.port import EndpointKind

OBSERVER: Final = "observer"
"""A key in the user data of an observer's readers, which are not part of the graph."""

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
    """A DDS endpoint in terms of ROS: its kind, the topic or service, and the type."""

    kind: EndpointKind
    name: str
    type_name: str


def ros_name(topic: str, mangled: str, *, writes: bool) -> RosName | None:
    """Return a writer or reader in terms of ROS, from its DDS topic and the DDS name of its type.

    None for the second endpoint of a client or server, and for endpoints without a counterpart in ROS.

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
    """Return the pairs in an endpoint's user data; malformed parts are skipped.

    >>> parse_user_data(b"serviceid= 1.10;typehash=RIHS01_0;")
    {'serviceid': ' 1.10', 'typehash': 'RIHS01_0'}
    """
    pairs = (pair.partition("=") for pair in data.decode("ascii", "replace").split(";"))
    return {key: value for key, _, value in pairs if key}
