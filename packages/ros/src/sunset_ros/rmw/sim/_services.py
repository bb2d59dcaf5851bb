"""Simulated clients and servers of services."""

from collections import deque
from typing import ClassVar

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message, serialize
from sunset_ros.rmw.core.port import ClientHandle, EndpointKind, RequestId, ServiceHandle
from sunset_ros.rmw.sim._compute import OTHER_CALLBACK_NS
from sunset_ros.rmw.sim._entity import SimReceiver
from sunset_ros.rmw.sim._scheduler import Priority


class SimClient(SimReceiver[tuple[int, Message]], ClientHandle):
    """Sends requests to every server of its name and type; its queue has no limit."""

    kind: ClassVar = EndpointKind.CLIENT

    def join(self) -> None:
        self._limit = None
        self._sequence = 0
        super().join()

    def servers(self) -> "list[SimService]":
        """Return the servers that would receive a request now."""
        services = self.process.network.named(self.name, SimService)
        return [service for service in services if service.type_name == self.type_name]

    def send_request(self, request: Message) -> int:
        self.check_alive(f"call {self.name}")
        serialize(request)  # checks it
        self._sequence += 1
        self.process.send(self._leave, (self._sequence, request.copy()))
        return self._sequence

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
        self._handler(sequence, response.copy())


class SimService(SimReceiver[tuple[RequestId, SimClient, Message]], ServiceHandle):
    """Receives requests."""

    kind: ClassVar = EndpointKind.SERVICE

    def join(self) -> None:
        self._asking: dict[RequestId, SimClient] = {}
        self._protected: deque[tuple[RequestId, SimClient, Message]] = deque()
        super().join()

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
        self._asking[request_id] = client
        self._handler(request_id, request.copy())

    def send_response(self, request_id: RequestId, response: Message) -> None:
        self.check_alive(f"answer on {self.name}")
        serialize(response)  # checks it
        client = self._asking.pop(request_id, None)
        if client is None:
            raise MiddlewareError(f"Service {self.name} has no request {tuple(request_id)} to answer.")
        self.process.send(self._leave, (request_id, client, response.copy()))

    def _leave(self, answered: tuple[RequestId, SimClient, Message]) -> None:
        request_id, client, response = answered
        network = self.process.network
        now = network.scheduler.now
        for tap in network.taps:
            tap.on_response(now, self.name, self.node.fully_qualified_name, response, request_id)
        arrival = now + network.latency_ns
        network.scheduler.add(arrival, Priority.DELIVERY, client.deliver, (request_id.sequence, response))
