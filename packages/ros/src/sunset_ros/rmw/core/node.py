"""Processes of a middleware, and their nodes.

A middleware implements `Middleware` and, in `Parts`, the entities of nodes. Endpoints import this module, the process
imports its endpoints, and no module of the middleware imports the process.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message, Service
from sunset_ros.rmw.core.port import (
    ClientHandle,
    EndpointInfo,
    PublisherHandle,
    RequestId,
    ServiceHandle,
    SubscriptionHandle,
    qualified_name,
)
from sunset_ros.rmw.core.qos import QoSProfile


class Middleware(ABC):
    """One process on the network."""

    @abstractmethod
    def now_ns(self) -> int:
        """Return the time of the system clock, in nanoseconds since its epoch."""

    @abstractmethod
    def steady_ns(self) -> int:
        """Return the time of a clock that never jumps, in nanoseconds since some fixed moment."""

    @abstractmethod
    def create_node(self, name: str, namespace: str) -> "NodeHandle":
        """Enter the graph with a node without endpoints."""

    @abstractmethod
    def post(self, node: "NodeHandle", handler: Callable[[], None], label: str) -> None:
        """Call a handler of a node once, after all ready callbacks."""

    @abstractmethod
    def remove(self, node: "NodeHandle") -> None:
        """Take a node without parts off the graph."""

    @abstractmethod
    def spin_once(self, timeout_ns: int | None) -> bool:
        """Wait for a callback of an attached node and run it; return whether a callback ran.

        It does not wait if `timeout_ns` is 0, and waits for ever if it is None. In a simulation, events happen
        meanwhile.

        Raises:
            CallbackError: the callback raised, or in a simulation another callback.
            MiddlewareError: called in a callback, or no events are left in a simulation and `timeout_ns` is None.
        """

    @abstractmethod
    def wait_for(self, predicate: Callable[[], bool], timeout_ns: int | None) -> bool:
        """Wait, except in a callback, until a predicate on the graph holds; return whether it holds.

        Callbacks of this process do not run meanwhile, unless it is simulated.
        """

    @abstractmethod
    def wake(self) -> None:
        """Make a waiting `spin_once` return."""

    @property
    @abstractmethod
    def alive(self) -> bool:
        """Whether the process may still use the network."""

    @abstractmethod
    def check_alive(self) -> None:
        """Raise a `MiddlewareError` if the process has ended."""

    @abstractmethod
    def shutdown(self) -> None:
        """Leave the network; in a callback, once its messages are sent. A signal handler may call it."""

    @abstractmethod
    def nodes(self) -> Sequence[tuple[str, str]]:
        """Return (name, namespace) of all nodes on the graph, in a fixed order."""

    @abstractmethod
    def endpoints(self, name: str | None = None) -> Sequence[EndpointInfo]:
        """Return all endpoints on the graph, or those of a topic or service, in a fixed order."""


MessageT = TypeVar("MessageT", bound=Message)
MiddlewareT_co = TypeVar("MiddlewareT_co", bound=Middleware, covariant=True)


@dataclass(frozen=True, slots=True)
class Parts:
    """Makes the parts of nodes, from the node and the arguments of `NodeHandle.create_…`."""

    publisher: Callable[..., PublisherHandle]
    subscription: Callable[..., SubscriptionHandle]
    client: Callable[..., ClientHandle]
    service: Callable[..., ServiceHandle]
    timer: Callable[..., "Timer[Any]"]


class NodeHandle:
    """A node on the graph. Labels name a callback in errors.

    Attributes:
        name: without namespace.
        namespace: the root is `/`.
        fully_qualified_name: namespace and name, such as `/managed_subsystem/camera`.
        process: its process.
        entities: its parts, by age.
        alive: False once destroyed.
        attached: whether its callbacks run while the process spins.
        warn: called, at a limited rate, with a sentence about data that could not be used.
    """

    def __init__(self, process: Middleware, parts: Parts, name: str, namespace: str) -> None:
        process.check_alive()
        self.name = name
        self.namespace = namespace
        self.fully_qualified_name = qualified_name(namespace, name)
        self.process = process
        self.entities: dict[Entity[Middleware], None] = {}
        self.alive = True
        self.attached = False
        self.warn: Callable[[str], None] | None = None
        self._parts = parts
        self._held: list[Callable[[], None]] = []

    def check_alive(self) -> None:
        """Raise a `MiddlewareError` if the node is destroyed or its process has ended."""
        self.process.check_alive()
        if not self.alive:
            raise MiddlewareError(
                f"Node {self.fully_qualified_name} is destroyed and can have no new endpoints."
            )

    def create_publisher(self, message_type: type[Message], topic: str, qos: QoSProfile) -> PublisherHandle:
        """Make a publisher of a topic."""
        return self._parts.publisher(self, message_type, topic, qos)

    def create_subscription(
        self,
        message_type: type[MessageT],
        topic: str,
        qos: QoSProfile,
        handler: Callable[[MessageT], None],
        *,
        label: str,
    ) -> SubscriptionHandle:
        """Make a subscription to a topic."""
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
        """Make a client; its handler takes (number of the request, response)."""
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
        """Make a server of a service."""
        return self._parts.service(self, service_type, name, qos, handler=handler, label=label)

    def create_timer(self, period_ns: int, handler: Callable[[], None], label: str) -> "Timer[Any]":
        """Make a running timer with a period of at least 0 ns."""
        return self._parts.timer(self, period_ns, handler, label)

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


class Entity(ABC, Generic[MiddlewareT_co]):
    """A part of a node; most have callbacks.

    Attributes:
        process: its node's process.
        node: its node.
        label: the name of its callback in errors.
        alive: False once destroyed.
    """

    def __init__(self, process: MiddlewareT_co, node: NodeHandle, label: str) -> None:
        node.check_alive()
        self.process = process
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
        """Leave the graph for good."""
        if self.alive:
            self.retire()

    def check_alive(self, action: str) -> None:
        """Raise a `MiddlewareError` if the part is destroyed or its process has ended."""
        if not self.alive:
            raise MiddlewareError(
                f"Node {self.node.fully_qualified_name} cannot {action}: it was destroyed, or its process has ended."
            )


class Timer(Entity[MiddlewareT_co]):
    """Calls its handler periodically, by the steady clock of its process; a middleware sets its alarm.

    The n-th call is due at start + n * period. A late call does not shift later calls, and missed calls are skipped.

    Attributes:
        canceled: whether it is stopped.
    """

    def __init__(
        self,
        process: MiddlewareT_co,
        node: NodeHandle,
        period_ns: int,
        handler: Callable[[], None],
        label: str,
    ) -> None:
        super().__init__(process, node, label)
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


def next_due_ns(due_ns: int, period_ns: int, now_ns: int) -> int:
    """Return when a timer is due again after a call that was due at `due_ns` and starts at `now_ns`.

    The result is on the grid of whole periods, and not in the past.

    >>> next_due_ns(100, 100, 130), next_due_ns(100, 100, 430), next_due_ns(100, 100, 400)
    (200, 500, 400)
    """
    due_ns += period_ns
    if due_ns < now_ns:
        due_ns = now_ns if period_ns == 0 else due_ns + -(-(now_ns - due_ns) // period_ns) * period_ns
    return due_ns
