"""The state that simulated processes share: clock, endpoints, observers, models of time."""

from itertools import count
from typing import ClassVar, Protocol, TypeVar

from sunset_ros.rmw.core.node import NodeHandle
from sunset_ros.rmw.core.port import EndpointInfo, EndpointKind
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.core.tap import Tap
from sunset_ros.rmw.sim._compute import ComputeModel
from sunset_ros.rmw.sim._scheduler import Scheduler


class _Endpoint(Protocol):
    kind: ClassVar[EndpointKind]
    name: str
    type_name: str
    qos: QoSProfile
    gid: int

    @property
    def node(self) -> NodeHandle: ...


EndpointT = TypeVar("EndpointT", bound=_Endpoint)


class Network:
    """The state of the simulated world.

    Attributes:
        scheduler: events and the clock.
        latency_ns: time between departure and arrival of a sample.
        compute: durations of callbacks.
        taps: the observers.
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
        self._endpoints: dict[str, list[_Endpoint]] = {}
        self._gids = count(1)

    def new_gid(self) -> int:
        """Return a new number."""
        return next(self._gids)

    def add(self, endpoint: _Endpoint) -> None:
        """Put an endpoint on the graph."""
        self._endpoints.setdefault(endpoint.name, []).append(endpoint)

    def remove(self, endpoint: _Endpoint) -> None:
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
                type_name=endpoint.type_name,
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
