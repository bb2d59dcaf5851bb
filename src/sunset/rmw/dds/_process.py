"""The live middleware: one operating system process on DDS, which ROS 2 nodes take for one of theirs.

It speaks as `rmw_cyclonedds` does: the same names, types, quality of service and announcements. Samples wait in DDS,
in the reader they came to, which drops the oldest beyond its depth; a slow callback costs no memory. A thread that
does nothing else waits for readers to have samples and lines them up; `spin_once` handles one sample of the first in
line on the thread that calls it. Nothing is sent beyond this computer unless the network is asked for.
"""

import atexit
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from queue import Empty
from typing import Final

from sunset.common.errors import MiddlewareError
from sunset.interfaces import Message, type_hash, type_name
from sunset.rmw.core.node import NodeHandle, Parts
from sunset.rmw.core.port import EndpointInfo
from sunset.rmw.dds import _wheel as wheel
from sunset.rmw.dds._config import read_configuration
from sunset.rmw.dds._entity import DdsPosted, DdsTimer
from sunset.rmw.dds._host import DdsEndpoint, DdsEntity, DdsHost
from sunset.rmw.dds._names import dds_type_name
from sunset.rmw.dds._services import DdsClient, DdsService
from sunset.rmw.dds._topics import DdsPublisher, DdsSubscription

_STEP_S: Final = 0.005
_PARTING_NS: Final = 1_500_000_000
"""How long a process that leaves waits for clients that it has not answered yet to listen."""
_LONG_NS: Final = 3600 * 10**9


def prepare() -> None:
    """Make what every process needs for the messages that are imported, so that forks of this one have it already.

    It joins no network, and starts no thread.
    """
    for kind in Message.__subclasses__():
        wheel.prepare(dds_type_name(type_name(kind)))
        type_hash(kind)


class CycloneDDS(DdsHost):
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
        configuration = read_configuration(environment, domain_id=domain_id, network=network, distro=distro)
        super().__init__(configuration)
        self._parts = Parts(
            publisher=partial(DdsPublisher, self),
            subscription=partial(DdsSubscription, self),
            client=partial(DdsClient, self),
            service=partial(DdsService, self),
            timer=partial(DdsTimer, self),
        )
        atexit.register(self._leave)

    def __repr__(self) -> str:
        return f"<CycloneDDS domain {self.domain_id} {'alive' if self.alive else 'ended'}>"

    # The port

    @property
    def describes_types(self) -> bool:
        """Whether its nodes tell others what their types are made of: not where other nodes are of Humble."""
        return self.link.announces_hashes

    def create_node(self, name: str, namespace: str) -> NodeHandle:
        node = NodeHandle(self, self._parts, name, namespace)
        self._nodes[node] = None
        self.announce()
        return node

    def post(self, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        """Call a handler of a node once, after those that are ready already; any thread may ask for it."""
        self.queue(DdsPosted(self, node, handler, label))

    def spin_once(self, timeout_ns: int | None) -> bool:
        """Wait for a callback of an attached node and run it; a process that has ended runs none.

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
                if entity is None:  # `wake` was called
                    break
                if self._run(entity):
                    return True
            if end_ns is not None and self.steady_ns() >= end_ns:
                break
        return False

    def _next(self, end_ns: int | None) -> DdsEntity | None:
        """Return the entity that is first in line; wait until there is one, an alarm goes off, or time is over."""
        alarm_ns = self._line_up_timers()
        if self._queue:
            return self._queue.get()
        limits = [limit for limit in (alarm_ns, end_ns) if limit is not None]
        wait_ns = min(min(limits) - self.steady_ns(), _LONG_NS) if limits else _LONG_NS
        return self._queue.get(wait_ns / 1e9)

    def _line_up_timers(self) -> int | None:
        """Line up the timers whose alarm has gone off, the earliest first; return when the next one does."""
        if not self.alarms:
            return None
        now = self.steady_ns()
        for entity, alarm_ns in sorted(self.alarms.items(), key=lambda alarm: alarm[1]):
            if alarm_ns > now:
                return alarm_ns
            del self.alarms[entity]
            self._queue.put(entity)
        return None

    def _run(self, entity: DdsEntity) -> bool:
        if not entity.alive:
            return False
        if not entity.node.attached:
            entity.node.hold(partial(self.queue, entity))
            return False
        return entity.take_turn()

    def wait_for(self, predicate: Callable[[], bool], timeout_ns: int | None) -> bool:
        end_ns = None if timeout_ns is None else self.steady_ns() + timeout_ns
        pause = threading.Event()
        while not predicate():
            if self._calling or not self.alive or (end_ns is not None and self.steady_ns() >= end_ns):
                return False
            pause.wait(_STEP_S)
        return True

    def wake(self) -> None:
        self._queue.put(None)

    @property
    def alive(self) -> bool:
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
        endpoints = list(self.endpoints_here)
        self._settle(endpoints)
        writers = [writer for endpoint in endpoints for writer in endpoint.reliable_writers()]
        for node in self._nodes:
            for entity in node.entities:
                entity.alive = False
            node.alive = False
            node.entities = {}
        # not cleared: what a signal handler interrupted may be looking at them
        self._nodes, self.alarms, self._readers, self.endpoints_here = {}, {}, {}, {}
        self.link.leave(writers)
        atexit.unregister(self._leave)
        self.wake()

    def _settle(self, endpoints: Sequence[DdsEndpoint]) -> None:
        """Wait until clients listen that are still to be answered, though not for long."""
        end_ns = self.steady_ns() + _PARTING_NS
        pause = threading.Event()
        while (endpoints := [end for end in endpoints if not end.settle()]) and self.steady_ns() < end_ns:
            pause.wait(_STEP_S)

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
