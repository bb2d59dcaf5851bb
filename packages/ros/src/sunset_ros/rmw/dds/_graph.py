"""The graph: names of ROS 2 in DDS, and the nodes that participants announce, joined with discovered endpoints."""

import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from io import BytesIO
from struct import Struct
from struct import error as StructError  # noqa: N812  it is a class
from typing import Final, NamedTuple

from sunset_ros.errors import InterfaceError
from sunset_ros.rmw.core.port import EndpointInfo, EndpointKind, qualified_name
from sunset_ros.rmw.dds._wheel import Endpoint

OBSERVER: Final = "observer"
"""A key in the user data of an observer's readers, which are not part of the graph."""

_TYPE_NAME: Final = re.compile(r"(\w+)::(msg|srv)::dds_::(\w+?)(_Request|_Response)?_")
_ENCAPSULATION = b"\x00\x01\x00\x00"
_GIDS = {16: Struct("16s"), 24: Struct("16s8x")}
_COUNT = Struct("<I")
_KINDS = list(EndpointKind)
_UNKNOWN = ("_NODE_NAME_UNKNOWN_", "_NODE_NAMESPACE_UNKNOWN_")


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


class NodeEntities(NamedTuple):
    """A node as its participant announces it, with the GUIDs of its readers and writers."""

    namespace: str
    name: str
    readers: tuple[bytes, ...]
    writers: tuple[bytes, ...]


class Participant(NamedTuple):
    """A sample on `ros_discovery_info`.

    Attributes:
        guid: 16 bytes that identify the participant.
        nodes: all its nodes; empty if it leaves.
        gid_size: bytes of a gid in the sample: 24 up to Humble, 16 since.
    """

    guid: bytes
    nodes: tuple[NodeEntities, ...]
    gid_size: int = 16


def encode_participant(participant: Participant) -> bytes:
    """Return the payload of a sample on `ros_discovery_info`."""
    gid = _GIDS[participant.gid_size]
    out = bytearray(_ENCAPSULATION + gid.pack(participant.guid) + _COUNT.pack(len(participant.nodes)))
    for node in participant.nodes:
        for text in (node.namespace, node.name):
            data = text.encode() + b"\0"
            out += _COUNT.pack(len(data)) + data + bytes(-len(data) % 4)
        for guids in (node.readers, node.writers):
            out += _COUNT.pack(len(guids)) + b"".join(map(gid.pack, guids))
    return bytes(out)


def decode_participant(payload: bytes) -> Participant:
    """Decode the payload of a sample on `ros_discovery_info`, with gids of either size."""
    for gid_size in _GIDS:
        with suppress(StructError, ValueError):
            return _decoded(payload, gid_size)
    raise InterfaceError(f"A payload of {len(payload)} bytes is not an announcement of nodes.")


def _decoded(payload: bytes, gid_size: int) -> Participant:
    """Decode a payload, in which everything is aligned to 4 bytes."""
    rest, gid = BytesIO(payload), _GIDS[gid_size]

    def count() -> int:
        return int(_COUNT.unpack(rest.read(4))[0])

    def text() -> str:
        size = count()
        data = rest.read(size + -size % 4)
        return data[: data.index(b"\0", 0, size)].decode()

    def guids(number: int) -> tuple[bytes, ...]:
        return tuple(gid.unpack(rest.read(gid.size))[0] for _ in range(number))

    if rest.read(4)[:2] != _ENCAPSULATION[:2]:
        raise ValueError
    (guid,) = guids(1)
    nodes = tuple(NodeEntities(text(), text(), guids(count()), guids(count())) for _ in range(count()))
    if rest.read():
        raise ValueError
    return Participant(guid, nodes, gid_size)


class Graph:
    """The nodes of other participants and all endpoints; a single thread at a time changes it."""

    def __init__(self) -> None:
        self._participants: dict[bytes, tuple[NodeEntities, ...]] = {}
        self._endpoints: dict[bytes, tuple[RosName, Endpoint]] = {}

    def learn_participants(self, participants: Sequence[tuple[bytes, bool]]) -> None:
        """Note which participants have joined (True) or left."""
        for guid, alive in participants:
            if alive:
                self._participants.setdefault(guid, ())
            else:
                self._participants.pop(guid, None)

    def learn_nodes(self, participant: Participant) -> bool:
        """Note the nodes of a participant; return whether the participant is known."""
        if participant.guid not in self._participants:
            return False
        self._participants[participant.guid] = participant.nodes
        return True

    def learn_endpoints(self, endpoints: Sequence[Endpoint], *, writers: bool) -> None:
        """Note new and lost writers, or readers."""
        for endpoint in endpoints:
            ros = ros_name(endpoint.topic, endpoint.type_name, writes=writers) if endpoint.alive else None
            if ros is None or OBSERVER in parse_user_data(endpoint.user_data):
                self._endpoints.pop(endpoint.guid, None)
            else:
                self._endpoints[endpoint.guid] = (ros, endpoint)

    def _all_nodes(self, own: Iterable[NodeEntities]) -> list[NodeEntities]:
        return [*own, *(node for nodes in list(self._participants.values()) for node in nodes)]

    def nodes(self, own: Iterable[NodeEntities]) -> list[tuple[str, str]]:
        """Return (name, namespace) of all nodes, including the own, sorted by full name."""
        nodes = [(node.name, node.namespace) for node in self._all_nodes(own)]
        return sorted(nodes, key=lambda node: qualified_name(node[1], node[0]))

    def endpoints(self, own: Iterable[NodeEntities], name: str | None) -> list[EndpointInfo]:
        """Return all endpoints, sorted by kind, name and GUID; only of a topic or service if named."""
        node_of = {
            guid: (node.name, node.namespace)
            for node in self._all_nodes(own)
            for guid in (*node.readers, *node.writers)
        }
        infos = [
            EndpointInfo(*ros, *node_of.get(endpoint.guid, _UNKNOWN), endpoint.qos, endpoint.guid)
            for ros, endpoint in list(self._endpoints.values())
            if name in {None, ros.name}
        ]
        return sorted(infos, key=lambda info: (_KINDS.index(info.kind), info.name, info.gid))
