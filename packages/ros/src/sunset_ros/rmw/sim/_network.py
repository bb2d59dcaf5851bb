"""The state that simulated processes share: events and the clock, endpoints, observers, modelled durations."""

from collections.abc import Callable, Mapping
from enum import IntEnum
from heapq import heappop, heappush
from itertools import count
from math import isfinite
from typing import TypeVar

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import type_name
from sunset_ros.rmw.core.node import Endpoint, NodeHandle
from sunset_ros.rmw.core.port import EndpointInfo, EndpointKind
from sunset_ros.rmw.core.tap import Tap
from sunset_ros.seeding import check_seed, generator

OTHER_CALLBACK_NS = 200_000
"""Nanoseconds of all callbacks but subscriptions of listed nodes."""


class NumberedEndpoint(Endpoint):
    """A part that is visible on the graph; its gid is a whole number, from the network."""

    gid: int


EndpointT = TypeVar("EndpointT", bound=NumberedEndpoint)


class Priority(IntEnum):
    """Which of several events at the same time comes first."""

    PLAYBACK = -1  # a recorded request is served at its recorded time
    COMPLETION = 0  # a callback that ends sends its messages, and frees its process
    DELIVERY = 1
    TIMER = 2
    CALL = 3  # the experiment acts after all other events


class Scheduler:
    """Events in a total order (time, priority, order of addition), and the time of the current event.

    Attributes:
        now: nanoseconds, starting at 0.
    """

    def __init__(self) -> None:
        self._events: list[tuple[int, int, int, Callable[..., object], object]] = []
        self._numbers = count()
        self.now = 0

    def add(self, time_ns: int, priority: int, action: Callable[..., object], argument: object) -> None:
        """Let `action(argument)` happen at `time_ns`, which is not in the past."""
        heappush(self._events, (time_ns, priority, next(self._numbers), action, argument))

    def run_until(self, time_ns: int) -> None:
        """Let all events until `time_ns` happen, and set the clock to it."""
        self.run_while(lambda: True, time_ns)

    def run_while(self, predicate: Callable[[], bool], limit_ns: int | None) -> bool:
        """Let events happen while a predicate holds; it is evaluated before each event.

        Returns:
            Whether the predicate stopped holding. If not, the clock has reached the limit, or no events are left.
        """
        events = self._events
        while predicate():
            if not events or (limit_ns is not None and events[0][0] > limit_ns):
                if limit_ns is not None:
                    self.now = max(self.now, limit_ns)
                return not predicate()
            self.now, _, _, action, argument = heappop(events)
            action(argument)
        return True


class ComputeModel:
    """Draws the duration of callbacks.

    Args:
        seconds: full name of a node → mean duration of a subscription callback.
        jitter: half-width of the uniform factor, in [0, 1): a callback takes seconds * (1 ± jitter).
        seed: a whole number in [0, 2**32 - 1].

    Raises:
        MiddlewareError: a duration is negative or not finite, or the jitter is out of range.
    """

    def __init__(self, seconds: Mapping[str, float], jitter: float, seed: int) -> None:
        for node, duration in seconds.items():
            if not (isfinite(duration) and duration >= 0):
                raise MiddlewareError(
                    f"The modelled duration of node {node!r} must be at least 0 s, got {duration}."
                )
        if not 0 <= jitter < 1:
            raise MiddlewareError(f"The jitter of modelled durations must be in [0, 1), got {jitter}.")
        self._seconds = dict(seconds)
        self._jitter = jitter
        self._seed = check_seed(seed)
        self._samplers: dict[str, Callable[[], int]] = {}

    def sampler(self, node: str) -> Callable[[], int] | None:
        """Return a function that draws durations in ns for a node; None if the node is not listed.

        A redeployed node continues the stream of random numbers.
        """
        if node not in self._seconds:
            return None
        if node not in self._samplers:
            random = generator(self._seed, "compute", node.rpartition("/")[2]).random
            low = self._seconds[node] * 1e9 * (1 - self._jitter)
            width = self._seconds[node] * 1e9 * 2 * self._jitter
            self._samplers[node] = lambda: round(low + width * random())
        return self._samplers[node]


class Network:
    """The state of the simulated world.

    Attributes:
        latency_ns: time between departure and arrival of a sample.
        executing: the process whose callback runs now.
        nodes: all nodes, by age.
    """

    def __init__(self, compute: ComputeModel, latency_ns: int) -> None:
        self.scheduler = Scheduler()
        self.latency_ns = latency_ns
        self.compute = compute
        self.taps: list[Tap] = []
        self.executing: object = None
        self.nodes: dict[NodeHandle, None] = {}
        self._endpoints: dict[str, list[NumberedEndpoint]] = {}
        self._gids = count(1)

    def add(self, endpoint: NumberedEndpoint) -> None:
        """Put an endpoint on the graph."""
        endpoint.gid = next(self._gids)
        self._endpoints.setdefault(endpoint.name, []).append(endpoint)

    def remove(self, endpoint: NumberedEndpoint) -> None:
        """Take an endpoint off the graph."""
        endpoints = self._endpoints[endpoint.name]
        endpoints.remove(endpoint)
        if not endpoints:
            del self._endpoints[endpoint.name]

    def named(self, name: str, kind: type[EndpointT]) -> list[EndpointT]:
        """Return the endpoints of one class on one topic or service, by age."""
        return [endpoint for endpoint in self._endpoints.get(name, ()) if isinstance(endpoint, kind)]

    def endpoints(self, name: str | None = None) -> list[EndpointInfo]:
        """Describe all endpoints, or the endpoints of a topic or service.

        Publishers, subscriptions, clients, services; each by name, then by age.
        """
        names = sorted(self._endpoints) if name is None else [name]
        return [
            EndpointInfo(
                kind=kind,
                name=endpoint.name,
                type_name=type_name(endpoint.ros_type),
                node_name=endpoint.node.name,
                node_namespace=endpoint.node.namespace,
                qos=endpoint.qos,
                gid=endpoint.gid.to_bytes(16, "big"),
            )
            for kind in EndpointKind
            for each in names
            for endpoint in self._endpoints.get(each, ())
            if endpoint.kind is kind
        ]
