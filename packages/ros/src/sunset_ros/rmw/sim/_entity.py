"""Parts of simulated nodes."""

from abc import abstractmethod
from collections import deque
from collections.abc import Callable
from typing import ClassVar, Generic, TypeVar

from sunset_ros.interfaces import Message, Service, type_name
from sunset_ros.rmw.core.node import Entity, Middleware, NodeHandle
from sunset_ros.rmw.core.port import EndpointKind
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.sim._compute import OTHER_CALLBACK_NS
from sunset_ros.rmw.sim._network import Network

ItemT = TypeVar("ItemT")


class SimHost(Middleware):
    """A simulated process, as its parts need it.

    Attributes:
        name: its name in errors.
        network: the network.
        is_protected: whether other processes can neither delay it nor notice its requests.
    """

    name: str
    network: Network
    is_protected: bool

    @abstractmethod
    def notify(self, entity: "SimEntity", *, first: bool = False) -> None:
        """Line up an entity with work, before all others if `first`."""

    @abstractmethod
    def send(self, leave: Callable[..., None], payload: object) -> None:
        """Call `leave(payload)` when the running callback ends, or now if no callback runs."""


class SimEntity(Entity[SimHost]):
    """A part of a node that has callbacks."""

    @abstractmethod
    def ready(self) -> bool:
        """Whether there is work."""

    @abstractmethod
    def run(self) -> None:
        """Call the handler once."""

    def cost_ns(self) -> int:
        """Return the duration of the next callback."""
        return OTHER_CALLBACK_NS


class SimEndpoint(Entity[SimHost]):
    """A part that is visible on the graph; its gid is a whole number."""

    kind: ClassVar[EndpointKind]

    def __init__(
        self,
        process: SimHost,
        node: NodeHandle,
        ros_type: type[Message | Service],
        name: str,
        qos: QoSProfile,
        *,
        label: str,
    ) -> None:
        super().__init__(process, node, label)
        self.name = name
        self.type_name = type_name(ros_type)
        self.qos = qos
        self.gid = process.network.new_gid()

    def join(self) -> None:
        super().join()
        self.process.network.add(self)

    def retire(self) -> None:
        super().retire()
        self.process.network.remove(self)


class SimReceiver(SimEndpoint, SimEntity, Generic[ItemT]):
    """An endpoint with a queue of its QoS's depth, which drops the oldest item."""

    def __init__(
        self,
        process: SimHost,
        node: NodeHandle,
        ros_type: type[Message | Service],
        name: str,
        qos: QoSProfile,
        *,
        handler: Callable[..., None],
        label: str,
    ) -> None:
        super().__init__(process, node, ros_type, name, qos, label=label)
        self._handler = handler
        self._items: deque[ItemT] = deque()
        self._limit = qos.limit
        self.join()

    def deliver(self, item: ItemT) -> None:
        """Queue an item; each item in the queue has been notified once."""
        if not self.alive:
            return
        items = self._items
        if len(items) == self._limit:
            items.popleft()
            items.append(item)
        else:
            items.append(item)
            self.process.notify(self)

    def ready(self) -> bool:
        return bool(self._items)

    def join(self) -> None:
        super().join()
        if self.kind is not EndpointKind.CLIENT:
            for tap in self.process.network.taps:
                tap.on_endpoint(self.node.fully_qualified_name, self.kind, self.name)

    def retire(self) -> None:
        super().retire()
        self._items.clear()
