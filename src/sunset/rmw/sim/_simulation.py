"""The simulated world: its clock, its processes, and what an experiment may do to them.

Events happen one at a time in a total order (time, priority, sequence number), so that the same program
and seed give the same result in any process, on any computer, however slow. A callback runs at its start
time, which is what its clock reads; what it sends leaves when it ends, a modelled duration later, and arrives after
a modelled latency. Meanwhile its process does nothing else.
"""

from collections.abc import Callable, Iterable, Mapping
from math import isfinite
from types import MappingProxyType

from sunset.common.errors import MiddlewareError
from sunset.interfaces import Message, Service
from sunset.rmw.core.port import EndpointInfo, EndpointKind, qualified_name
from sunset.rmw.core.qos import QoSProfile
from sunset.rmw.core.tap import Tap
from sunset.rmw.sim._compute import ComputeModel
from sunset.rmw.sim._network import Network
from sunset.rmw.sim._process import SimProcess
from sunset.rmw.sim._scheduler import Priority
from sunset.rmw.sim._services import SimClient


class Simulation:
    """A simulated world: one network and one virtual clock, which starts at 0.

    Args:
        seed: a whole number in [0, 2**32 - 1]; decides the jitter of durations.
        compute: full name of a node → seconds that each of its subscription callbacks takes. Everything
            else takes 0.2 ms.
        jitter: those durations vary uniformly by this fraction, in [0, 1).
        latency_s: seconds from a message leaving one process to its arrival in another.

    Raises:
        InvalidInputError: the seed is out of range.
        MiddlewareError: a duration or the latency is negative, or the jitter out of range.
    """

    def __init__(
        self,
        *,
        seed: int = 0,
        compute: Mapping[str, float] = MappingProxyType({}),
        jitter: float = 0.1,
        latency_s: float = 0.0005,
    ) -> None:
        if not (isfinite(latency_s) and latency_s >= 0):
            raise MiddlewareError(f"The latency must be at least 0 s, got {latency_s}.")
        self._network = Network(ComputeModel(compute, jitter, seed), round(latency_s * 1e9))

    @property
    def now(self) -> int:
        """Virtual time in nanoseconds."""
        return self._network.scheduler.now

    def create_process(
        self,
        name: str,
        *,
        around: Callable[[Callable[[], None]], None] | None = None,
        is_protected: bool = False,
    ) -> SimProcess:
        """Start a process, to be given to `Context.init(middleware=…)`.

        Args:
            name: names it in errors; two processes may have the same.
            around: calls each callback of this process, in the place of the simulation; None to just call it.
            is_protected: whether it is the experiment's. Its callbacks take no time. Its requests wait for no other
                request, take nobody's place in a queue, and take no time, so that nobody can delay them, or notice
                by how others are answered that there were such requests.
        """
        return SimProcess(self._network, name, around, is_protected=is_protected)

    def run_until(self, t_ns: int) -> None:
        """Let everything happen that is due at or before `t_ns`; the clock then reads `t_ns`.

        Raises:
            CallbackError: a callback raised. The world is left consistent and may go on.
            MiddlewareError: called from inside a callback.
        """
        self._check_outside()
        self._network.scheduler.run_until(t_ns)

    def run_while(self, predicate: Callable[[], bool], limit_ns: int) -> bool:
        """Let events happen, one at a time, for as long as a predicate holds.

        Args:
            predicate: looked at before each event.
            limit_ns: virtual time after which nothing happens.

        Returns:
            Whether the predicate stopped holding; if not, the clock reads `limit_ns`.

        Raises:
            CallbackError: a callback raised. The world is left consistent and may go on.
            MiddlewareError: called from inside a callback.
        """
        self._check_outside()
        return self._network.scheduler.run_while(predicate, limit_ns)

    def call_at(self, t_ns: int, function: Callable[[], object]) -> None:
        """Call a function of the experiment, outside all processes, when everything else due at `t_ns` has happened.

        Raises:
            MiddlewareError: `t_ns` has passed.
        """
        if t_ns < self.now:
            raise MiddlewareError(f"Nothing can be called at {t_ns} ns: it is {self.now} ns already.")
        self._network.scheduler.add(t_ns, Priority.CALL, lambda _: function(), None)

    def play_back(self, requests: Iterable[tuple[int, str, type[Service], Message]]) -> None:
        """Serve recorded requests at the times at which they were served, before all others that wait.

        Args:
            requests: the time in nanoseconds, and the service with its type and the request.
        """
        process = self.create_process("playback")
        node = process.create_node("playback", "/")
        for t_ns, name, kind, request in requests:
            client = SimClient(process, node, kind, name, QoSProfile(), handler=lambda *_: None, label="")
            self._network.scheduler.add(t_ns, Priority.PLAYBACK, client.play_back, request)

    def add_tap(self, tap: Tap) -> None:
        """Let an observer see every message, request and response from now on."""
        self._network.taps.append(tap)

    def kill(self, process: SimProcess) -> None:
        """End a process at once, even in the middle of a callback, whose messages are then never sent."""
        process.end()

    def on_exit(self, process: SimProcess, handler: Callable[[SimProcess], object]) -> None:
        """Call `handler(process)` when the process has ended, by shutdown or kill."""
        process.exit_handlers.append(handler)

    def node_names(self) -> list[str]:
        """Return the fully qualified names of all nodes, sorted."""
        return sorted(node.fully_qualified_name for node in self._network.nodes)

    def endpoints(self) -> list[EndpointInfo]:
        """Return every endpoint on the graph, in a fixed order."""
        return self._network.endpoints()

    def publishers_of(self, node: str) -> list[tuple[str, str]]:
        """Return (topic, type) of the publishers of a node, given by its fully qualified name."""
        return self._of(node, EndpointKind.PUBLISHER)

    def subscriptions_of(self, node: str) -> list[tuple[str, str]]:
        """Return (topic, type) of the subscriptions of a node, given by its fully qualified name."""
        return self._of(node, EndpointKind.SUBSCRIPTION)

    def services_of(self, node: str) -> list[tuple[str, str]]:
        """Return (name, type) of the services that a node offers, given by its fully qualified name."""
        return self._of(node, EndpointKind.SERVICE)

    def _of(self, node: str, kind: EndpointKind) -> list[tuple[str, str]]:
        return [
            (info.name, info.type_name)
            for info in self._network.endpoints()
            if info.kind is kind and qualified_name(info.node_namespace, info.node_name) == node
        ]

    def _check_outside(self) -> None:
        if self._network.executing is not None:
            raise MiddlewareError("A callback cannot run the simulation that it is part of.")
