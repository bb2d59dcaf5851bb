"""Parts of nodes in another process; each sends changes to its stand-in on the network."""

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message, Service, deserialize, serialize, type_name
from sunset_ros.rmw.core.node import Entity, Middleware, NodeHandle, Timer
from sunset_ros.rmw.core.port import (
    ClientHandle,
    EndpointKind,
    PublisherHandle,
    RequestId,
    ServiceHandle,
    SubscriptionHandle,
)
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.remote._protocol import (
    Answer,
    AskMatched,
    AskReady,
    AskWanted,
    Attach,
    Call,
    Cancel,
    Change,
    Destroy,
    MakeEndpoint,
    MakeTimer,
    Publish,
    Question,
    Reset,
    Respond,
    SetPeriod,
)

_LONGEST_NS = 1 << 62
"""A period of 146 years; the protocol's numbers have 64 bits."""


class RemoteHost(Middleware):
    """The process, as its parts need it; the simulation calls `handlers` by number."""

    handlers: dict[int, Callable[[Call], None]]

    @abstractmethod
    def new_number(self) -> int:
        """Return a number that is new in this process."""

    @abstractmethod
    def request(self, change: Change) -> None:
        """Send a change to the simulation, at the latest with the next turn."""

    @abstractmethod
    def ask(self, question: Question) -> Answer:
        """Return the simulation's answer to a question."""


class RemoteNode(NodeHandle):
    """A node with its number in the protocol."""

    process: RemoteHost
    number: int

    def attach(self) -> None:
        super().attach()
        self.process.request(Attach(self.number, True))

    def detach(self) -> None:
        super().detach()
        self.process.request(Attach(self.number, False))


class _Endpoint(Entity[RemoteHost]):
    """An endpoint and its handler."""

    kind: ClassVar[EndpointKind]

    def __init__(
        self,
        process: RemoteHost,
        node: RemoteNode,
        ros_type: type[Message | Service],
        name: str,
        qos: QoSProfile,
        *,
        label: str,
    ) -> None:
        super().__init__(process, node, label)
        self.name = name
        self.number = process.new_number()
        process.request(
            MakeEndpoint(self.number, node.number, self.kind, type_name(ros_type), name, qos, label)
        )
        process.handlers[self.number] = self.run
        self.join()

    def run(self, call: Call) -> None:
        """Call the handler with the message of a call."""

    def retire(self) -> None:
        super().retire()
        self.process.handlers.pop(self.number, None)
        self.process.request(Destroy(self.number))


class RemotePublisher(_Endpoint, PublisherHandle):
    """Sends samples, and checks them."""

    kind: ClassVar = EndpointKind.PUBLISHER

    def __init__(
        self, process: RemoteHost, node: RemoteNode, message_type: type[Message], topic: str, qos: QoSProfile
    ) -> None:
        super().__init__(process, node, message_type, topic, qos, label=f"publisher of {topic}")

    def publish(self, message: Message) -> None:
        self.check_alive(f"publish on {self.name}")
        self.process.request(Publish(self.number, serialize(message)))

    @property
    def wanted(self) -> bool:
        return self.alive and bool(self.process.ask(AskWanted(self.number)).value)

    @property
    def matched(self) -> int:
        return self.process.ask(AskMatched(self.number)).value if self.alive else 0


class RemoteSubscription(_Endpoint, SubscriptionHandle):
    """Receives samples."""

    kind: ClassVar = EndpointKind.SUBSCRIPTION

    def __init__(
        self,
        process: RemoteHost,
        node: RemoteNode,
        message_type: type[Message],
        topic: str,
        qos: QoSProfile,
        *,
        handler: Callable[[Message], None],
        label: str,
    ) -> None:
        self._message_type = message_type
        self._handler = handler
        super().__init__(process, node, message_type, topic, qos, label=label)

    def run(self, call: Call) -> None:
        self._handler(deserialize(call.body, self._message_type))

    @property
    def matched(self) -> int:
        return self.process.ask(AskMatched(self.number)).value if self.alive else 0


class RemoteClient(_Endpoint, ClientHandle):
    """Sends requests to every server of its name and type."""

    kind: ClassVar = EndpointKind.CLIENT

    def __init__(
        self,
        process: RemoteHost,
        node: RemoteNode,
        service_type: type[Service],
        name: str,
        qos: QoSProfile,
        *,
        handler: Callable[[int, Message], None],
        label: str,
    ) -> None:
        self._response_type = service_type.Response
        self._handler = handler
        self._sequence = 0
        super().__init__(process, node, service_type, name, qos, label=label)

    def send_request(self, request: Message) -> int:
        self.check_alive(f"call {self.name}")
        body = serialize(request)
        self._sequence += 1
        self.process.request(Publish(self.number, body))
        return self._sequence

    def server_ready(self) -> bool:
        return self.alive and bool(self.process.ask(AskReady(self.number)).value)

    def run(self, call: Call) -> None:
        (sequence,) = call.numbers
        self._handler(sequence, deserialize(call.body, self._response_type))


class RemoteService(_Endpoint, ServiceHandle):
    """Receives requests."""

    kind: ClassVar = EndpointKind.SERVICE

    def __init__(
        self,
        process: RemoteHost,
        node: RemoteNode,
        service_type: type[Service],
        name: str,
        qos: QoSProfile,
        *,
        handler: Callable[[RequestId, Message], None],
        label: str,
    ) -> None:
        self._request_type = service_type.Request
        self._handler = handler
        self._asking: set[RequestId] = set()
        super().__init__(process, node, service_type, name, qos, label=label)

    def run(self, call: Call) -> None:
        request_id = RequestId(*call.numbers)
        self._asking.add(request_id)
        self._handler(request_id, deserialize(call.body, self._request_type))

    def send_response(self, request_id: RequestId, response: Message) -> None:
        self.check_alive(f"answer on {self.name}")
        body = serialize(response)
        if request_id not in self._asking:
            raise MiddlewareError(f"Service {self.name} has no request {tuple(request_id)} to answer.")
        self._asking.remove(request_id)
        self.process.request(Respond(self.number, *request_id, body))


class RemoteTimer(Timer[RemoteHost]):
    """A timer that computes its due times; its stand-in expires."""

    node: RemoteNode

    def __init__(
        self, process: RemoteHost, node: RemoteNode, period_ns: int, handler: Callable[[], None], label: str
    ) -> None:
        self.number = process.new_number()
        super().__init__(process, node, period_ns, handler, label)

    def join(self) -> None:
        super().join()
        self.process.handlers[self.number] = lambda _: self.run()
        self.process.request(MakeTimer(self.number, self.node.number, _bounded(self._period_ns), self.label))

    def set_alarm(self, due_ns: int | None) -> None:
        """Do nothing: the stand-in has the alarm."""

    def set_period_ns(self, period_ns: int) -> None:
        super().set_period_ns(period_ns)
        if self.number in self.process.handlers:
            self.process.request(SetPeriod(self.number, _bounded(period_ns)))

    def reset(self) -> None:
        super().reset()
        if self.number in self.process.handlers:
            self.process.request(Reset(self.number))

    def cancel(self) -> None:
        super().cancel()
        if self.number in self.process.handlers:
            self.process.request(Cancel(self.number))

    def retire(self) -> None:
        super().retire()
        self.process.handlers.pop(self.number, None)
        self.process.request(Destroy(self.number))


def _bounded(period_ns: int) -> int:
    return min(period_ns, _LONGEST_NS)
