"""Simulated clients and servers of services."""

from collections.abc import Callable
from typing import ClassVar

from sunset.errors import MiddlewareError
from sunset.interfaces import Message, Service, serialize
from sunset.rmw.core.node import NodeHandle
from sunset.rmw.core.port import ClientHandle, EndpointKind, QoSProfile, RequestId, ServiceHandle
from sunset.rmw.sim._entity import SimHost, SimReceiver
from sunset.rmw.sim._scheduler import Priority


class SimClient(SimReceiver[tuple[int, Message]], ClientHandle):
    """Asks every server of its name and type."""

    __slots__ = ("_handler", "_sequence")

    kind: ClassVar = EndpointKind.CLIENT

    def __init__(
        self,
        process: SimHost,
        node: NodeHandle,
        service_type: type[Service],
        name: str,
        qos: QoSProfile,
        *,
        handler: Callable[[int, Message], None],
        label: str,
    ) -> None:
        super().__init__(process, node, service_type, name, qos, label=label, limit=None)
        self._handler = handler
        self._sequence = 0
        self.join()

    def servers(self) -> "list[SimService]":
        """The servers that would get a request now."""
        services = self.process.network.named(self.name, SimService)
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
        network = self.process.network
        arrival = network.scheduler.now + network.latency_ns
        asked = (RequestId(self.gid, sequence), self, request)
        for server in self.servers():
            network.scheduler.add(arrival, Priority.DELIVERY, server.deliver, asked)

    def server_ready(self) -> bool:
        """Whether a server of this name and type is there."""
        return bool(self.servers())

    def run(self) -> None:
        """Handle the oldest response, in a copy of the client's own."""
        sequence, response = self._items.popleft()
        self._handler(sequence, response.copy())


class SimService(SimReceiver[tuple[RequestId, SimClient, Message]], ServiceHandle):
    """Holds at most `depth` requests that were not handled yet, and drops the oldest."""

    __slots__ = ("_asking", "_handler")

    kind: ClassVar = EndpointKind.SERVICE

    def __init__(
        self,
        process: SimHost,
        node: NodeHandle,
        service_type: type[Service],
        name: str,
        qos: QoSProfile,
        *,
        handler: Callable[[RequestId, Message], None],
        label: str,
    ) -> None:
        super().__init__(process, node, service_type, name, qos, label=label, limit=qos.limit)
        self._handler = handler
        self._asking: dict[RequestId, SimClient] = {}
        self.join()
        for tap in process.network.taps:
            tap.on_endpoint(node.fully_qualified_name, self.kind, name)

    def run(self) -> None:
        """Handle the oldest request, in a copy of the server's own."""
        request_id, client, request = self._items.popleft()
        network = self.process.network
        asking, server = client.node.fully_qualified_name, self.node.fully_qualified_name
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
        network = self.process.network
        now = network.scheduler.now
        for tap in network.taps:
            tap.on_response(now, self.name, self.node.fully_qualified_name, response, request_id)
        arrival = now + network.latency_ns
        network.scheduler.add(arrival, Priority.DELIVERY, client.deliver, (request_id.sequence, response))
