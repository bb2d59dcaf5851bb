"""The parts of simulated nodes: endpoints and timers."""

from collections import deque
from functools import partial
from typing import Final, Generic, TypeVar

from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces import Message
from sunset_ros.rmw.core.node import (
    ClientHandle,
    Parts,
    PublisherHandle,
    ServiceHandle,
    SubscriptionHandle,
    Timer,
)
from sunset_ros.rmw.core.port import CallbackError, EndpointKind, RequestId
from sunset_ros.rmw.core.qos import DurabilityPolicy, incompatibility
from sunset_ros.rmw.sim._network import OTHER_CALLBACK_NS, NumberedEndpoint, Priority
from sunset_ros.rmw.sim._process import SimEntity, SimProcess

_UNCHARGED_TOPICS = frozenset({"/clock"})
"""Topics that the client library handles, for which no compute time is charged."""

ItemT = TypeVar("ItemT")


class SimEndpoint(NumberedEndpoint):
    """A part that is visible on the graph."""

    process: SimProcess

    def join(self) -> None:
        super().join()
        self.process.network.add(self)

    def retire(self) -> None:
        super().retire()
        self.process.network.remove(self)


class SimReceiver(SimEndpoint, SimEntity, Generic[ItemT]):
    """An endpoint with a queue of its QoS's depth, which drops the oldest item."""

    def open(self) -> None:
        super().open()
        self._items: deque[ItemT] = deque()
        self._limit = self.qos.limit

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


class SimSubscription(SimReceiver[Message], SubscriptionHandle):
    """Receives samples."""

    def join(self) -> None:
        network = self.process.network
        is_charged = self.name not in _UNCHARGED_TOPICS
        self._draw_cost = network.compute.sampler(self.node.fully_qualified_name) if is_charged else None
        self.publishers: list[SimPublisher] = []
        super().join()
        for publisher in network.named(self.name, SimPublisher):
            publisher.match(self)

    def run(self) -> None:
        self.handler(self._items.popleft().copy())  # the reader's own copy

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

    def open(self) -> None:
        self.subscriptions: list[SimSubscription] = []
        self._kept: deque[tuple[int, Message]] | None = None
        if self.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL:
            self._kept = deque(maxlen=self.qos.limit)

    def join(self) -> None:
        super().join()
        for subscription in self.process.network.named(self.name, SimSubscription):
            self.match(subscription)

    def match(self, subscription: SimSubscription) -> None:
        """Connect to a subscription of this topic, if type and QoS fit."""
        if subscription.ros_type is not self.ros_type or incompatibility(self.qos, subscription.qos):
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


class SimClient(SimReceiver[tuple[int, Message]], ClientHandle):
    """Sends requests to every server of its name and type; its queue has no limit."""

    def open(self) -> None:
        super().open()
        self._limit = None

    def servers(self) -> "list[SimService]":
        """Return the servers that would receive a request now."""
        services = self.process.network.named(self.name, SimService)
        return [service for service in services if service.ros_type is self.ros_type]

    def send(self, number: int, request: Message, payload: bytes) -> None:
        del payload
        self.process.send(self._leave, (number, request.copy()))

    def _leave(self, numbered: tuple[int, Message]) -> None:
        sequence, request = numbered
        network = self.process.network
        arrival = network.scheduler.now + network.latency_ns
        asked = (RequestId(self.gid, sequence), self, request)
        for server in self.servers():
            network.scheduler.add(arrival, Priority.DELIVERY, server.deliver, asked)

    def play_back(self, request: Message) -> None:
        """Put a request at the head of its servers' queues."""
        self._sequence += 1
        for server in self.servers():
            server.deliver_first((RequestId(self.gid, self._sequence), self, request))

    def server_ready(self) -> bool:
        return bool(self.servers())

    def run(self) -> None:
        sequence, response = self._items.popleft()
        self.handler(sequence, response.copy())


class SimService(SimReceiver[tuple[RequestId, SimClient, Message]], ServiceHandle):
    """Receives requests."""

    def open(self) -> None:
        super().open()
        self._protected: deque[tuple[RequestId, SimClient, Message]] = deque()

    def deliver(self, item: tuple[RequestId, SimClient, Message]) -> None:
        """Queue a request; requests of protected processes have a queue of their own, which goes first."""
        _, client, _ = item
        if self.alive and client.process.is_protected:
            self._protected.append(item)
            self.process.notify(self, first=True)
        else:
            super().deliver(item)

    def deliver_first(self, item: tuple[RequestId, SimClient, Message]) -> None:
        """Queue a request before all others."""
        if self.alive:
            self._items.appendleft(item)
            self.process.notify(self, first=True)

    def ready(self) -> bool:
        return bool(self._protected or self._items)

    def cost_ns(self) -> int:
        return 0 if self._protected else OTHER_CALLBACK_NS

    def run(self) -> None:
        request_id, client, request = (self._protected or self._items).popleft()
        network = self.process.network
        asking, server = client.node.fully_qualified_name, self.node.fully_qualified_name
        for tap in network.taps:
            tap.on_request(network.scheduler.now, self.name, asking, server, request, request_id)
        self.asked[request_id] = partial(self._send_response, request_id, client)
        self.handler(request_id, request.copy())

    def _send_response(
        self, request_id: RequestId, client: SimClient, response: Message, payload: bytes
    ) -> None:
        del payload
        self.process.send(self._leave, (request_id, client, response.copy()))

    def _leave(self, answered: tuple[RequestId, SimClient, Message]) -> None:
        request_id, client, response = answered
        network = self.process.network
        now = network.scheduler.now
        for tap in network.taps:
            tap.on_response(now, self.name, self.node.fully_qualified_name, response, request_id)
        arrival = now + network.latency_ns
        network.scheduler.add(arrival, Priority.DELIVERY, client.deliver, (request_id.sequence, response))


class SimTimer(Timer, SimEntity):
    """A timer of virtual time."""

    _alarms = 0
    _expired = False

    def set_alarm(self, due_ns: int | None) -> None:
        self._expired = False
        self._alarms += 1
        if due_ns is not None:
            self.process.network.scheduler.add(due_ns, Priority.TIMER, self._expire, self._alarms)

    def _expire(self, alarm: int) -> None:
        if alarm == self._alarms:
            self._expired = True
            self.process.notify(self)

    def ready(self) -> bool:
        return self._expired


PARTS: Final = Parts(SimPublisher, SimSubscription, SimClient, SimService, SimTimer)
