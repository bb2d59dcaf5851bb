"""A participant of a DDS domain: it enters, discovers the graph, announces its nodes and leaves."""

import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from queue import Empty
from typing import Final, Generic, TypeVar

from sunset_ros.errors import InterfaceError, MiddlewareError
from sunset_ros.interfaces import Message, type_hash, type_name
from sunset_ros.interfaces.rmw_dds_common.msg import ParticipantEntitiesInfo
from sunset_ros.rmw.core.qos import DurabilityPolicy, HistoryPolicy, QoSProfile
from sunset_ros.rmw.dds import _library as dds
from sunset_ros.rmw.dds import _wheel as wheel
from sunset_ros.rmw.dds._config import Configuration
from sunset_ros.rmw.dds._graph import (
    Graph,
    NodeEntities,
    Participant,
    dds_type_name,
    decode_participant,
    encode_participant,
)

T = TypeVar("T")

_DISCOVERY_TOPIC: Final = "ros_discovery_info"
_DISCOVERY_QOS: Final = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_DISCOVERY_READER_QOS: Final = QoSProfile(
    history=HistoryPolicy.KEEP_ALL, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
_PARTING_NS: Final = 300_000_000
"""How long a process that leaves waits for confirmations."""


_domains: Final[dict[int, tuple[int, str, int]]] = {}
"""The domains of this process by id: (DDS entity, settings, number of links)."""

_changing_domains: Final = threading.Lock()


@contextmanager
def _domain(number: int, settings: str) -> Iterator[None]:
    """Set up a domain unless it exists, and delete it after its last link.

    Raises:
        MiddlewareError: it exists with other settings.
    """
    with _changing_domains:
        entity, present, users = _domains.get(number) or (dds.create_domain(number, settings), settings, 0)
        if present != settings:
            raise MiddlewareError(f"This process is in domain {number} already, with other settings.")
        _domains[number] = (entity, present, users + 1)
    try:
        yield
    finally:
        with _changing_domains:
            entity, present, users = _domains.pop(number)
            if users > 1:
                _domains[number] = (entity, present, users - 1)
            else:
                dds.delete(entity)


class WaitingLine(Generic[T]):
    """An unbounded queue that threads and signal handlers fill, and a single thread empties.

    `queue.SimpleQueue` of CPython 3.11 can block for ever: it takes a timeout that passes just before it begins to wait
    for no timeout.
    """

    def __init__(self) -> None:
        self._items: deque[T] = deque()
        self._news = threading.Lock()  # locked unless an item has come since the last `get`

    def put(self, item: T) -> None:
        """Add an item at the end."""
        self._items.append(item)
        if self._news.locked():
            with suppress(RuntimeError):  # another thread unlocks it first
                self._news.release()

    def get(self, timeout_s: float | None = None) -> T:
        """Take the first item after a wait of at most so many seconds, None for ever; raise `Empty` without one."""
        end_s = None if timeout_s is None else time.monotonic() + timeout_s
        while not self._items:
            if not self._news.acquire(timeout=-1 if end_s is None else max(0.0, end_s - time.monotonic())):
                raise Empty
        return self._items.popleft()

    def __bool__(self) -> bool:
        """Return whether there are items."""
        return bool(self._items)


class Link:
    """A participant, and the thread that waits for its samples.

    It calls `on_data` on the thread with the number of a reader that has samples, or has news of
    the graph; `on_problem`, on any thread, with the place and the description of unusable data; and
    `on_failure` on the thread with the error that ends it. `graph` receives news of the graph.

    Attributes:
        guid: 16 bytes that identify the participant.
        gid_size: bytes of a gid in its announcements.

    Raises:
        MiddlewareError: the domain cannot be entered.
    """

    def __init__(
        self,
        configuration: Configuration,
        on_data: Callable[[int], None],
        on_problem: Callable[[str, str], None],
        on_failure: Callable[[Exception], None],
        graph: Graph,
    ) -> None:
        self._on_data = on_data
        self._on_problem = on_problem
        self._on_failure = on_failure
        self.gid_size = configuration.gid_size
        self._configuration = configuration
        self._nodes: tuple[NodeEntities, ...] = ()
        self._announcing = threading.RLock()
        self._looking = threading.Lock()
        self._graph = graph
        with ExitStack() as stack:
            stack.enter_context(_domain(configuration.domain_id, configuration.cyclonedds))
            self._enter(configuration.domain_id)
            self._in_domain = stack.pop_all()
        self._thread = threading.Thread(target=self._listen, name="dds", daemon=True)
        self._thread.start()

    def _enter(self, domain_id: int) -> None:
        self.participant = dds.create_participant(domain_id, b"enclave=/;")
        self.guid = dds.guid_of(self.participant)
        self._writer = self.create_writer(_DISCOVERY_TOPIC, ParticipantEntitiesInfo, _DISCOVERY_QOS)
        nodes = self.create_reader(
            _DISCOVERY_TOPIC, ParticipantEntitiesInfo, _DISCOVERY_READER_QOS, ignore_own=True
        )
        builtin = [dds.create_reader(self.participant, topic, None) for topic in dds.BUILTIN_TOPICS]
        self._readers = [nodes, *builtin]
        self.waitset = dds.WaitSet(self.participant)
        self._numbers = {self.waitset.add(reader) for reader in self._readers}
        for number in self._numbers:
            self.waitset.watch(number)

    def create_writer(self, topic: str, kind: type[Message], qos: QoSProfile, user_data: str = "") -> int:
        """Make a writer of a DDS topic; `user_data` is announced with the hash of the type."""
        with self._topic(topic, kind) as dds_topic:
            return dds.create_writer(self.participant, dds_topic, qos, self._user_data(user_data, kind))

    def create_reader(
        self,
        topic: str,
        kind: type[Message],
        qos: QoSProfile,
        user_data: str = "",
        *,
        ignore_own: bool = False,
    ) -> int:
        """Make a reader of a DDS topic, likewise; `ignore_own` skips samples of this participant."""
        data = self._user_data(user_data, kind)
        with self._topic(topic, kind) as dds_topic:
            return dds.create_reader(self.participant, dds_topic, qos, data, ignore_own=ignore_own)

    def _topic(self, topic: str, kind: type[Message]) -> AbstractContextManager[int]:
        return wheel.topic_of(self.participant, topic, dds_type_name(type_name(kind)))

    def _user_data(self, more: str, kind: type[Message]) -> bytes:
        return (
            more + (f"typehash={type_hash(kind)};" if self._configuration.announces_hashes else "")
        ).encode()

    def _listen(self) -> None:
        try:
            while numbers := self.waitset.wait():
                for number in numbers:
                    if number in self._numbers:
                        self.look()
                        self.waitset.watch(number)
                    self._on_data(number)
        except Exception as error:  # noqa: BLE001  reported to the user's thread
            self._on_failure(error)

    # The graph

    def look(self) -> None:
        """Read news of the graph."""
        nodes, participating, writers, readers = self._readers
        with self._looking:
            samples = []
            while (sample := wheel.take(nodes)) is not None:
                samples.append(sample[0])
            participants = wheel.take_participants(participating)
            # participants that have left by now were there when they sent the samples above
            self._graph.learn_participants([(guid, True) for guid, _ in participants])
            for payload in samples:
                self._learn_nodes(payload)
            self._graph.learn_participants([(guid, False) for guid, alive in participants if not alive])
            self._graph.learn_endpoints(wheel.take_endpoints(writers), writers=True)
            self._graph.learn_endpoints(wheel.take_endpoints(readers), writers=False)

    def _learn_nodes(self, payload: bytes) -> None:
        try:
            participant = decode_participant(payload)
        except InterfaceError as error:
            self._on_problem(_DISCOVERY_TOPIC, f"dropped a malformed announcement: {error}")
            return
        is_there = self._graph.learn_nodes(participant)  # its last announcement may come after it has left
        if is_there and self._configuration.adapts and participant.gid_size < self.gid_size:
            with self._announcing:
                self.gid_size = participant.gid_size
                self.announce(self._nodes)

    def announce(self, nodes: Iterable[NodeEntities]) -> None:
        """Announce the nodes of this process with their endpoints."""
        with self._announcing:
            self._nodes = tuple(nodes)
            payload = encode_participant(Participant(self.guid, self._nodes, self.gid_size))
            wheel.write(self._writer, payload, _DISCOVERY_TOPIC)

    # The end

    def leave(self, writers: Sequence[int]) -> None:
        """Wait for confirmations of these writers' samples, announce the end of all nodes, and leave the domain."""
        self.waitset.close()
        # not for ever: a signal handler may have interrupted this thread while it held a lock of that thread
        self._thread.join(timeout=1.0)
        end_ns = time.monotonic_ns() + _PARTING_NS
        for writer in writers:
            dds.wait_for_acks(writer, max(0, end_ns - time.monotonic_ns()))
        self.announce(())
        dds.wait_for_acks(self._writer, max(0, end_ns - time.monotonic_ns()))
        with wheel.MAKING_TOPIC:
            dds.delete(self.participant)
        self._in_domain.close()
