"""What all simulated processes share: the clock, the wires, the observers, the models of time."""

from collections.abc import Sequence
from itertools import count
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from sunset.rmw.core.port import EndpointInfo, EndpointKind, QoSProfile
from sunset.rmw.core.tap import Tap
from sunset.rmw.sim._compute import ComputeModel
from sunset.rmw.sim._scheduler import Scheduler

if TYPE_CHECKING:
    from sunset.rmw.sim._process import SimNode, SimProcess
    from sunset.rmw.sim._services import SimClient, SimService
    from sunset.rmw.sim._topics import SimPublisher, SimSubscription

__all__ = ["Network"]


class _Endpoint(Protocol):
    """What all four kinds of endpoint have."""

    @property
    def name(self) -> str: ...
    @property
    def type_name(self) -> str: ...
    @property
    def qos(self) -> QoSProfile: ...
    @property
    def gid(self) -> int: ...
    @property
    def node(self) -> "SimNode": ...


EndpointT = TypeVar("EndpointT", bound=_Endpoint)


class _Table(Generic[EndpointT]):
    """The endpoints of one kind, by name, then by age."""

    __slots__ = ("_by_name",)

    def __init__(self) -> None:
        self._by_name: dict[str, list[EndpointT]] = {}

    def add(self, endpoint: EndpointT) -> None:
        """Put an endpoint on the graph."""
        self._by_name.setdefault(endpoint.name, []).append(endpoint)

    def remove(self, endpoint: EndpointT) -> None:
        """Take an endpoint off the graph."""
        endpoints = self._by_name[endpoint.name]
        endpoints.remove(endpoint)
        if not endpoints:
            del self._by_name[endpoint.name]

    def named(self, name: str) -> Sequence[EndpointT]:
        """Return the endpoints of one topic or service."""
        return self._by_name.get(name, ())

    def describe(self, kind: EndpointKind, name: str | None) -> list[EndpointInfo]:
        """Return what the graph tells about each, or about those of one name."""
        names = sorted(self._by_name) if name is None else [name]
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
            for each in names
            for endpoint in self._by_name.get(each, ())
        ]


class Network:
    """The state of the simulated world.

    Attributes:
        scheduler: events and the clock.
        latency_ns: from a sample leaving one process to its arrival in another.
        compute: how long callbacks take.
        taps: the observers.
        executing: the process whose callback runs at the moment.
        nodes: those alive, as the keys, by age.
    """

    __slots__ = (
        "_gids",
        "clients",
        "compute",
        "executing",
        "latency_ns",
        "nodes",
        "publishers",
        "scheduler",
        "services",
        "subscriptions",
        "taps",
    )

    def __init__(self, compute: ComputeModel, latency_ns: int) -> None:
        self.scheduler = Scheduler()
        self.latency_ns = latency_ns
        self.compute = compute
        self.taps: list[Tap] = []
        self.executing: SimProcess | None = None
        self.nodes: dict[SimNode, None] = {}
        self.publishers: _Table[SimPublisher] = _Table()
        self.subscriptions: _Table[SimSubscription] = _Table()
        self.clients: _Table[SimClient] = _Table()
        self.services: _Table[SimService] = _Table()
        self._gids = count(1)

    def new_gid(self) -> int:
        """Return a number that no other endpoint has or had."""
        return next(self._gids)

    def endpoints(self, name: str | None = None) -> list[EndpointInfo]:
        """Describe every endpoint, or those of one topic or service.

        Publishers, subscriptions, clients, services; each by name, then by age.
        """
        return [
            *self.publishers.describe(EndpointKind.PUBLISHER, name),
            *self.subscriptions.describe(EndpointKind.SUBSCRIPTION, name),
            *self.clients.describe(EndpointKind.CLIENT, name),
            *self.services.describe(EndpointKind.SERVICE, name),
        ]
