"""The live middleware: one operating system process on DDS, which ROS 2 nodes take for one of theirs.

It speaks as `rmw_cyclonedds` does: the same names, types, quality of service and announcements. Samples wait in DDS,
in the reader they came to, which drops the oldest beyond its depth; a slow callback costs no memory. A thread that
does nothing else waits for readers to have samples and lines them up; `spin_once` handles one sample of the first in
line on the thread that calls it. Nothing is sent beyond this computer unless the network is asked for.
"""

import atexit
import os
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from itertools import count
from queue import Empty
from typing import Any, Final

from sunset.errors import MiddlewareError
from sunset.interfaces import Message, type_hash, type_name
from sunset.rmw.core.live import LiveProcess
from sunset.rmw.core.port import CallbackError, EndpointInfo
from sunset.rmw.dds import _wheel as wheel
from sunset.rmw.dds._config import read_configuration
from sunset.rmw.dds._entity import DdsTimer, Entity, ReadingEntity
from sunset.rmw.dds._graph import Graph
from sunset.rmw.dds._link import FIRST_NUMBER, Link
from sunset.rmw.dds._names import dds_type_name
from sunset.rmw.dds._node import DdsNode
from sunset.rmw.dds._queue import WaitingLine
from sunset.rmw.dds._tap import CycloneTap

__all__ = ["CycloneDDS", "CycloneTap", "prepare"]

_STEP_S: Final = 0.005
_PARTING_NS: Final = 1_500_000_000
"""How long a process that leaves waits for clients that it has not answered yet to listen."""
_LONG_NS: Final = 3600 * 10**9
_REPORT_EVERY_NS: Final = 10 * 10**9


def prepare() -> None:
    """Make what every process needs for the messages that are imported, so that forks of this one have it already.

    It joins no network, and starts no thread.
    """
    for kind in Message.__subclasses__():
        wheel.prepare(dds_type_name(type_name(kind)))
        type_hash(kind)


class CycloneDDS(LiveProcess):
    """A process on DDS, to be given to `Context.init(middleware=…)`.

    Args:
        domain_id: processes hear those of the same domain only, 0 to 232; ROS_DOMAIN_ID, else 0, if None.
        network: whether to be heard beyond this computer.
        distro: the ROS 2 distribution of other nodes, such as "jazzy" or "humble", on which the form of announcements
            depends; None to take ROS_DISTRO as a guess, and the newer form when others send that.
        environment: where ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_DISTRO and
            CYCLONEDDS_URI are looked up; `os.environ` if None.

    Attributes:
        domain_id: the domain.
        problems: what came and could not be used: topic, service or node → how often.

    Raises:
        MiddlewareError: a setting cannot be used, or the domain cannot be entered.
    """

    def __init__(
        self,
        *,
        domain_id: int | None = None,
        network: bool = False,
        distro: str | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        configuration = read_configuration(
            os.environ if environment is None else environment,
            domain_id=domain_id,
            network=network,
            distro=distro,
        )
        self.domain_id = configuration.domain_id
        self.problems: Counter[str] = Counter()
        self.timers: dict[DdsTimer, None] = {}
        self._nodes: dict[DdsNode, None] = {}
        self._numbers = count(FIRST_NUMBER)
        self._readers: dict[int, ReadingEntity] = {}
        self._queue: WaitingLine[Entity | None] = WaitingLine()
        self._ids = count(1)
        self._requests = count(1)
        self._reported: dict[str, tuple[int, int]] = {}
        self._failure: Exception | None = None
        self._alive = True
        self._ending = False
        self._spinning = False
        self._calling = False
        self._undisturbed = 0
        self._graph = Graph()
        self.link = Link(configuration, self._on_data, self.report, self._on_failure, self._graph)
        atexit.register(self._leave)

    def __repr__(self) -> str:
        return f"<CycloneDDS domain {self.domain_id} {'alive' if self.alive else 'ended'}>"

    # What the thread that waits for samples calls

    def _on_data(self, number: int) -> None:
        entity = self._readers.get(number)
        if entity is not None:
            self._queue.put(entity)

    def _on_failure(self, error: Exception) -> None:
        self._failure = error
        self._queue.put(None)

    # What its parts need of it

    def check_alive(self) -> None:
        """Refuse to do something in a process that has left the network.

        Raises:
            MiddlewareError: it has.
        """
        if not self._alive:
            raise MiddlewareError("The process has left the network.")

    def queue(self, entity: Entity) -> None:
        """Let an entity have its turn, after those that are ready already."""
        self._queue.put(entity)

    def number(self, entity: ReadingEntity) -> int:
        """Return a number for the data of an entity."""
        number = next(self._numbers)
        self._readers[number] = entity
        return number

    def forget_number(self, number: int) -> None:
        """Do not expect data of that number any more."""
        self._readers.pop(number, None)

    def has(self, node: DdsNode) -> bool:
        """Whether a node is alive."""
        return node in self._nodes

    def remove(self, node: DdsNode) -> None:
        """Take a node off the graph."""
        if node in self._nodes:
            del self._nodes[node]
            self.announce()

    def announce(self) -> None:
        """Tell others which nodes and endpoints there are."""
        self._graph.forget_join()
        self.link.announce(node.describe() for node in self._nodes)

    @contextmanager
    def undisturbed(self) -> Iterator[None]:
        """Put off a shutdown that a signal handler asks for while DDS is in the middle of something."""
        self._undisturbed += 1
        try:
            yield
        finally:
            self._undisturbed -= 1
            if self._ending and not (self._spinning or self._undisturbed):
                self._leave()

    @contextmanager
    def topic(self, name: str, kind: type[Message]) -> Iterator[int]:
        """Make a topic of DDS for the endpoints that are made within."""
        mangled = dds_type_name(type_name(kind))
        with self.undisturbed(), wheel.topic_of(self.link.participant, name, mangled) as topic:
            yield topic

    def new_endpoint_id(self) -> str:
        """Return a text that both ends of a service's client or server carry, and no others."""
        first, *others = self.link.guid[:12] + next(self._ids).to_bytes(4, "big")
        return ".".join([f"{first:2x}", *(f"{byte:x}" for byte in others)])

    def new_request_number(self) -> int:
        """Return the running number of a request."""
        return next(self._requests)

    def call(self, entity: Entity, handler: Callable[..., None], *arguments: Any) -> None:
        """Call a handler.

        Raises:
            CallbackError: it raised.
        """
        self._calling = True
        try:
            handler(*arguments)
        except CallbackError:
            raise
        except Exception as error:
            raise CallbackError.of(entity.node.fully_qualified_name, entity.label, error) from error
        finally:
            self._calling = False

    def report(self, where: str, problem: str, node: DdsNode | None = None) -> None:
        """Count something that could not be used, and tell a node of it, for each place at most every 10 s.

        Args:
            where: the topic or service.
            problem: what is wrong, the end of a sentence.
            node: whose; the first of the process if None.
        """
        self.problems[where] += 1
        node = node or next(iter(tuple(self._nodes)), None)
        warn = None if node is None else node.warn
        now = self.steady_ns()
        told_ns, told = self._reported.get(where, (now - _REPORT_EVERY_NS, 0))
        if node is None or warn is None or now - told_ns < _REPORT_EVERY_NS:
            return
        self._reported[where] = (now, self.problems[where])
        untold = self.problems[where] - told - 1
        more = f" There were {untold} more since the last such message." if untold else ""
        with suppress(MiddlewareError):  # another thread may have ended the node meanwhile
            node.post(partial(warn, f"{where}: {problem}{more}"), "warning")

    # The port

    @property
    def describes_types(self) -> bool:
        """Whether its nodes tell others what their types are made of: not where other nodes are of Humble."""
        return self.link.announces_hashes

    def now_ns(self) -> int:
        """The system clock, in nanoseconds since 1970."""
        return time.time_ns()

    def steady_ns(self) -> int:
        """A clock that never jumps, in nanoseconds since some fixed moment."""
        return time.monotonic_ns()

    def create_node(self, name: str, namespace: str) -> DdsNode:
        """Enter the graph with a node that has no endpoints yet."""
        node = DdsNode(self, name, namespace)
        self._nodes[node] = None
        self.announce()
        return node

    def spin_once(self, timeout_ns: int | None) -> bool:
        """Wait for a callback of an attached node and run it; one that has ended runs none.

        Raises:
            CallbackError: it raised.
            MiddlewareError: called from inside a callback, or the connection to DDS broke.
        """
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
            if self._failure is not None:
                raise MiddlewareError(f"The connection to DDS broke: {self._failure}") from self._failure
            try:
                entity = self._next(end_ns)
            except Empty:
                pass
            else:
                if entity is None:  # somebody calls `wake`
                    break
                if self._run(entity):
                    return True
            if end_ns is not None and self.steady_ns() >= end_ns:
                break
        return False

    def _next(self, end_ns: int | None) -> Entity | None:
        """Return who is first in line, waiting until somebody is, an alarm goes off, or time is over."""
        limits = [limit for limit in (self._line_up_timers(), end_ns) if limit is not None]
        wait_ns = min(min(limits) - self.steady_ns(), _LONG_NS) if limits else _LONG_NS
        return self._queue.get(wait_ns / 1e9)

    def _line_up_timers(self) -> int | None:
        """Line up the timers whose alarm has gone off, the earliest first; return when the next one does."""
        if not self.timers:
            return None
        now = self.steady_ns()
        alarms = sorted(
            ((timer.alarm_ns, timer) for timer in self.timers if timer.alarm_ns is not None),
            key=lambda alarm: alarm[0],
        )
        for alarm_ns, timer in alarms:
            if alarm_ns > now:
                return alarm_ns
            timer.alarm_ns = None
            self._queue.put(timer)
        return None

    def _run(self, entity: Entity) -> bool:
        if not entity.alive:
            return False
        if not entity.node.attached:
            entity.node.hold(entity)
            return False
        return entity.take_turn()

    def wait_for(self, predicate: Callable[[], bool], timeout_ns: int | None) -> bool:
        """Wait until a predicate on the graph holds; from inside a callback, only look."""
        end_ns = None if timeout_ns is None else self.steady_ns() + timeout_ns
        pause = threading.Event()
        while not predicate():
            if self._calling or not self.alive or (end_ns is not None and self.steady_ns() >= end_ns):
                return False
            pause.wait(_STEP_S)
        return True

    def wake(self) -> None:
        """Make a waiting `spin_once` return."""
        self._queue.put(None)

    @property
    def alive(self) -> bool:
        """Whether the process may still use the network."""
        return self._alive and not self._ending

    def shutdown(self) -> None:
        """Leave the network: at once, or when `spin_once` returns if it runs, after the callback and what it sends.

        It may be called from signal handlers and other threads.
        """
        if self._spinning or self._undisturbed:
            self._ending = True
            self.wake()
        else:
            self._leave()

    def _leave(self) -> None:
        if not self._alive:
            return
        self._alive = False
        entities = [entity for node in self._nodes for entity in node.entities]
        self._settle(entities)
        writers = [writer for entity in entities for writer in entity.reliable_writers()]
        for entity in entities:
            entity.alive = False
        for node in self._nodes:
            node.entities = {}
        # not cleared: what a signal handler interrupted may be looking at them
        self._nodes, self.timers, self._readers = {}, {}, {}
        self.link.leave(writers)
        atexit.unregister(self._leave)
        self.wake()

    def _settle(self, entities: Sequence[Entity]) -> None:
        """Wait until clients listen that are still to be answered, though not for long."""
        end_ns = self.steady_ns() + _PARTING_NS
        pause = threading.Event()
        while (entities := [one for one in entities if not one.settle()]) and self.steady_ns() < end_ns:
            pause.wait(_STEP_S)

    def nodes(self) -> list[tuple[str, str]]:
        """(name, namespace) of every node on the graph, sorted by full name."""
        self._look()
        return self._graph.nodes(node.describe() for node in self._nodes)

    def endpoints(self, name: str | None = None) -> list[EndpointInfo]:
        """Every endpoint on the graph, or those of one topic or service, in a fixed order."""
        self._look()
        return self._graph.endpoints((node.describe() for node in self._nodes), name)

    def _look(self) -> None:
        self.check_alive()
        with self.undisturbed():
            self.link.look()
