"""What the nodes of every middleware share: who has which parts, whose callbacks may run, and what an error says.

A middleware's process is a `Host`; what its nodes are made of are `Entity`s that it names in `Parts`. Endpoints import
this module, the process imports its endpoints, and nothing imports the process.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from sunset.errors import MiddlewareError
from sunset.interfaces import Message, Service
from sunset.rmw.core.port import (
    CallbackError,
    ClientHandle,
    Middleware,
    NodeHandle,
    PublisherHandle,
    QoSProfile,
    RequestId,
    ServiceHandle,
    SubscriptionHandle,
    TimerHandle,
)

__all__ = ["Entity", "Host", "HostT_co", "Node", "Parts", "run_callback"]


class Host(Middleware):
    """A process, as its nodes need it."""

    @abstractmethod
    def check_alive(self) -> None:
        """Refuse to do something in a process that has ended.

        Raises:
            MiddlewareError: it has.
        """

    @abstractmethod
    def post(self, node: "Node", handler: Callable[[], None], label: str) -> None:
        """Call a handler of a node once, after those that are ready already."""

    @abstractmethod
    def remove(self, node: "Node") -> None:
        """Take a node, which has no parts any more, off the graph."""


HostT_co = TypeVar("HostT_co", bound=Host, covariant=True)


@dataclass(frozen=True, slots=True)
class Parts:
    """Makes what nodes consist of: each is called with the node and the arguments of `NodeHandle.create_…`."""

    publisher: Callable[..., PublisherHandle]
    subscription: Callable[..., SubscriptionHandle]
    client: Callable[..., ClientHandle]
    service: Callable[..., ServiceHandle]
    timer: Callable[..., TimerHandle]


class Node(NodeHandle):
    """A node of a process.

    Attributes:
        process: the process.
        fqn: its fully qualified name.
        entities: its parts, as the keys, by age.
        alive: False once destroyed.
        attached: whether its callbacks run while the process spins.
        warn: is told in a sentence of what came and could not be used.
    """

    __slots__ = (
        "_held",
        "_parts",
        "alive",
        "attached",
        "entities",
        "fqn",
        "name",
        "namespace",
        "process",
        "warn",
    )

    def __init__(self, process: Host, parts: Parts, name: str, namespace: str) -> None:
        process.check_alive()
        self.name = name
        self.namespace = namespace
        self.fqn = f"{namespace.rstrip('/')}/{name}"
        self.process = process
        self.entities: dict[Entity[Host], None] = {}
        self.alive = True
        self.attached = False
        self.warn: Callable[[str], None] | None = None
        self._parts = parts
        self._held: list[Callable[[], None]] = []

    @property
    def fully_qualified_name(self) -> str:
        """Namespace and name, such as `/managed_subsystem/camera`."""
        return self.fqn

    def check_alive(self) -> None:
        """Refuse to extend a node that is destroyed.

        Raises:
            MiddlewareError: it is, or its process has ended.
        """
        self.process.check_alive()
        if not self.alive:
            raise MiddlewareError(f"Node {self.fqn} is destroyed and can have no new endpoints.")

    def create_publisher(self, message_type: type[Message], topic: str, qos: QoSProfile) -> PublisherHandle:
        """Make a writer on `topic`."""
        return self._parts.publisher(self, message_type, topic, qos)

    def create_subscription(
        self,
        message_type: type[Message],
        topic: str,
        qos: QoSProfile,
        handler: Callable[[Message], None],
        *,
        label: str,
    ) -> SubscriptionHandle:
        """Make a reader of `topic`."""
        return self._parts.subscription(self, message_type, topic, qos, handler=handler, label=label)

    def create_client(
        self,
        service_type: type[Service],
        name: str,
        qos: QoSProfile,
        handler: Callable[[int, Message], None],
        *,
        label: str,
    ) -> ClientHandle:
        """Make the asking end of service `name`."""
        return self._parts.client(self, service_type, name, qos, handler=handler, label=label)

    def create_service(
        self,
        service_type: type[Service],
        name: str,
        qos: QoSProfile,
        handler: Callable[[RequestId, Message], None],
        *,
        label: str,
    ) -> ServiceHandle:
        """Make the answering end of service `name`."""
        return self._parts.service(self, service_type, name, qos, handler=handler, label=label)

    def create_timer(self, period_ns: int, handler: Callable[[], None], label: str) -> TimerHandle:
        """Make a running timer."""
        return self._parts.timer(self, period_ns, handler, label)

    def post(self, handler: Callable[[], None], label: str) -> None:
        """Call the handler once, as a callback of this node, after those that are ready already."""
        self.process.post(self, handler, label)

    def on_problem(self, handler: Callable[[str], None]) -> None:
        """Tell `handler` in a sentence, at a limited rate, what the network brought and could not be used."""
        self.warn = handler

    def attach(self) -> None:
        """Let the callbacks of this node run while its process spins."""
        self.attached = True
        held, self._held = self._held, []
        for go_on in held:
            go_on()

    def detach(self) -> None:
        """Hold the callbacks of this node back."""
        self.attached = False

    def hold(self, go_on: Callable[[], None]) -> None:
        """Call a function, which lets a callback go on, when the node is attached."""
        self._held.append(go_on)

    def destroy(self) -> None:
        """Leave the graph with all parts."""
        for entity in list(self.entities):
            entity.retire()
        self._held.clear()
        self.alive = False
        self.process.remove(self)


class Entity(ABC, Generic[HostT_co]):
    """A part of a node; most have callbacks.

    Attributes:
        process: its node's process.
        node: its node.
        label: names its callback in errors.
        alive: False once destroyed.
    """

    __slots__ = ("alive", "label", "node", "process")

    def __init__(self, process: HostT_co, node: Node, label: str) -> None:
        node.check_alive()
        self.process = process
        self.node = node
        self.label = label
        self.alive = True

    def join(self) -> None:
        """Become part of the node, now that everything is made."""
        self.node.entities[self] = None

    def retire(self) -> None:
        """Leave the graph, for good, as one of several that do."""
        self.alive = False
        self.node.entities.pop(self, None)

    def destroy(self) -> None:
        """Leave the graph for good."""
        if self.alive:
            self.retire()

    def check_alive(self, action: str) -> None:
        """Refuse to do something with what is destroyed.

        Raises:
            MiddlewareError: it is destroyed, or its process has ended.
        """
        if not self.alive:
            raise MiddlewareError(
                f"Node {self.node.fqn} cannot {action}: it was destroyed, or its process has ended."
            )


def run_callback(entity: Entity[Host], function: Callable[..., object], *arguments: Any) -> None:
    """Call a function that an entity's user has given.

    Raises:
        CallbackError: it raised.
    """
    try:
        function(*arguments)
    except CallbackError:
        raise
    except Exception as error:
        raise CallbackError.of(entity.node.fqn, entity.label, error) from error
