"""Operating system processes on DDS, compatible with ROS 2 nodes on `rmw_cyclonedds`.

Names, types, quality of service and announcements are the same. Samples wait in their DDS reader, which drops the
oldest beyond its depth, so a slow callback costs no memory. A thread waits for samples and lines up their readers;
`spin_once` handles a sample of the first reader in line. No data leaves this computer unless the caller asks for the
network.
"""

import atexit
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from queue import Empty
from typing import Final

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message, type_hash, type_name
from sunset_ros.rmw.core.node import NodeHandle, Parts
from sunset_ros.rmw.core.port import EndpointInfo
from sunset_ros.rmw.dds import _wheel as wheel
from sunset_ros.rmw.dds._config import read_configuration
from sunset_ros.rmw.dds._entity import DdsPosted, DdsTimer
from sunset_ros.rmw.dds._host import DdsEndpoint, DdsEntity, DdsHost
from sunset_ros.rmw.dds._names import dds_type_name
from sunset_ros.rmw.dds._services import DdsClient, DdsService
from sunset_ros.rmw.dds._topics import DdsPublisher, DdsSubscription

_STEP_S: Final = 0.005
_PARTING_NS: Final = 1_500_000_000
"""How long a process that leaves waits until clients can receive their responses."""
_LONG_NS: Final = 3600 * 10**9


def prepare() -> None:
    """Do the work for all imported messages that forks of this process share; join no network, start no thread."""
    for kind in Message.__subclasses__():
        wheel.prepare(dds_type_name(type_name(kind)))
        type_hash(kind)


class CycloneDDS(DdsHost):
    """A process on DDS, to be given to `Context.init(middleware=…)`.

    Args:
        domain_id: the domain, 0 to 232; ROS_DOMAIN_ID, else 0, if None.
        network: whether to communicate beyond this computer.
        distro: the ROS 2 distribution of other nodes, such as "jazzy" or "humble", which decides the form of
            announcements; None to begin with the form of ROS_DISTRO, and adapt to other nodes.
        environment: has ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_DISTRO and
        CYCLONEDDS_URI;
            `os.environ` if None.

    Attributes:
        domain_id: the domain.
        problems: topic, service or node → number of samples that could not be used.

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

    def create_node(self, name: str, namespace: str) -> NodeHandle:
        node = NodeHandle(self, self._parts, name, namespace)
        self._nodes[node] = None
        self.announce()
        return node

    def post(self, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        """Call a handler of a node once, after all ready callbacks; any thread may call this."""
        self.queue(DdsPosted(self, node, handler, label))

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
        """Return the first entity in line, after a wait; raise `Empty` at the next alarm or the end."""
        alarm_ns = self._line_up_timers()
        if self._queue:
            return self._queue.get()
        limits = [limit for limit in (alarm_ns, end_ns) if limit is not None]
        wait_ns = min(min(limits) - self.steady_ns(), _LONG_NS) if limits else _LONG_NS
        return self._queue.get(wait_ns / 1e9)

    def _line_up_timers(self) -> int | None:
        """Line up timers with due alarms, the earliest first; return the time of the next alarm."""
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
        endpoints = list(self.endpoints_here)
        self._settle(endpoints)
        writers = [writer for endpoint in endpoints for writer in endpoint.reliable_writers()]
        for node in self._nodes:
            for entity in node.entities:
                entity.alive = False
            node.alive = False
            node.entities = {}
        # replaced, not cleared: the code that a signal handler has interrupted may iterate over them
        self._nodes, self.alarms, self._readers, self.endpoints_here = {}, {}, {}, {}
        self.link.leave(writers)
        atexit.unregister(self._leave)
        self.wake()

    def _settle(self, endpoints: Sequence[DdsEndpoint]) -> None:
        """Wait shortly until clients can receive their responses."""
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
