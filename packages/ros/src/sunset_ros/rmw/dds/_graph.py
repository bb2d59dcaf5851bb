"""The graph: the nodes that participants announce, joined with the endpoints that DDS discovers."""

import threading
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from struct import Struct
from struct import error as StructError  # noqa: N812  it is a class

from sunset_ros.errors import InterfaceError
from sunset_ros.rmw.core.port import EndpointInfo, EndpointKind, qualified_name
from sunset_ros.rmw.dds._names import OBSERVER, parse_user_data, ros_name
from sunset_ros.rmw.dds._wheel import Endpoint

_ENCAPSULATION = b"\x00\x01\x00\x00"
_GUID_SIZE = 16
_GID_SIZES = (16, 24)
_COUNT = Struct("<I")
_KINDS = list(EndpointKind)
_UNKNOWN = ("_NODE_NAME_UNKNOWN_", "_NODE_NAMESPACE_UNKNOWN_")


@dataclass(frozen=True, slots=True)
class NodeEntities:
    """A node as its participant announces it, with the GUIDs of its readers and writers."""

    namespace: str
    name: str
    readers: tuple[bytes, ...]
    writers: tuple[bytes, ...]


@dataclass(frozen=True, slots=True)
class Participant:
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
    out = bytearray(_ENCAPSULATION)
    padding = bytes(participant.gid_size - _GUID_SIZE)
    out += participant.guid + padding
    out += _COUNT.pack(len(participant.nodes))
    for node in participant.nodes:
        for text in (node.namespace, node.name):
            data = text.encode() + b"\0"
            out += _COUNT.pack(len(data)) + data + bytes(-len(data) % 4)
        for gids in (node.readers, node.writers):
            out += _COUNT.pack(len(gids))
            for gid in gids:
                out += gid + padding
    return bytes(out)


def decode_participant(payload: bytes) -> Participant:
    """Decode the payload of a sample on `ros_discovery_info`, with gids of either size."""
    for gid_size in _GID_SIZES:
        reader = _Reader(payload, gid_size)
        try:
            participant = Participant(reader.gid(), tuple(reader.nodes()), gid_size)
        except (StructError, ValueError, IndexError):
            continue
        if reader.is_at_end():
            return participant
    raise InterfaceError(f"A payload of {len(payload)} bytes is not an announcement of nodes.")


class _Reader:
    """Reads a sample on `ros_discovery_info` from front to back; everything in it is aligned to 4 bytes."""

    def __init__(self, payload: bytes, gid_size: int) -> None:
        if payload[:2] != _ENCAPSULATION[:2]:
            raise InterfaceError("It is not little-endian CDR.")
        self._payload = payload
        self._gid_size = gid_size
        self._position = len(_ENCAPSULATION)

    def is_at_end(self) -> bool:
        return self._position == len(self._payload)

    def gid(self) -> bytes:
        gid = self._bytes(self._gid_size)
        if any(gid[_GUID_SIZE:]):
            raise ValueError
        return gid[:_GUID_SIZE]

    def nodes(self) -> Iterable[NodeEntities]:
        for _ in range(self._count()):
            yield NodeEntities(self._text(), self._text(), self._gids(), self._gids())

    def _gids(self) -> tuple[bytes, ...]:
        return tuple(self.gid() for _ in range(self._count()))

    def _text(self) -> str:
        size = self._count()
        data = self._bytes(size)
        self._position += -size % 4
        if not data.endswith(b"\0"):
            raise ValueError
        return data[:-1].decode()

    def _count(self) -> int:
        (count,) = _COUNT.unpack_from(self._payload, self._position)
        self._position += _COUNT.size
        return int(count)

    def _bytes(self, size: int) -> bytes:
        end = self._position + size
        if end > len(self._payload):
            raise IndexError
        data = self._payload[self._position : end]
        self._position = end
        return data


class GraphListener(ABC):
    """Receives news of participants, nodes and endpoints."""

    @abstractmethod
    def learn_participants(self, participants: Sequence[tuple[bytes, bool]]) -> None:
        """Note which participants have joined (True) or left."""

    @abstractmethod
    def learn_nodes(self, participant: Participant) -> bool:
        """Note the nodes of a participant; return whether the participant is known."""

    @abstractmethod
    def learn_endpoints(self, endpoints: Sequence[Endpoint], *, writers: bool) -> None:
        """Note new and lost writers, or readers."""


class Graph(GraphListener):
    """The nodes of other participants and all endpoints; several threads may use it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._participants: dict[bytes, tuple[NodeEntities, ...]] = {}
        self._endpoints: dict[bytes, tuple[Endpoint, bool]] = {}
        self._infos: dict[str, list[EndpointInfo]] | None = None

    def learn_participants(self, participants: Sequence[tuple[bytes, bool]]) -> None:
        with self._lock:
            for guid, alive in participants:
                if alive:
                    self._participants.setdefault(guid, ())
                else:
                    self._participants.pop(guid, None)
                self._infos = None

    def learn_nodes(self, participant: Participant) -> bool:
        with self._lock:
            if participant.guid not in self._participants:
                return False
            self._participants[participant.guid] = participant.nodes
            self._infos = None
            return True

    def learn_endpoints(self, endpoints: Sequence[Endpoint], *, writers: bool) -> None:
        with self._lock:
            for endpoint in endpoints:
                if endpoint.alive:
                    self._endpoints[endpoint.guid] = (endpoint, writers)
                else:
                    self._endpoints.pop(endpoint.guid, None)
                self._infos = None

    def nodes(self, own: Iterable[NodeEntities]) -> list[tuple[str, str]]:
        """Return (name, namespace) of all nodes, including the own, sorted by full name."""
        with self._lock:
            others = [node for nodes in self._participants.values() for node in nodes]
        nodes = [(node.name, node.namespace) for node in (*own, *others)]
        return sorted(nodes, key=lambda node: qualified_name(node[1], node[0]))

    def endpoints(self, own: Iterable[NodeEntities], name: str | None) -> list[EndpointInfo]:
        """Return all endpoints, sorted by kind, name and GUID; only of a topic or service if named."""
        with self._lock:
            joined = self._infos = self._infos or self._join(own)
            if name is not None:
                return list(joined.get(name, ()))
            infos = [info for each in joined.values() for info in each]
        return sorted(infos, key=lambda info: (_KINDS.index(info.kind), info.name, info.gid))

    def forget_join(self) -> None:
        """Note a change of the own nodes."""
        with self._lock:
            self._infos = None

    def _join(self, own: Iterable[NodeEntities]) -> dict[str, list[EndpointInfo]]:
        others = (node for nodes in self._participants.values() for node in nodes)
        node_of = {
            gid: (node.name, node.namespace)
            for node in (*own, *others)
            for gid in (*node.readers, *node.writers)
        }
        infos: dict[str, list[EndpointInfo]] = {}
        for guid, (endpoint, writes) in self._endpoints.items():
            ros = ros_name(endpoint.topic, endpoint.type_name, writes=writes)
            if ros is not None and OBSERVER not in parse_user_data(endpoint.user_data):
                node, namespace = node_of.get(guid, _UNKNOWN)
                info = EndpointInfo(*ros, node, namespace, endpoint.qos, endpoint.guid)
                infos.setdefault(ros.name, []).append(info)
        for each in infos.values():
            each.sort(key=lambda info: (_KINDS.index(info.kind), info.gid))
        return infos
