"""Processes of a middleware, their nodes, and the parts of nodes.

A middleware implements `Middleware` and, in `Parts`, the classes of the parts, which import the process.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar, NamedTuple, TypeVar

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message, Service, serialize
from sunset_ros.rmw.core.port import (
    CallbackError,
    EndpointKind,
    Process,
    RequestId,
    next_due_ns,
    qualified_name,
)
from sunset_ros.rmw.core.qos import QoSProfile

MessageT = TypeVar("MessageT", bound=Message)


class Middleware(Process):
    """One process on the network, which has nodes."""

    parts: "Parts"

    @abstractmethod
    def create_node(self, name: str, namespace: str) -> "NodeHandle":
        """Enter the graph with a node without endpoints."""

    @abstractmethod
    def post(self, node: "NodeHandle", handler: Callable[[], None], label: str) -> None:
        """Call a handler of a node once, after all ready callbacks."""

    @abstractmethod
    def remove(self, node: "NodeHandle") -> None:
        """Take a node without parts off the graph."""


class NodeHandle:
    """A node on the graph; the root namespace is `/`. Labels name a callback in errors."""

    def __init__(self, process: Middleware, name: str, namespace: str) -> None:
        process.check_alive()
        self.name = name
        self.namespace = namespace
        self.fully_qualified_name = qualified_name(namespace, name)
        self.process = process
        self.entities: dict[Entity, None] = {}  # its parts, by age
        self.alive = True  # until it is destroyed
        self.attached = False  # whether its callbacks run while the process spins
        self.warn: Callable[[str], None] | None = None
        """Called, at a limited rate, with a sentence about data that could not be used."""
        self._held: list[Callable[[], None]] = []

    def check_alive(self) -> None:
        """Raise a `MiddlewareError` if the node is destroyed or its process has ended."""
        self.process.check_alive()
        if not self.alive:
            raise MiddlewareError(
                f"Node {self.fully_qualified_name} is destroyed and can have no new endpoints."
            )

    def create_publisher(self, message_type: type[Message], topic: str, qos: QoSProfile) -> "PublisherHandle":
        """Make a publisher of a topic."""
        return self.process.parts.publisher(self, message_type, topic, qos)

    def create_subscription(
        self,
        message_type: type[MessageT],
        topic: str,
        qos: QoSProfile,
        handler: Callable[[MessageT], None],
        *,
        label: str,
    ) -> "SubscriptionHandle":
        """Make a subscription to a topic."""
        return self.process.parts.subscription(self, message_type, topic, qos, handler=handler, label=label)

    def create_client(
        self,
        service_type: type[Service],
        name: str,
        qos: QoSProfile,
        handler: Callable[[int, Message], None],
        *,
        label: str,
    ) -> "ClientHandle":
        """Make a client; its handler takes (number of the request, response)."""
        return self.process.parts.client(self, service_type, name, qos, handler=handler, label=label)

    def create_service(
        self,
        service_type: type[Service],
        name: str,
        qos: QoSProfile,
        handler: Callable[[RequestId, Message], None],
        *,
        label: str,
    ) -> "ServiceHandle":
        """Make a server of a service."""
        return self.process.parts.service(self, service_type, name, qos, handler=handler, label=label)

    def create_timer(self, period_ns: int, handler: Callable[[], None], label: str) -> "Timer":
        """Make a running timer with a period of at least 0 ns."""
        return self.process.parts.timer(self, period_ns, handler, label)

    def post(self, handler: Callable[[], None], label: str) -> None:
        """Call a handler once, as a callback of this node, after all ready callbacks."""
        self.process.post(self, handler, label)

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
        """Call a function, which lines a callback up again, when the node is attached."""
        self._held.append(go_on)

    def destroy(self) -> None:
        """Leave the graph with all parts."""
        for entity in list(self.entities):
            entity.retire()
        self._held.clear()
        self.alive = False
        self.process.remove(self)


class Entity(ABC):  # noqa: B024  its subclasses have abstract methods
    """A part of a node, alive until destroyed; most have callbacks, which errors name by the label."""

    def __init__(self, node: NodeHandle, label: str) -> None:
        node.check_alive()
        self.process = node.process
        self.node = node
        self.label = label
        self.alive = True

    def join(self) -> None:
        """Become part of the node, as the last step of construction."""
        self.node.entities[self] = None

    def retire(self) -> None:
        """Leave the graph for good, without an announcement: `destroy` for one of many."""
        self.alive = False
        self.node.entities.pop(self, None)

    def destroy(self) -> None:
        """Leave the graph for good: sent messages still arrive, received messages in the queue are dropped."""
        if self.alive:
            self.retire()

    def check_alive(self, action: str) -> None:
        """Raise a `MiddlewareError` if the part is destroyed or its process has ended."""
        if not self.alive:
            raise MiddlewareError(
                f"Node {self.node.fully_qualified_name} cannot {action}: it was destroyed, or its process has ended."
            )

    def call(self, function: Callable[..., None], *arguments: object) -> None:
        """Call a function, whose exceptions become a `CallbackError`."""
        try:
            function(*arguments)
        except CallbackError:
            raise
        except Exception as error:
            raise CallbackError.of(self.node.fully_qualified_name, self.label, error) from error


class Endpoint(Entity):
    """A part that is visible on the graph, with the name of its topic or service; `handler` takes what it receives."""

    kind: ClassVar[EndpointKind]

    def __init__(
        self,
        node: NodeHandle,
        ros_type: type[Message | Service],
        name: str,
        qos: QoSProfile,
        *,
        handler: Callable[..., None] = lambda *_: None,
        label: str = "",
    ) -> None:
        super().__init__(node, label)
        self.ros_type = ros_type
        sent, received = (
            (ros_type, ros_type) if issubclass(ros_type, Message) else (ros_type.Request, ros_type.Response)
        )
        self.sent, self.received = (received, sent) if self.kind is EndpointKind.SERVICE else (sent, received)
        self.name = name
        self.qos = qos
        self.handler = handler
        self.open()
        self.join()

    def open(self) -> None:
        """Prepare to join the node."""


class PublisherHandle(Endpoint):
    """A publisher of a topic."""

    kind = EndpointKind.PUBLISHER

    @abstractmethod
    def publish(self, message: Message) -> None:
        """Send a message; the caller may change it afterwards, but not the arrays in it.

        Raises:
            MiddlewareError: the publisher is destroyed, or the middleware refuses.
            InterfaceError: the message does not fit its definition; some middlewares raise it later.
        """

    @property
    @abstractmethod
    def wanted(self) -> bool:
        """Whether a subscription would receive a message sent now, at once or later."""

    @property
    @abstractmethod
    def matched(self) -> int:
        """The number of subscriptions that receive messages from here."""


class SubscriptionHandle(Endpoint):
    """A subscription to a topic, with a queue of the depth in its QoS."""

    kind = EndpointKind.SUBSCRIPTION

    @property
    @abstractmethod
    def matched(self) -> int:
        """The number of publishers whose messages arrive here."""


class ClientHandle(Endpoint):
    """A client of a service; requests go to every server of its name and type."""

    kind = EndpointKind.CLIENT
    _sequence = 0

    def send_request(self, request: Message) -> int:
        """Send a request, and return its number, which the handler receives with the response.

        The numbers of each client run from 1, so that remote clients know them.

        Raises:
            MiddlewareError: the client is destroyed.
            InterfaceError: the request does not fit its definition.
        """
        self.check_alive(f"call {self.name}")
        self.send(self._sequence + 1, request, serialize(request))
        self._sequence += 1
        return self._sequence

    @abstractmethod
    def send(self, number: int, request: Message, payload: bytes) -> None:
        """Send a request with its number, given also as CDR."""

    @abstractmethod
    def server_ready(self) -> bool:
        """Return whether a server of this name and type exists."""


class ServiceHandle(Endpoint):
    """A server of a service, with a queue of the depth in its QoS."""

    kind = EndpointKind.SERVICE

    def open(self) -> None:
        """Begin without requests."""
        super().open()
        self.asked: dict[RequestId, Callable[[Message, bytes], None]] = {}
        """Request that waits for its response → sends the response, given also as CDR."""

    def send_response(self, request_id: RequestId, response: Message) -> None:
        """Answer a request of the handler.

        Raises:
            MiddlewareError: no such request waits, or the server is destroyed.
            InterfaceError: the response does not fit its definition.
        """
        self.check_alive(f"answer on {self.name}")
        payload = serialize(response)
        if request_id not in self.asked:
            raise MiddlewareError(f"Service {self.name} has no request {tuple(request_id)} to answer.")
        self.asked.pop(request_id)(response, payload)


class Timer(Entity):
    """Calls its handler periodically, by the steady clock of its process; a middleware sets its alarm.

    The n-th call is due at start + n * period. A late call does not shift later calls, and missed calls are skipped.
    """

    def __init__(self, node: NodeHandle, period_ns: int, handler: Callable[[], None], label: str) -> None:
        super().__init__(node, label)
        self.set_period_ns(period_ns)
        self._handler = handler
        self.reset()
        self.join()

    @abstractmethod
    def set_alarm(self, due_ns: int | None) -> None:
        """Expire at `due_ns` of the process's steady clock; never if it is None."""

    def set_period_ns(self, period_ns: int) -> None:
        """Change the period from the next call on; raise a `MiddlewareError` if it is negative."""
        if period_ns < 0:
            raise MiddlewareError(f"A timer's period must be at least 0 ns, got {period_ns}.")
        self._period_ns = period_ns

    def reset(self) -> None:
        """Start again: the next call is due one period from now."""
        self.check_alive("reset a timer")
        self.canceled = False
        self._wait_until(self.process.steady_ns() + self._period_ns)

    def cancel(self) -> None:
        """Stop calling until `reset`."""
        self.canceled = True
        self.set_alarm(None)

    @property
    def due_ns(self) -> int:
        """The time of the next call, by the system clock."""
        return self.process.now_ns() + self._due_ns - self.process.steady_ns()

    def run(self) -> None:
        """Set the next alarm, and call the handler."""
        self._wait_until(next_due_ns(self._due_ns, self._period_ns, self.process.steady_ns()))
        self._handler()

    def _wait_until(self, due_ns: int) -> None:
        self._due_ns = due_ns
        self.set_alarm(due_ns)

    def retire(self) -> None:
        """Stop for good."""
        self.cancel()
        super().retire()


class Parts(NamedTuple):
    """The classes of the parts of nodes."""

    publisher: type[PublisherHandle]
    subscription: type[SubscriptionHandle]
    client: type[ClientHandle]
    service: type[ServiceHandle]
    timer: type[Timer]
