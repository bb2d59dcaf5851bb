"""The nodes, endpoints and timers that represent a remote process on the network."""

import re
from collections.abc import Callable, Mapping
from types import UnionType
from typing import Any, Final

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message, deserialize, get_message, get_service, serialize
from sunset_ros.rmw.core.node import Middleware, NodeHandle, Timer
from sunset_ros.rmw.core.port import (
    ClientHandle,
    EndpointKind,
    Handle,
    PublisherHandle,
    RequestId,
    ServiceHandle,
    SubscriptionHandle,
)
from sunset_ros.rmw.remote._protocol import (
    Answer,
    AskEndpoints,
    AskMatched,
    AskNodes,
    AskReady,
    AskWanted,
    Attach,
    Cancel,
    Defer,
    Destroy,
    MakeEndpoint,
    MakeNode,
    MakeTimer,
    PipeError,
    Post,
    Publish,
    Reset,
    Respond,
    SetPeriod,
    Shutdown,
    Statement,
)
from sunset_ros.texts import shorten

_NAME: Final = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")
_LONGEST_NAME: Final = 256
"""Characters."""
_MOST: Final = 10_000
"""The most nodes, endpoints and timers of a process."""
_BYTES: Final = 2**26
"""The most bytes of messages in a burst, and in a minute."""
_OVERHEAD: Final = 2**11
"""Bytes that each message counts in addition to its own."""


class StandIns:
    """Carries out the statements of a remote process, which are not trusted.

    Args:
        process: the process on the network.
        call: calls a handler of the remote process by its number, with the numbers and bytes of a `Call`.

    Attributes:
        deferred: handlers whose calls may wait.
    """

    def __init__(self, process: Middleware, call: Callable[[int, tuple[int, ...], bytes], None]) -> None:
        self._process = process
        self._call = call
        self.deferred: set[int] = set()
        self._things: dict[int, tuple[object, type[Message] | None]] = {}
        self._last = 0
        self._began_ns = process.now_ns()
        self._sent = 0
        self._changes: Mapping[type, Callable[[Any], None]] = {
            MakeNode: self._make_node,
            MakeEndpoint: self._make_endpoint,
            MakeTimer: self._make_timer,
            Post: self._post,
            Publish: self._publish,
            Respond: self._respond,
            SetPeriod: lambda change: self._get(change.number, Timer).set_period_ns(change.period_ns),
            Reset: lambda change: self._get(change.number, Timer).reset(),
            Cancel: lambda change: self._get(change.number, Timer).cancel(),
            Destroy: self._destroy,
            Attach: self._attach,
            Shutdown: lambda _: process.shutdown(),
            Defer: self._defer,
        }
        self._answers: Mapping[type, Callable[[Any], Answer]] = {
            AskNodes: lambda _: Answer(process.now_ns(), nodes=list(process.nodes())),
            AskEndpoints: self._endpoints,
            AskMatched: self._matched,
            AskWanted: lambda question: self._value(self._get(question.number, PublisherHandle).wanted),
            AskReady: lambda question: self._value(self._get(question.number, ClientHandle).server_ready()),
        }

    def change(self, change: Statement) -> None:
        """Carry out a statement without an answer."""
        make = self._changes.get(type(change))
        if make is None:
            raise PipeError("goes on when it is not its turn any more")
        try:
            make(change)
        except PipeError:
            raise
        except (MiddlewareError, OverflowError) as error:
            raise PipeError(f"asked for what cannot be: {error}") from error

    def answer(self, question: Statement) -> Answer:
        """Answer a question that needs no waiting."""
        answer = self._answers.get(type(question))
        if answer is None:
            raise PipeError("sent no final statement")
        return answer(question)

    def _add(self, number: int, thing: object, kind: type[Message] | None = None) -> None:
        if number <= self._last:
            raise PipeError(f"used number {number} twice")
        if len(self._things) >= _MOST:
            raise PipeError(f"has more than {_MOST} endpoints and timers")
        self._last = number
        self._things[number] = (thing, kind)

    def _get(self, number: int, kind: type | UnionType) -> Any:
        thing, _ = self._things.get(number, (None, None))
        if not isinstance(thing, kind):
            raise PipeError(f"speaks of {number}, which is not such a thing")
        return thing

    def _make_node(self, change: MakeNode) -> None:
        for name in (f"/{change.name}", *([change.namespace] if change.namespace != "/" else [])):
            _check_name(name)
        if "/" in change.name:
            raise PipeError(f"has a node with the name {shorten(change.name)!r}")
        self._add(change.number, self._process.create_node(change.name, change.namespace))

    def _make_endpoint(self, change: MakeEndpoint) -> None:
        node, number, label = self._get(change.node, NodeHandle), change.number, shorten(change.label)
        name, qos = change.name, change.qos
        _check_name(name)
        match change.kind:
            case EndpointKind.PUBLISHER:
                kind = get_message(change.type_name)
                self._add(number, node.create_publisher(kind, name, qos), kind)
            case EndpointKind.SUBSCRIPTION:
                kind = get_message(change.type_name)

                def take(message: Message) -> None:
                    self._call(number, (), serialize(message))

                self._add(number, node.create_subscription(kind, name, qos, take, label=label))
            case EndpointKind.CLIENT:
                service = get_service(change.type_name)

                def take_response(sequence: int, response: Message) -> None:
                    self._call(number, (sequence,), serialize(response))

                client = node.create_client(service, name, qos, take_response, label=label)
                self._add(number, client, service.Request)
            case EndpointKind.SERVICE:
                service = get_service(change.type_name)

                def take_request(request_id: RequestId, request: Message) -> None:
                    self._call(number, request_id, serialize(request))

                self._add(
                    number,
                    node.create_service(service, name, qos, take_request, label=label),
                    service.Response,
                )

    def _make_timer(self, change: MakeTimer) -> None:
        node, number = self._get(change.node, NodeHandle), change.number
        label = shorten(change.label)
        self._add(number, node.create_timer(change.period_ns, lambda: self._call(number, (), b""), label))

    def _post(self, change: Post) -> None:
        node = self._get(change.node, NodeHandle)
        node.post(lambda: self._call(change.number, (), b""), shorten(change.label))

    def _publish(self, change: Publish) -> None:
        message = self._read(change.number, change.body)
        sender = self._get(change.number, PublisherHandle | ClientHandle)
        if isinstance(sender, ClientHandle):
            sender.send_request(message)
        else:
            sender.publish(message)

    def _respond(self, change: Respond) -> None:
        response = self._read(change.number, change.body)
        request_id = RequestId(change.client, change.sequence)
        self._get(change.number, ServiceHandle).send_response(request_id, response)

    def _read(self, number: int, body: bytes) -> Message:
        _, kind = self._things.get(number, (None, None))
        if kind is None:
            raise PipeError(f"speaks of {number}, which sends nothing")
        self._sent += len(body) + _OVERHEAD
        if self._sent > _BYTES * (1 + (self._process.now_ns() - self._began_ns) / 60e9):
            raise PipeError(
                f"sends more than {_BYTES >> 20} MiB, or {_BYTES // _OVERHEAD} messages, in a minute"
            )
        return deserialize(body, kind)

    def _destroy(self, change: Destroy) -> None:
        self._get(change.number, (NodeHandle | Handle | Timer)).destroy()
        del self._things[change.number]
        self.deferred.discard(change.number)

    def _defer(self, change: Defer) -> None:
        self._get(change.number, SubscriptionHandle)
        self.deferred.add(change.number)

    def _attach(self, change: Attach) -> None:
        node = self._get(change.number, NodeHandle)
        if change.attached:
            node.attach()
        else:
            node.detach()

    def _value(self, value: int) -> Answer:
        return Answer(self._process.now_ns(), value)

    def _endpoints(self, question: AskEndpoints) -> Answer:
        return Answer(self._process.now_ns(), endpoints=list(self._process.endpoints(question.name)))

    def _matched(self, question: AskMatched) -> Answer:
        return self._value(self._get(question.number, (PublisherHandle | SubscriptionHandle)).matched)


def _check_name(name: str) -> None:
    if len(name) > _LONGEST_NAME or not _NAME.fullmatch(name):
        raise PipeError(f"has something with the name {shorten(name, _LONGEST_NAME)!r}")
