"""Operating system processes on DDS, compatible with ROS 2 nodes on `rmw_cyclonedds`.

Names, types, quality of service and announcements are the same. Samples wait in their DDS reader, which drops the
oldest beyond its depth, so a slow callback costs no memory. A thread waits for samples and lines up their readers;
`spin_once` handles a sample of the first reader in line. No data leaves this computer unless the caller asks for the
network.
"""

import atexit
import threading
import time
from abc import abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from itertools import count
from queue import Empty
from typing import Final

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.core.live import LiveProcess
from sunset_ros.rmw.core.node import Endpoint, Entity, NodeHandle
from sunset_ros.rmw.core.port import EndpointInfo
from sunset_ros.rmw.dds._config import Configuration
from sunset_ros.rmw.dds._graph import Graph, NodeEntities
from sunset_ros.rmw.dds._link import Link, WaitingLine

_STEP_S: Final = 0.005
_PARTING_NS: Final = 1_500_000_000
"""How long a process that leaves waits until clients can receive their responses."""
_LONG_NS: Final = 3600 * 10**9
_REPORT_EVERY_NS: Final = 10 * 10**9


class DdsEntity(Entity):
    """A part of a node that has callbacks."""

    process: "DdsProcess"

    @abstractmethod
    def take_turn(self) -> bool:
        """Do a piece of work; return whether a callback ran."""


class _DdsPosted(DdsEntity):
    """A posted call, from any thread."""

    def __init__(self, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        super().__init__(node, label)
        self._handler = handler

    def take_turn(self) -> bool:
        if not self.node.alive:
            return False
        self.process.call(self, self._handler)
        return True


class DdsEndpoint(Endpoint):
    """A part that is visible on the graph, with the GUIDs of its DDS readers and writers."""

    process: "DdsProcess"
    readers: tuple[bytes, ...] = ()
    writers: tuple[bytes, ...] = ()

    def join(self) -> None:
        super().join()
        self.process.announce()

    def destroy(self) -> None:
        if self.alive:
            self.retire()
            self.process.announce()

    def reliable_writers(self) -> tuple[int, ...]:
        """Return the DDS writers whose samples must arrive before the process leaves."""
        return ()

    def settle(self) -> bool:
        """Send samples that wait for their receiver, if it has come; return whether none is left."""
        return True


def _endpoints_of(node: NodeHandle) -> list[DdsEndpoint]:
    return [entity for entity in list(node.entities) if isinstance(entity, DdsEndpoint)]


class DdsProcess(LiveProcess):
    """A process on DDS, without the classes of its parts.

    Attributes:
        link: its participant.
        problems: topic, service or node → number of samples that could not be used.
        alarms: part → time of its next turn, by the steady clock.
        queue: the parts in line for a turn, None to end a wait, and the error that ended the connection.
        readers: number of a DDS reader → the part that takes its samples.
    """

    _end_text = "The process has left the network."

    def __init__(self, configuration: Configuration) -> None:
        self.domain_id = configuration.domain_id
        self.problems: Counter[str] = Counter()
        self.alarms: dict[DdsEntity, int] = {}
        self.readers: dict[int, DdsEntity] = {}
        self._nodes: dict[NodeHandle, None] = {}
        self.queue: WaitingLine[DdsEntity | Exception | None] = WaitingLine()
        self._ids = count(1)
        self._reported_ns: dict[str, int] = {}
        self._spinning = False
        self._calling = False
        self._undisturbed = 0
        self._graph = Graph()
        self.link = Link(configuration, self._on_data, self.report, self.queue.put, self._graph)
        atexit.register(self._leave)

    def _on_data(self, number: int) -> None:  # called on the thread that waits for samples
        entity = self.readers.get(number)
        if entity is not None:
            self.queue.put(entity)

    # For its nodes and their parts

    def remove(self, node: NodeHandle) -> None:
        if node in self._nodes:
            del self._nodes[node]
            self.announce()

    def announce(self) -> None:
        """Announce the nodes and endpoints of this process."""
        self.link.announce(self._describe_nodes())

    def _describe_nodes(self) -> Iterator[NodeEntities]:
        for node in self._nodes:
            ends = _endpoints_of(node)
            yield NodeEntities(
                node.namespace,
                node.name,
                tuple(guid for end in ends for guid in end.readers),
                tuple(guid for end in ends for guid in end.writers),
            )

    @contextmanager
    def undisturbed(self) -> Iterator[None]:
        """Delay a shutdown by a signal handler until the context ends."""
        self._undisturbed += 1
        try:
            yield
        finally:
            self._undisturbed -= 1
            if self._ending and not (self._spinning or self._undisturbed):
                self._leave()

    def new_endpoint_id(self) -> str:
        """Return a new id for both ends of a client or server."""
        first, *others = self.link.guid[:12] + next(self._ids).to_bytes(4, "big")
        return ".".join([f"{first:2x}", *(f"{byte:x}" for byte in others)])

    def call(self, entity: DdsEntity, handler: Callable[..., None], *arguments: object) -> None:
        """Call a handler, whose exceptions become a `CallbackError`."""
        self._calling = True
        try:
            entity.call(handler, *arguments)
        finally:
            self._calling = False

    def report(self, where: str, problem: str, node: NodeHandle | None = None) -> None:
        """Count unusable data of a topic or service, and warn a node, the first of the process if None.

        The problem is the end of a sentence. Each place has at most one warning in 10 s.
        """
        self.problems[where] += 1
        node = node or next(iter(tuple(self._nodes)), None)
        now = self.steady_ns()
        is_new = now - self._reported_ns.get(where, now - _REPORT_EVERY_NS) >= _REPORT_EVERY_NS
        if node is not None and node.warn is not None and is_new:
            self._reported_ns[where] = now
            with suppress(MiddlewareError):  # another thread may have ended the node meanwhile
                node.post(partial(node.warn, f"{where}: {problem}"), "warning")

    # The port

    def now_ns(self) -> int:
        return time.time_ns()

    def steady_ns(self) -> int:
        return time.monotonic_ns()

    def create_node(self, name: str, namespace: str) -> NodeHandle:
        node = NodeHandle(self, name, namespace)
        self._nodes[node] = None
        self.announce()
        return node

    def post(self, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        """Call a handler of a node once, after all ready callbacks; any thread may call this."""
        self.queue.put(_DdsPosted(node, handler, label))

    def spin_once(self, timeout_ns: int | None) -> bool:
        if self._calling:
            raise MiddlewareError(
                "Spinning inside a callback would wait for itself; use a Future's done callback."
            )
        end_ns = None if timeout_ns is None else self.steady_ns() + timeout_ns
        self._spinning = True
        try:
            return self._spin_until(end_ns)
        finally:
            self._spinning = False
            if self._ending:
                self._leave()

    def _spin_until(self, end_ns: int | None) -> bool:
        while self.alive:
            with suppress(Empty):
                entity = self._next(end_ns)
                if isinstance(entity, Exception):
                    self.queue.put(entity)
                    raise MiddlewareError(f"The connection to DDS broke: {entity}") from entity
                if entity is None:  # `wake` was called
                    break
                if self._run(entity):
                    return True
            if end_ns is not None and self.steady_ns() >= end_ns:
                break
        return False

    def _next(self, end_ns: int | None) -> DdsEntity | Exception | None:
        """Return the first entity in line, after a wait; raise `Empty` at the next alarm or the end."""
        alarm_ns = self._line_up_timers()
        if self.queue:
            return self.queue.get()
        limits = [limit for limit in (alarm_ns, end_ns) if limit is not None]
        wait_ns = min(min(limits) - self.steady_ns(), _LONG_NS) if limits else _LONG_NS
        return self.queue.get(wait_ns / 1e9)

    def _line_up_timers(self) -> int | None:
        """Line up timers with due alarms, the earliest first; return the time of the next alarm."""
        now = self.steady_ns()
        for entity, alarm_ns in sorted(self.alarms.items(), key=lambda alarm: alarm[1]):
            if alarm_ns > now:
                return alarm_ns
            del self.alarms[entity]
            self.queue.put(entity)
        return None

    def _run(self, entity: DdsEntity) -> bool:
        if not entity.alive:
            return False
        if not entity.node.attached:
            entity.node.hold(partial(self.queue.put, entity))
            return False
        return entity.take_turn()

    def wait_for(self, predicate: Callable[[], bool], timeout_ns: int | None) -> bool:
        return self._poll(predicate, timeout_ns, lambda: self._calling or not self.alive)

    def _poll(
        self, predicate: Callable[[], bool], timeout_ns: int | None, is_over: Callable[[], bool]
    ) -> bool:
        end_ns = None if timeout_ns is None else self.steady_ns() + timeout_ns
        pause = threading.Event()
        while not predicate():
            if is_over() or (end_ns is not None and self.steady_ns() >= end_ns):
                return False
            pause.wait(_STEP_S)
        return True

    def wake(self) -> None:
        self.queue.put(None)

    def shutdown(self) -> None:
        """Leave the network, at once or when a running `spin_once` returns; on any thread."""
        if self._spinning or self._undisturbed:
            self._ending = True
            self.wake()
        else:
            self._leave()

    def _leave(self) -> None:
        if not self._alive:
            return
        self._alive = False
        endpoints = [end for node in self._nodes for end in _endpoints_of(node)]
        self._poll(lambda: not sum(not end.settle() for end in endpoints), _PARTING_NS, lambda: False)
        writers = [writer for endpoint in endpoints for writer in endpoint.reliable_writers()]
        for node in self._nodes:
            for entity in node.entities:
                entity.alive = False
            node.alive = False
            node.entities = {}
        # replaced, not cleared: the code that a signal handler has interrupted may iterate over them
        self._nodes, self.alarms, self.readers = {}, {}, {}
        self.link.leave(writers)
        atexit.unregister(self._leave)
        self.wake()

    def nodes(self) -> list[tuple[str, str]]:
        self._look()
        return self._graph.nodes(self._describe_nodes())

    def endpoints(self, name: str | None = None) -> list[EndpointInfo]:
        self._look()
        return self._graph.endpoints(self._describe_nodes(), name)

    def _look(self) -> None:
        self.check_alive()
        with self.undisturbed():
            self.link.look()
