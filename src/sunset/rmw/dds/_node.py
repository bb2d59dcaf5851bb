"""A node of a process on DDS."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from sunset.errors import MiddlewareError
from sunset.interfaces import Message, Service
from sunset.rmw.core.port import NodeHandle, QoSProfile, RequestId
from sunset.rmw.dds._entity import DdsPosted, DdsTimer, Entity
from sunset.rmw.dds._graph import NodeEntities
from sunset.rmw.dds._services import DdsClient, DdsService
from sunset.rmw.dds._topics import DdsPublisher, DdsSubscription

if TYPE_CHECKING:
    from sunset.rmw.dds import CycloneDDS

__all__ = ["DdsNode"]


class DdsNode(NodeHandle):
    """A node of a process on DDS.

    Attributes:
        process: the process.
        entities: its parts, as the keys, by age.
        attached: whether its callbacks run while the process spins.
        warn: told in a sentence of what came and could not be used.
    """

    __slots__ = ("_waiting", "attached", "entities", "name", "namespace", "process", "warn")

    def __init__(self, process: "CycloneDDS", name: str, namespace: str) -> None:
        process.check_alive()
        self.name = name
        self.namespace = namespace
        self.process = process
        self.entities: dict[Entity, None] = {}
        self.attached = False
        self.warn: Callable[[str], None] | None = None
        self._waiting: list[Entity] = []

    def describe(self) -> NodeEntities:
        """Return what others are told of it."""
        return NodeEntities(
            self.namespace,
            self.name,
            tuple(guid for entity in self.entities for guid in entity.readers),
            tuple(guid for entity in self.entities for guid in entity.writers),
        )

    def check_alive(self) -> None:
        """Refuse to extend a node that is destroyed.

        Raises:
            MiddlewareError: it is, or its process has ended.
        """
        self.process.check_alive()
        if not self.process.has(self):
            raise MiddlewareError(
                f"Node {self.fully_qualified_name} is destroyed and can have no new endpoints."
            )

    def create_publisher(self, message_type: type[Message], topic: str, qos: QoSProfile) -> DdsPublisher:
        """Make a writer on `topic`."""
        return DdsPublisher(self, message_type, topic, qos)

    def create_subscription(
        self,
        message_type: type[Message],
        topic: str,
        qos: QoSProfile,
        handler: Callable[[Message], None],
        *,
        label: str,
    ) -> DdsSubscription:
        """Make a reader of `topic`."""
        return DdsSubscription(self, message_type, topic, qos, handler, label=label)

    def create_client(
        self,
        service_type: type[Service],
        name: str,
        qos: QoSProfile,
        handler: Callable[[int, Message], None],
        *,
        label: str,
    ) -> DdsClient:
        """Make the asking end of service `name`."""
        return DdsClient(self, service_type, name, qos, handler, label=label)

    def create_service(
        self,
        service_type: type[Service],
        name: str,
        qos: QoSProfile,
        handler: Callable[[RequestId, Message], None],
        *,
        label: str,
    ) -> DdsService:
        """Make the answering end of service `name`."""
        return DdsService(self, service_type, name, qos, handler, label=label)

    def create_timer(self, period_ns: int, handler: Callable[[], None], label: str) -> DdsTimer:
        """Make a running timer."""
        return DdsTimer(self, period_ns, handler, label)

    def post(self, handler: Callable[[], None], label: str) -> None:
        """Call the handler once, as a callback of this node, after those that are ready already."""
        self.process.queue(DdsPosted(self, handler, label))

    def on_problem(self, handler: Callable[[str], None]) -> None:
        """Tell `handler` in a sentence what the network brought and could not be used, at a limited rate."""
        self.warn = handler

    def attach(self) -> None:
        """Let the callbacks of this node run while its process spins."""
        self.attached = True
        waiting, self._waiting = self._waiting, []
        for entity in waiting:
            self.process.queue(entity)

    def detach(self) -> None:
        """Hold the callbacks of this node back."""
        self.attached = False

    def hold(self, entity: Entity) -> None:
        """Remember that an entity has something to do until the node is attached."""
        self._waiting.append(entity)

    def destroy(self) -> None:
        """Leave the graph with all endpoints."""
        for entity in list(self.entities):
            entity.retire()
        self._waiting.clear()
        self.process.remove(self)
