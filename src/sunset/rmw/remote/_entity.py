"""What nodes of another process consist of: each part tells the one that stands for it in the simulation what to do."""

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

from sunset.common.errors import MiddlewareError
from sunset.interfaces import Message, Service, deserialize, serialize, type_name
from sunset.rmw.core.node import Entity, Middleware, NodeHandle, Timer
from sunset.rmw.core.port import (
    ClientHandle,
    EndpointKind,
    PublisherHandle,
    RequestId,
    ServiceHandle,
    SubscriptionHandle,
)
from sunset.rmw.core.qos import QoSProfile
from sunset.rmw.remote._protocol import (
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
    """The process, as its parts need it.

    Attributes:
        handlers: what the simulation may call, by number.
    """

    handlers: dict[int, Callable[[Call], None]]

    @abstractmethod
    def new_number(self) -> int:
        """Return a number that nothing else of this process has or had."""

    @abstractmethod
    def tell(self, change: Change) -> None:
        """Tell the simulation what to do, at the latest when it is its turn."""

    @abstractmethod
    def ask(self, question: Question) -> Answer:
        """Ask the simulation.

        Raises:
            MiddlewareError: there is no answer.
        """


class RemoteNode(NodeHandle):
    """A node.

    Attributes:
        number: its number.
    """

    process: RemoteHost
    number: int

    def attach(self) -> None:
        super().attach()
        self.process.tell(Attach(self.number, True))

    def detach(self) -> None:
        super().detach()
        self.process.tell(Attach(self.number, False))


class _Endpoint(Entity[RemoteHost]):
    """An endpoint, with what the simulation calls for it."""

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
        process.tell(MakeEndpoint(self.number, node.number, self.kind, type_name(ros_type), name, qos, label))
        process.handlers[self.number] = self.run
        self.join()

    def run(self, call: Call) -> None:
        """Call the handler with what has come."""

    def retire(self) -> None:
        super().retire()
        self.process.handlers.pop(self.number, None)
        self.process.tell(Destroy(self.number))


class RemotePublisher(_Endpoint, PublisherHandle):
    """Sends samples, which it checks."""

    kind: ClassVar = EndpointKind.PUBLISHER

    def __init__(
        self, process: RemoteHost, node: RemoteNode, message_type: type[Message], topic: str, qos: QoSProfile
    ) -> None:
        super().__init__(process, node, message_type, topic, qos, label=f"publisher of {topic}")

    def publish(self, message: Message) -> None:
        self.check_alive(f"publish on {self.name}")
        self.process.tell(Publish(self.number, serialize(message)))

    @property
    def wanted(self) -> bool:
        return self.alive and bool(self.process.ask(AskWanted(self.number)).value)

    @property
    def matched(self) -> int:
        return self.process.ask(AskMatched(self.number)).value if self.alive else 0


class RemoteSubscription(_Endpoint, SubscriptionHandle):
    """Gets samples."""

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
    """Asks every server of its name and type."""

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
        self.process.tell(Publish(self.number, body))
        return self._sequence

    def server_ready(self) -> bool:
        return self.alive and bool(self.process.ask(AskReady(self.number)).value)

    def run(self, call: Call) -> None:
        (sequence,) = call.numbers
        self._handler(sequence, deserialize(call.body, self._response_type))


class RemoteService(_Endpoint, ServiceHandle):
    """Gets requests."""

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
        self.process.tell(Respond(self.number, *request_id, body))


class RemoteTimer(Timer[RemoteHost]):
    """A timer that knows when it is due; the one in the simulation expires."""

    node: RemoteNode

    def __init__(
        self, process: RemoteHost, node: RemoteNode, period_ns: int, handler: Callable[[], None], label: str
    ) -> None:
        self.number = process.new_number()
        super().__init__(process, node, period_ns, handler, label)

    def join(self) -> None:
        super().join()
        self.process.handlers[self.number] = lambda _: self.run()
        self.process.tell(MakeTimer(self.number, self.node.number, _bounded(self._period_ns), self.label))

    def set_alarm(self, due_ns: int | None) -> None:
        """Do nothing: the simulation does."""

    def set_period_ns(self, period_ns: int) -> None:
        super().set_period_ns(period_ns)
        if self.number in self.process.handlers:
            self.process.tell(SetPeriod(self.number, _bounded(period_ns)))

    def reset(self) -> None:
        super().reset()
        if self.number in self.process.handlers:
            self.process.tell(Reset(self.number))

    def cancel(self) -> None:
        super().cancel()
        if self.number in self.process.handlers:
            self.process.tell(Cancel(self.number))

    def retire(self) -> None:
        super().retire()
        self.process.handlers.pop(self.number, None)
        self.process.tell(Destroy(self.number))


def _bounded(period_ns: int) -> int:
    return min(period_ns, _LONGEST_NS)
