"""The interface of a process on DDS to its endpoints, and their base classes."""

import time
from abc import abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from itertools import count
from typing import Final

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.core.live import LiveProcess
from sunset_ros.rmw.core.node import Entity, NodeHandle
from sunset_ros.rmw.core.port import CallbackError
from sunset_ros.rmw.dds._config import Configuration
from sunset_ros.rmw.dds._graph import Graph, NodeEntities
from sunset_ros.rmw.dds._link import FIRST_NUMBER, Link
from sunset_ros.rmw.dds._queue import WaitingLine

_REPORT_EVERY_NS: Final = 10 * 10**9


class DdsEntity(Entity["DdsHost"]):
    """A part of a node that has callbacks."""

    @abstractmethod
    def take_turn(self) -> bool:
        """Do a piece of work; return whether a callback ran."""


class DdsEndpoint(Entity["DdsHost"]):
    """A part that is visible on the graph, with the GUIDs of its DDS readers and writers."""

    readers: tuple[bytes, ...]
    writers: tuple[bytes, ...]

    def join(self) -> None:
        super().join()
        self.process.endpoints_here[self] = None
        self.process.announce()

    def retire(self) -> None:
        super().retire()
        self.process.endpoints_here.pop(self, None)

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


class DdsHost(LiveProcess):
    """A process on DDS, as its parts need it.

    Attributes:
        link: its participant.
        problems: topic, service or node → number of samples that could not be used.
        alarms: part → time of its next turn, by the steady clock.
        endpoints_here: the endpoints of its nodes, by age.
    """

    def __init__(self, configuration: Configuration) -> None:
        self.domain_id = configuration.domain_id
        self.problems: Counter[str] = Counter()
        self.alarms: dict[DdsEntity, int] = {}
        self.endpoints_here: dict[DdsEndpoint, None] = {}
        self._nodes: dict[NodeHandle, None] = {}
        self._numbers = count(FIRST_NUMBER)
        self._readers: dict[int, DdsEntity] = {}
        self._queue: WaitingLine[DdsEntity | None] = WaitingLine()
        self._ids = count(1)
        self._reported: dict[str, tuple[int, int]] = {}
        self._failure: Exception | None = None
        self._alive = True
        self._ending = False
        self._spinning = False
        self._calling = False
        self._undisturbed = 0
        self._graph = Graph()
        self.link = Link(configuration, self._on_data, self.report, self._on_failure, self._graph)

    # Called on the thread that waits for samples

    def _on_data(self, number: int) -> None:
        entity = self._readers.get(number)
        if entity is not None:
            self._queue.put(entity)

    def _on_failure(self, error: Exception) -> None:
        self._failure = error
        self._queue.put(None)

    # For its nodes and their parts

    def check_alive(self) -> None:
        if not self._alive:
            raise MiddlewareError("The process has left the network.")

    def queue(self, entity: DdsEntity) -> None:
        """Line up an entity for a turn."""
        self._queue.put(entity)

    def number(self, entity: DdsEntity) -> int:
        """Return a new number for the data of an entity."""
        number = next(self._numbers)
        self._readers[number] = entity
        return number

    def forget_number(self, number: int) -> None:
        """Drop a number."""
        self._readers.pop(number, None)

    def remove(self, node: NodeHandle) -> None:
        if node in self._nodes:
            del self._nodes[node]
            self.announce()

    def announce(self) -> None:
        """Announce the nodes and endpoints of this process."""
        self._graph.forget_join()
        self.link.announce(self._describe_nodes())

    def _describe_nodes(self) -> Iterator[NodeEntities]:
        for node in self._nodes:
            ends = [end for end in self.endpoints_here if end.node is node]
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
            handler(*arguments)
        except CallbackError:
            raise
        except Exception as error:
            raise CallbackError.of(entity.node.fully_qualified_name, entity.label, error) from error
        finally:
            self._calling = False

    def report(self, where: str, problem: str, node: NodeHandle | None = None) -> None:
        """Count unusable data of a topic or service, and warn a node, the first of the process if None.

        The problem is the end of a sentence. Each place has at most one warning in 10 s.
        """
        self.problems[where] += 1
        node = node or next(iter(tuple(self._nodes)), None)
        warn = None if node is None else node.warn
        now = self.steady_ns()
        reported_ns, reported = self._reported.get(where, (now - _REPORT_EVERY_NS, 0))
        if node is None or warn is None or now - reported_ns < _REPORT_EVERY_NS:
            return
        self._reported[where] = (now, self.problems[where])
        unreported = self.problems[where] - reported - 1
        more = f" There were {unreported} more since the last such message." if unreported else ""
        with suppress(MiddlewareError):  # another thread may have ended the node meanwhile
            node.post(partial(warn, f"{where}: {problem}{more}"), "warning")

    def now_ns(self) -> int:
        return time.time_ns()

    def steady_ns(self) -> int:
        return time.monotonic_ns()

    @abstractmethod
    def _leave(self) -> None:
        """Leave the network at once."""
