"""The remote process, and the parts of its nodes, each of which sends changes to its stand-in on the network."""

import threading
from collections.abc import Callable, Sequence
from functools import partial
from itertools import count
from typing import Final, Literal

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message, deserialize, serialize, type_name
from sunset_ros.rmw.core.node import (
    ClientHandle,
    Endpoint,
    Entity,
    Middleware,
    NodeHandle,
    Parts,
    PublisherHandle,
    ServiceHandle,
    SubscriptionHandle,
    Timer,
)
from sunset_ros.rmw.core.port import EndpointInfo, RequestId
from sunset_ros.rmw.remote._protocol import (
    Act,
    Answer,
    Ask,
    Call,
    Change,
    Done,
    EndError,
    MakeEndpoint,
    MakeNode,
    MakeTimer,
    Pipe,
    Question,
    Raised,
    Statement,
    Wait,
    decode_orders,
    encode,
)

_LONGEST_NS: Final = 1 << 62
"""A period of 146 years; the protocol's numbers have 64 bits."""


class RemoteNode(NodeHandle):
    """A node with its number in the protocol."""

    process: "RemoteProcess"
    number: int

    def attach(self) -> None:
        super().attach()
        self.process.request(Act(self.number, "attach"))

    def detach(self) -> None:
        super().detach()
        self.process.request(Act(self.number, "detach"))


class _RemotePart(Entity):
    """A part with its number in the protocol."""

    process: "RemoteProcess"
    node: RemoteNode
    number = -1

    def request(self, act: Act) -> None:
        """Let the stand-in do something, if it exists."""
        if self.number in self.process.handlers:
            self.process.request(act)

    def retire(self) -> None:
        super().retire()
        self.request(Act(self.number, "destroy"))
        self.process.handlers.pop(self.number, None)


class _RemoteEndpoint(_RemotePart, Endpoint):
    """An endpoint, whose handler gets the messages of calls."""

    def open(self) -> None:
        super().open()
        self.number = self.process.new_number(self.run)
        ros_type = type_name(self.ros_type)
        self.process.request(
            MakeEndpoint(self.number, self.node.number, self.kind, ros_type, self.name, self.qos, self.label)
        )

    def ask(self, about: Literal["matched", "wanted", "server_ready"]) -> int:
        """Return a property of the stand-in; 0 if it is destroyed."""
        return self.process.ask(Ask(self.number, about)).value if self.alive else 0

    def run(self, call: Call) -> None:
        """Call the handler with the message of a call."""
        self.handler(*call.ids, deserialize(call.body, self.received))


class RemotePublisher(_RemoteEndpoint, PublisherHandle):
    """Sends samples, and checks them."""

    def publish(self, message: Message) -> None:
        self.check_alive(f"publish on {self.name}")
        self.request(Act(self.number, "publish", body=serialize(message)))

    @property
    def wanted(self) -> bool:
        return bool(self.ask("wanted"))

    @property
    def matched(self) -> int:
        return self.ask("matched")


class RemoteSubscription(_RemoteEndpoint, SubscriptionHandle):
    """Receives samples."""

    @property
    def matched(self) -> int:
        return self.ask("matched")


class RemoteClient(_RemoteEndpoint, ClientHandle):
    """Sends requests to every server of its name and type."""

    def send(self, number: int, request: Message, payload: bytes) -> None:
        del number, request  # the stand-in counts, too
        self.request(Act(self.number, "send_request", body=payload))

    def server_ready(self) -> bool:
        return bool(self.ask("server_ready"))


class RemoteService(_RemoteEndpoint, ServiceHandle):
    """Receives requests."""

    def run(self, call: Call) -> None:
        (request_id,) = call.ids
        assert isinstance(request_id, RequestId)  # noqa: S101  of a service
        self.asked[request_id] = partial(self._respond, request_id)
        super().run(call)

    def _respond(self, request_id: RequestId, response: Message, payload: bytes) -> None:
        del response
        self.request(Act(self.number, "send_response", request_id, payload))


class RemoteTimer(_RemotePart, Timer):
    """A timer that computes its due times; its stand-in expires."""

    def join(self) -> None:
        super().join()
        self.number = self.process.new_number(lambda _: self.run())
        period_ns = min(self._period_ns, _LONGEST_NS)
        self.process.request(MakeTimer(self.number, self.node.number, period_ns, self.label))

    def set_alarm(self, due_ns: int | None) -> None:
        """Do nothing: the stand-in has the alarm."""

    def set_period_ns(self, period_ns: int) -> None:
        super().set_period_ns(period_ns)
        self.request(Act(self.number, "set_period_ns", min(period_ns, _LONGEST_NS)))

    def reset(self) -> None:
        super().reset()
        self.request(Act(self.number, "reset"))

    def cancel(self) -> None:
        super().cancel()
        self.request(Act(self.number, "cancel"))


class RemoteProcess(Middleware):
    """A process outside of its simulation, or network.

    `main` and the callbacks run when the gateway calls them. A simulation's time stands still meanwhile.

    Args:
        pipe: the connection to the gateway.
        main: makes the nodes.
        describe: describes an exception of `main` or a callback as the end of a sentence.

    Attributes:
        handlers: handlers that the gateway calls, by number.
    """

    parts = Parts(RemotePublisher, RemoteSubscription, RemoteClient, RemoteService, RemoteTimer)

    def __init__(
        self,
        pipe: Pipe,
        main: "Callable[[RemoteProcess], None]",
        describe: Callable[[BaseException], str] = lambda error: f"raised {type(error).__name__}: {error}",
    ) -> None:
        self.handlers: dict[int, Callable[[Call], object]] = {0: lambda _: main(self)}
        self._pipe = pipe
        self._describe = describe
        self._statements: list[Statement] = []
        self._numbers = count(1)
        self._nodes: dict[NodeHandle, None] = {}
        self._thread = threading.get_ident()
        self._now = 0
        self._in_callback = False

    def serve(self) -> None:
        """Carry out the gateway's orders until it closes its end of the pipe."""
        try:
            while True:
                self._obey(self._receive()[0])
        except EndError:
            return

    def _obey(self, calls: Sequence[Call]) -> None:
        """Carry out calls, and send the outcome of the last."""
        outcome: Statement = Done()
        try:
            for call in calls:
                outcome = Done(self._call(call))
        except EndError:
            raise
        except BaseException as error:  # noqa: BLE001  the gateway gets it
            outcome = Raised(self._describe(error))
        self._send(outcome)

    def _call(self, call: Call) -> bool:
        self._now = call.now_ns
        outer, self._in_callback = self._in_callback, call.handler != 0
        try:
            handler = self.handlers.get(call.handler)
            return handler is not None and bool(handler(call))  # None if it was destroyed meanwhile
        finally:
            self._in_callback = outer
            if self._ending and not outer:
                self._end()

    def _send(self, last: Statement) -> None:
        statements, self._statements = self._statements, []
        self._pipe.send(encode([*statements, last]))

    def _receive(self) -> tuple[list[Call], Answer | None]:
        """Return calls, and the answer to a question if that comes after them."""
        orders = decode_orders(self._pipe.receive())
        calls = [order for order in orders if isinstance(order, Call)]
        last = orders[-1]
        return calls, last if isinstance(last, Answer) else None

    # For its parts

    def new_number(self, handler: Callable[[Call], object]) -> int:
        """Return a new number of a handler."""
        number = next(self._numbers)
        self.handlers[number] = handler
        return number

    def request(self, change: Change) -> None:
        """Send a change to the gateway, at the latest with the next turn."""
        if self._alive:
            self._statements.append(change)

    def ask(self, question: Question) -> Answer:
        """Return the gateway's answer to a question."""
        if threading.get_ident() != self._thread:
            raise MiddlewareError("Only the thread that runs the callbacks may ask the simulation something.")
        self._send(question)
        calls, answer = self._receive()
        while answer is None:
            self._obey(calls)
            calls, answer = self._receive()
        for call in calls:
            self._call(call)
        self._now = answer.now_ns
        if answer.error:
            raise MiddlewareError(answer.error)
        return answer

    def defer(self, subscription: SubscriptionHandle) -> None:
        """Delay calls of a subscription's handler until the next other call: it must only store the messages."""
        assert isinstance(subscription, RemoteSubscription)  # noqa: S101  made here
        self.request(Act(subscription.number, "defer"))

    # The port

    def now_ns(self) -> int:
        """The time of the network; constant during a callback."""
        return self._now

    steady_ns = now_ns

    def create_node(self, name: str, namespace: str) -> NodeHandle:
        node = RemoteNode(self, name, namespace)
        node.number = next(self._numbers)
        self._nodes[node] = None
        self.request(MakeNode(node.number, name, namespace))
        return node

    def post(self, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        assert isinstance(node, RemoteNode)  # noqa: S101  made here
        node.check_alive()

        def run(_: Call) -> None:
            del self.handlers[number]
            handler()

        number = self.new_number(run)
        self.request(MakeTimer(number, node.number, None, label))

    def remove(self, node: NodeHandle) -> None:
        assert isinstance(node, RemoteNode)  # noqa: S101  made here
        if node in self._nodes:
            del self._nodes[node]
            self.request(Act(node.number, "destroy"))

    def spin_once(self, timeout_ns: int | None) -> bool:
        """Let the whole world go on until a callback of this process has run."""
        self.check_alive()
        return bool(self.ask(Wait(None, timeout_ns)).value)

    def wait_for(self, predicate: Callable[[], bool], timeout_ns: int | None) -> bool:
        if self._in_callback:
            return predicate()
        number = self.new_number(lambda _: predicate())
        try:
            return bool(self.ask(Wait(number, timeout_ns)).value)
        finally:
            del self.handlers[number]

    def shutdown(self) -> None:
        if not self.alive:
            return
        self.request(Act(0, "shutdown"))
        self._ending = True
        if not self._in_callback:
            self._end()

    def _end(self) -> None:
        """Mark the process as ended and destroy its nodes, as the simulation has done."""
        self._alive = False
        for node in list(self._nodes):
            node.destroy()

    def nodes(self) -> Sequence[tuple[str, str]]:
        return self.ask(Ask(0, "nodes")).nodes

    def endpoints(self, name: str | None = None) -> Sequence[EndpointInfo]:
        return self.ask(Ask(0, "endpoints", name)).endpoints
