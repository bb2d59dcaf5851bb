"""Simulations of a network.

Events have a total order (time, priority, sequence number), so the same program and seed give the same result in any
process and on any computer. The clock shows the start time of a callback while it runs. Its messages leave when it
ends, a modelled duration later, and arrive after a modelled latency. Meanwhile its process runs no other callback.
"""

from collections.abc import Callable, Iterable, Mapping
from math import isfinite
from types import MappingProxyType

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message, Service
from sunset_ros.rmw.core.port import EndpointInfo
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.core.tap import Tap
from sunset_ros.rmw.sim._endpoints import PARTS, SimClient
from sunset_ros.rmw.sim._network import ComputeModel, Network, Priority
from sunset_ros.rmw.sim._process import SimProcess


class Simulation:
    """A simulated network with a virtual clock, which starts at 0.

    Args:
        seed: the seed of the jitter, a whole number in [0, 2**32 - 1].
        compute: full name of a node → seconds that its subscription callbacks take. All others take 0.2 ms.
        jitter: the fraction, in [0, 1), by which these durations vary uniformly.
        latency_s: seconds between departure and arrival of a message.

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
            name: its name in errors, which need not be unique.
            around: called with each callback of this process, to call it; None to just call it.
            is_protected: whether callbacks and requests of the process take no time and use no queue of others, so that
                other processes can neither delay nor notice them.
        """
        return SimProcess(self._network, PARTS, name, around, is_protected=is_protected)

    def run_until(self, t_ns: int) -> None:
        """Let all events until `t_ns` happen; the clock then shows `t_ns`.

        Raises:
            CallbackError: a callback raised. The simulation may go on.
            MiddlewareError: called in a callback.
        """
        self._check_outside()
        self._network.scheduler.run_until(t_ns)

    def run_while(self, predicate: Callable[[], bool], limit_ns: int) -> bool:
        """Let events happen while a predicate holds, which is evaluated before each event, and until `limit_ns`.

        Returns:
            Whether the predicate stopped holding; if not, the clock shows `limit_ns`.

        Raises:
            CallbackError: a callback raised. The simulation may go on.
            MiddlewareError: called in a callback.
        """
        self._check_outside()
        return self._network.scheduler.run_while(predicate, limit_ns)

    def call_at(self, t_ns: int, function: Callable[[], object]) -> None:
        """Call a function outside all processes after all other events at `t_ns`.

        Raises:
            MiddlewareError: `t_ns` has passed.
        """
        if t_ns < self.now:
            raise MiddlewareError(f"Nothing can be called at {t_ns} ns: it is {self.now} ns already.")
        self._network.scheduler.add(t_ns, Priority.CALL, lambda _: function(), None)

    def play_back(self, requests: Iterable[tuple[int, str, type[Service], Message]]) -> None:
        """Serve recorded requests, (time in ns, service, type, request), at these times before all waiting requests."""
        process = self.create_process("playback")
        node = process.create_node("playback", "/")
        for t_ns, name, kind, request in requests:
            client = SimClient(node, kind, name, QoSProfile())
            self._network.scheduler.add(t_ns, Priority.PLAYBACK, client.play_back, request)

    def add_tap(self, tap: Tap) -> None:
        """Let an observer see all messages, requests and responses from now on."""
        self._network.taps.append(tap)

    def kill(self, process: SimProcess) -> None:
        """End a process at once; messages of its running callback are not sent."""
        process.end()

    def on_exit(self, process: SimProcess, handler: Callable[[SimProcess], object]) -> None:
        """Call `handler(process)` after shutdown or kill of a process."""
        process.exit_handlers.append(handler)

    def node_names(self) -> list[str]:
        """Return the fully qualified names of all nodes, sorted."""
        return sorted(node.fully_qualified_name for node in self._network.nodes)

    def endpoints(self) -> list[EndpointInfo]:
        """Return every endpoint on the graph, in a fixed order."""
        return self._network.endpoints()

    def _check_outside(self) -> None:
        if self._network.executing is not None:
            raise MiddlewareError("A callback cannot run its own simulation.")
