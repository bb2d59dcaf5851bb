"""What the nodes of the simulated world consist of, and what that needs of its process."""

from abc import abstractmethod
from collections import deque
from collections.abc import Callable
from typing import ClassVar, Generic, TypeVar

from sunset.interfaces import Message, Service, type_name
from sunset.rmw.core.node import Entity, Middleware, NodeHandle
from sunset.rmw.core.port import EndpointKind
from sunset.rmw.core.qos import QoSProfile
from sunset.rmw.sim._compute import OTHER_CALLBACK_NS
from sunset.rmw.sim._network import Network

ItemT = TypeVar("ItemT")


class SimHost(Middleware):
    """A simulated process, as its parts need it.

    Attributes:
        name: names it in errors.
        network: the world.
        is_protected: whether it is the experiment's, so that nobody can delay it or notice what it asks for.
    """

    name: str
    network: Network
    is_protected: bool

    @abstractmethod
    def notify(self, entity: "SimEntity", *, first: bool = False) -> None:
        """Note that an entity has one more thing to do, before all others if it is to be the first."""

    @abstractmethod
    def send(self, leave: Callable[..., None], payload: object) -> None:
        """Let something leave when the running callback ends, or now if none runs."""


class SimEntity(Entity[SimHost]):
    """A part of a node that has callbacks."""

    @abstractmethod
    def ready(self) -> bool:
        """Whether there is something to do."""

    @abstractmethod
    def run(self) -> None:
        """Do one piece of it: call the handler once."""

    def cost_ns(self) -> int:
        """How long the next callback takes."""
        return OTHER_CALLBACK_NS


class SimEndpoint(Entity[SimHost]):
    """A part that others on the graph see, with what its `EndpointInfo` tells; its gid is a whole number."""

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
    """An endpoint that holds what has come until it is handled: at most as much as its QoS says, without the oldest."""

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
        """Take in what arrives; each item that is held had a notification of its own."""
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
