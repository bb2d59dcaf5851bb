"""Simulated publishers and subscriptions."""

from collections import deque
from typing import ClassVar

from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces import Message
from sunset_ros.rmw.core.node import NodeHandle
from sunset_ros.rmw.core.port import CallbackError, EndpointKind, PublisherHandle, SubscriptionHandle
from sunset_ros.rmw.core.qos import DurabilityPolicy, QoSProfile, incompatibility
from sunset_ros.rmw.sim._compute import OTHER_CALLBACK_NS
from sunset_ros.rmw.sim._entity import SimEndpoint, SimHost, SimReceiver
from sunset_ros.rmw.sim._scheduler import Priority

_UNCHARGED_TOPICS = frozenset({"/clock"})
"""Topics that the client library handles, for which no compute time is charged."""


class SimSubscription(SimReceiver[Message], SubscriptionHandle):
    """Receives samples."""

    kind: ClassVar = EndpointKind.SUBSCRIPTION

    def join(self) -> None:
        network = self.process.network
        is_charged = self.name not in _UNCHARGED_TOPICS
        self._draw_cost = network.compute.sampler(self.node.fully_qualified_name) if is_charged else None
        self.publishers: list[SimPublisher] = []
        super().join()
        for publisher in network.named(self.name, SimPublisher):
            publisher.match(self)

    def run(self) -> None:
        self._handler(self._items.popleft().copy())  # the reader's own copy

    def cost_ns(self) -> int:
        return OTHER_CALLBACK_NS if self._draw_cost is None else self._draw_cost()

    @property
    def matched(self) -> int:
        return len(self.publishers)

    def retire(self) -> None:
        super().retire()
        for publisher in self.publishers:
            publisher.subscriptions.remove(self)
        self.publishers.clear()


class SimPublisher(SimEndpoint, PublisherHandle):
    """Sends samples to all matching subscriptions when the running callback ends."""

    kind: ClassVar = EndpointKind.PUBLISHER

    def __init__(
        self, process: SimHost, node: NodeHandle, message_type: type[Message], topic: str, qos: QoSProfile
    ) -> None:
        super().__init__(process, node, message_type, topic, qos, label=f"publisher of {topic}")
        self.subscriptions: list[SimSubscription] = []
        self._kept: deque[tuple[int, Message]] | None = None
        if qos.durability is DurabilityPolicy.TRANSIENT_LOCAL:
            self._kept = deque(maxlen=qos.limit)
        self.join()
        for subscription in process.network.named(topic, SimSubscription):
            self.match(subscription)

    def match(self, subscription: SimSubscription) -> None:
        """Connect to a subscription of this topic, if type and QoS fit."""
        if subscription.type_name != self.type_name or incompatibility(self.qos, subscription.qos):
            return
        self.subscriptions.append(subscription)
        subscription.publishers.append(self)
        if self._kept and subscription.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL:
            network = self.process.network
            scheduler = network.scheduler
            lifespan = self.qos.lifespan_ns
            arrival = scheduler.now + network.latency_ns
            for sent, message in self._kept:
                if lifespan is None or scheduler.now - sent <= lifespan:
                    scheduler.add(arrival, Priority.DELIVERY, subscription.deliver, message)

    def publish(self, message: Message) -> None:
        if not self.alive:
            self.check_alive(f"publish on {self.name}")
        self.process.send(self._leave, message.copy())

    def _leave(self, message: Message) -> None:
        network = self.process.network
        now = network.scheduler.now
        try:
            for tap in network.taps:
                tap.on_message(now, self.name, self.node.fully_qualified_name, message)
        except InterfaceError as error:
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
        return bool(self.subscriptions or self.process.network.taps) or self._kept is not None

    @property
    def matched(self) -> int:
        return len(self.subscriptions) if self.alive else 0

    def retire(self) -> None:
        super().retire()
        for subscription in self.subscriptions:
            subscription.publishers.remove(self)
        # The list is kept: messages of the running callback have not left yet.
