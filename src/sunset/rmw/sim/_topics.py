"""Simulated publishers and subscriptions."""

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from sunset.errors import InterfaceError
from sunset.interfaces import Message, type_name
from sunset.rmw.core.port import (
    CallbackError,
    DurabilityPolicy,
    EndpointKind,
    PublisherHandle,
    QoSProfile,
    SubscriptionHandle,
    incompatibility,
)
from sunset.rmw.sim._entity import Entity
from sunset.rmw.sim._scheduler import Priority

if TYPE_CHECKING:
    from sunset.rmw.sim._process import SimNode

__all__ = ["SimPublisher", "SimSubscription"]

_UNCHARGED_TOPICS = frozenset({"/clock"})
"""Topics that the client library handles itself, so the node's own compute time is not charged."""


class SimSubscription(Entity, SubscriptionHandle):
    """Holds at most `depth` samples that were not handled yet, and drops the oldest."""

    __slots__ = ("_handler", "_limit", "_samples", "gid", "name", "publishers", "qos", "type_name")

    def __init__(
        self,
        node: "SimNode",
        message_type: type[Message],
        topic: str,
        qos: QoSProfile,
        handler: Callable[[Message], None],
        *,
        label: str,
    ) -> None:
        cost = None if topic in _UNCHARGED_TOPICS else node.network.compute.sampler(node.name)
        super().__init__(node, label, cost)
        self.name = topic
        self.type_name = type_name(message_type)
        self.qos = qos
        self.gid = node.network.new_gid()
        self.publishers: list[SimPublisher] = []
        self._handler = handler
        self._limit = qos.limit
        self._samples: deque[Message] = deque()
        node.network.subscriptions.add(self)
        for tap in node.network.taps:
            tap.on_endpoint(node.fqn, EndpointKind.SUBSCRIPTION, topic)
        for publisher in node.network.publishers.named(topic):
            publisher.match(self)

    def deliver(self, message: Message) -> None:
        """Take in a sample that arrives."""
        if not self.alive:
            return
        samples = self._samples
        if len(samples) == self._limit:
            samples.popleft()
            samples.append(message)
        else:
            samples.append(message)
            self.process.notify(self)

    def ready(self) -> bool:
        """Whether there is a sample; each one had its own notification."""
        return bool(self._samples)

    def run(self) -> None:
        """Handle the oldest sample, in a copy of the reader's own."""
        self._handler(self._samples.popleft().copy())

    @property
    def matched(self) -> int:
        """Number of publishers whose messages arrive here."""
        return len(self.publishers)

    def destroy(self) -> None:
        """Leave the graph; messages not yet handled are dropped."""
        if self.retire():
            self._samples.clear()
            self.node.network.subscriptions.remove(self)
            for publisher in self.publishers:
                publisher.subscriptions.remove(self)
            self.publishers.clear()


class SimPublisher(Entity, PublisherHandle):
    """Sends samples to all matching subscriptions when the running callback ends."""

    __slots__ = ("_kept", "gid", "name", "qos", "subscriptions", "type_name")

    def __init__(self, node: "SimNode", message_type: type[Message], topic: str, qos: QoSProfile) -> None:
        super().__init__(node, f"publisher of {topic}")
        self.name = topic
        self.type_name = type_name(message_type)
        self.qos = qos
        self.gid = node.network.new_gid()
        self.subscriptions: list[SimSubscription] = []
        self._kept: deque[tuple[int, Message]] | None = None
        if qos.durability is DurabilityPolicy.TRANSIENT_LOCAL:
            self._kept = deque(maxlen=qos.limit)
        node.network.publishers.add(self)
        for subscription in node.network.subscriptions.named(topic):
            self.match(subscription)

    def match(self, subscription: SimSubscription) -> None:
        """Connect to a subscription of this topic, if type and QoS fit."""
        if subscription.type_name != self.type_name or incompatibility(self.qos, subscription.qos):
            return
        self.subscriptions.append(subscription)
        subscription.publishers.append(self)
        if self._kept and subscription.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL:
            scheduler = self.node.network.scheduler
            lifespan = self.qos.lifespan_ns
            arrival = scheduler.now + self.node.network.latency_ns
            for sent, message in self._kept:
                if lifespan is None or scheduler.now - sent <= lifespan:
                    scheduler.add(arrival, Priority.DELIVERY, subscription.deliver, message)

    def publish(self, message: Message) -> None:
        """Send a message; the caller may change it afterwards, but not the arrays in it."""
        if not self.alive:
            self.check_alive(f"publish on {self.name}")
        self.process.send(self._leave, message.copy())

    def _leave(self, message: Message) -> None:
        network = self.node.network
        now = network.scheduler.now
        try:
            for tap in network.taps:
                tap.on_message(now, self.name, self.node.fully_qualified_name, message)
        except InterfaceError as error:  # it does not fit its definition
            raise CallbackError.of(
                self.node.fully_qualified_name, f"that publishes on {self.name}", error
            ) from error
        if self._kept is not None:
            self._kept.append((now, message))
        add = network.scheduler.add
        arrival = now + network.latency_ns
        for subscription in self.subscriptions:
            add(arrival, Priority.DELIVERY, subscription.deliver, message)

    @property
    def wanted(self) -> bool:
        """Whether anybody would get a message sent now, or could get it later."""
        return bool(self.subscriptions or self.node.network.taps) or self._kept is not None

    @property
    def matched(self) -> int:
        """Number of subscriptions that get what is sent."""
        return len(self.subscriptions) if self.alive else 0

    def ready(self) -> bool:
        """Return False: a publisher has no callbacks."""
        return False

    def run(self) -> None:
        """Do nothing: a publisher has no callbacks."""

    def destroy(self) -> None:
        """Leave the graph; nothing more can be sent, what was sent arrives."""
        if self.retire():
            self.node.network.publishers.remove(self)
            for subscription in self.subscriptions:
                subscription.publishers.remove(self)
            # It keeps its list: what the running callback has published is still to leave.
