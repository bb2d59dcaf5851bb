"""Simulated clients and servers of services."""

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from sunset.errors import MiddlewareError
from sunset.interfaces import Message, Service, serialize, type_name
from sunset.rmw.core.port import ClientHandle, EndpointKind, QoSProfile, RequestId, ServiceHandle
from sunset.rmw.sim._entity import Entity
from sunset.rmw.sim._scheduler import Priority

if TYPE_CHECKING:
    from sunset.rmw.sim._process import SimNode

__all__ = ["SimClient", "SimService"]


class SimClient(Entity, ClientHandle):
    """Asks every server of its name and type."""

    __slots__ = ("_handler", "_responses", "_sequence", "gid", "name", "qos", "type_name")

    def __init__(
        self,
        node: "SimNode",
        service_type: type[Service],
        name: str,
        qos: QoSProfile,
        handler: Callable[[int, Message], None],
        *,
        label: str,
    ) -> None:
        super().__init__(node, label)
        self.name = name
        self.type_name = type_name(service_type)
        self.qos = qos
        self.gid = node.network.new_gid()
        self._handler = handler
        self._sequence = 0
        self._responses: deque[tuple[int, Message]] = deque()
        node.network.clients.add(self)

    def servers(self) -> "list[SimService]":
        """The servers that would get a request now."""
        services = self.node.network.services.named(self.name)
        return [service for service in services if service.type_name == self.type_name]

    def send_request(self, request: Message) -> int:
        """Send a request and return its number.

        Raises:
            InterfaceError: it does not fit its definition.
        """
        self.check_alive(f"call {self.name}")
        serialize(request)
        self._sequence += 1
        self.process.send(self._leave, (self._sequence, request.copy()))
        return self._sequence

    def _leave(self, numbered: tuple[int, Message]) -> None:
        sequence, request = numbered
        network = self.node.network
        arrival = network.scheduler.now + network.latency_ns
        asked = (RequestId(self.gid, sequence), self, request)
        for server in self.servers():
            network.scheduler.add(arrival, Priority.DELIVERY, server.deliver, asked)

    def deliver(self, numbered: tuple[int, Message]) -> None:
        """Take in a response that arrives."""
        if self.alive:
            self._responses.append(numbered)
            self.process.notify(self)

    def server_ready(self) -> bool:
        """Whether a server of this name and type is there."""
        return bool(self.servers())

    def ready(self) -> bool:
        """Whether there is a response."""
        return bool(self._responses)

    def run(self) -> None:
        """Handle the oldest response, in a copy of the client's own."""
        sequence, response = self._responses.popleft()
        self._handler(sequence, response.copy())

    def destroy(self) -> None:
        """Leave the graph; responses on their way are dropped."""
        if self.retire():
            self._responses.clear()
            self.node.network.clients.remove(self)


class SimService(Entity, ServiceHandle):
    """Holds at most `depth` requests that were not handled yet, and drops the oldest."""

    __slots__ = ("_asking", "_handler", "_limit", "_requests", "gid", "name", "qos", "type_name")

    def __init__(
        self,
        node: "SimNode",
        service_type: type[Service],
        name: str,
        qos: QoSProfile,
        handler: Callable[[RequestId, Message], None],
        *,
        label: str,
    ) -> None:
        super().__init__(node, label)
        self.name = name
        self.type_name = type_name(service_type)
        self.qos = qos
        self.gid = node.network.new_gid()
        self._handler = handler
        self._limit = qos.limit
        self._requests: deque[tuple[RequestId, SimClient, Message]] = deque()
        self._asking: dict[RequestId, SimClient] = {}
        node.network.services.add(self)
        for tap in node.network.taps:
            tap.on_endpoint(node.fqn, EndpointKind.SERVICE, name)

    def deliver(self, asked: tuple[RequestId, SimClient, Message]) -> None:
        """Take in a request that arrives."""
        if not self.alive:
            return
        requests = self._requests
        if len(requests) == self._limit:
            requests.popleft()
            requests.append(asked)
        else:
            requests.append(asked)
            self.process.notify(self)

    def ready(self) -> bool:
        """Whether there is a request."""
        return bool(self._requests)

    def run(self) -> None:
        """Handle the oldest request, in a copy of the server's own."""
        request_id, client, request = self._requests.popleft()
        network = self.node.network
        server = self.node.fully_qualified_name
        asking = client.node.fully_qualified_name
        for tap in network.taps:
            tap.on_request(network.scheduler.now, self.name, asking, server, request, request_id)
        self._asking[request_id] = client
        self._handler(request_id, request.copy())

    def send_response(self, request_id: RequestId, response: Message) -> None:
        """Answer a request that the handler was given.

        Raises:
            MiddlewareError: no such request waits for a response.
            InterfaceError: the response does not fit its definition.
        """
        self.check_alive(f"answer on {self.name}")
        serialize(response)
        client = self._asking.pop(request_id, None)
        if client is None:
            raise MiddlewareError(f"Service {self.name} has no request {tuple(request_id)} to answer.")
        self.process.send(self._leave, (request_id, client, response.copy()))

    def _leave(self, answered: tuple[RequestId, SimClient, Message]) -> None:
        request_id, client, response = answered
        network = self.node.network
        now = network.scheduler.now
        for tap in network.taps:
            tap.on_response(now, self.name, self.node.fully_qualified_name, response, request_id)
        arrival = now + network.latency_ns
        network.scheduler.add(arrival, Priority.DELIVERY, client.deliver, (request_id.sequence, response))

    def destroy(self) -> None:
        """Leave the graph; requests not yet handled are dropped."""
        if self.retire():
            self._requests.clear()
            self.node.network.services.remove(self)
