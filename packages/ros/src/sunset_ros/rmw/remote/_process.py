"""The remote process."""

import os
import threading
from collections.abc import Callable, Sequence
from functools import partial
from itertools import count
from typing import Final

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.core.node import NodeHandle, Parts
from sunset_ros.rmw.core.port import CallbackError, EndpointInfo, SubscriptionHandle
from sunset_ros.rmw.remote._entity import (
    RemoteClient,
    RemoteHost,
    RemoteNode,
    RemotePublisher,
    RemoteService,
    RemoteSubscription,
    RemoteTimer,
)
from sunset_ros.rmw.remote._protocol import (
    LONGEST,
    Answer,
    AskEndpoints,
    AskNodes,
    Call,
    Change,
    Check,
    Defer,
    Destroy,
    Done,
    EndError,
    MakeNode,
    Order,
    Pipe,
    Post,
    Publish,
    Question,
    Raised,
    Respond,
    Shutdown,
    Spin,
    Statement,
    Wait,
    decode_orders,
    encode,
)

_MOST: Final = LONGEST // 4
"""The most bytes of a message, and of all but the last message in a frame."""


def describe_error(error: BaseException) -> str:
    """Describe an exception as the end of a sentence."""
    return f"raised {type(error).__name__}: {error}"


class RemoteProcess(RemoteHost):
    """A process outside of its simulation, or network.

    `main` and the callbacks run when the gateway calls them. A simulation's time stands still meanwhile.

    Args:
        pipe: the connection to the gateway.
        main: makes the nodes.
        describe: describes an exception of `main` or a callback as the end of a sentence.
    """

    def __init__(
        self,
        pipe: Pipe,
        main: "Callable[[RemoteProcess], None]",
        describe: Callable[[BaseException], str] = describe_error,
    ) -> None:
        self.handlers = {0: lambda _: main(self)}
        self._pipe = pipe
        self._describe = describe
        self._statements: list[Statement] = []
        self._size = 0
        self._numbers = count(1)
        self._nodes: dict[NodeHandle, None] = {}
        self._thread = threading.get_ident()
        self._now = 0
        self._alive = True
        self._ending = False
        self._in_callback = False
        self._raised: BaseException | None = None
        self._process = os.getpid()
        self._predicates: list[Callable[[], bool]] = []
        self._parts = Parts(
            publisher=partial(RemotePublisher, self),
            subscription=partial(RemoteSubscription, self),
            client=partial(RemoteClient, self),
            service=partial(RemoteService, self),
            timer=partial(RemoteTimer, self),
        )

    def serve(self) -> None:
        """Carry out the gateway's orders until it closes its end of the pipe."""
        try:
            while True:
                self._obey(decode_orders(self._pipe.receive()))
        except EndError:
            return

    def _obey(self, orders: Sequence[Order]) -> None:
        """Carry out orders, and send the outcome."""
        outcome: Statement = Done()
        try:
            for order in orders:
                outcome = Done(self._carry_out(order))
        except EndError:
            raise
        except BaseException as error:  # noqa: BLE001  the gateway gets it
            self._raised = error
            outcome = Raised(self._describe(error))
        self._send(outcome)

    def _carry_out(self, order: Order) -> bool:
        """Carry out an order; return the value of the predicate if the order is a `Check`."""
        self._now = order.now_ns
        if isinstance(order, Call):
            self._call(order)
        return isinstance(order, Check) and bool(self._predicates[-1]())

    def _call(self, order: Call) -> None:
        outer, self._in_callback = self._in_callback, order.handler != 0
        try:
            handler = self.handlers.get(order.handler)
            if handler is not None:  # else it was destroyed meanwhile
                handler(order)
        finally:
            self._in_callback = outer
            if self._ending and not outer:
                self._end()

    def _send(self, last: Statement) -> None:
        if os.getpid() != self._process:  # a fork that a callback has made
            os._exit(0)
        statements, self._statements, self._size = self._statements, [], 0
        statements.append(last)
        self._pipe.send(encode(statements))

    # For its parts

    def new_number(self) -> int:
        return next(self._numbers)

    def request(self, change: Change) -> None:
        if not self._alive:
            return
        if isinstance(change, Publish | Respond):
            if len(change.body) > _MOST:
                raise MiddlewareError(
                    f"A message must be at most {_MOST} bytes long, got {len(change.body)}."
                )
            self._size += len(change.body)
        self._statements.append(change)
        if self._size > _MOST:  # more does not fit into a frame
            self.ask(AskNodes())

    def ask(self, question: Question) -> Answer:
        if threading.get_ident() != self._thread:
            raise MiddlewareError("Only the thread that runs the callbacks may ask the simulation something.")
        self._send(question)
        while True:
            *waited, order = orders = decode_orders(self._pipe.receive())
            if isinstance(order, Answer):
                break
            self._obey(orders)
        for call in waited:
            self._carry_out(call)
        self._now = order.now_ns
        if order.raised and self._raised is not None:
            if isinstance(self._raised, CallbackError) or not isinstance(self._raised, Exception):
                raise self._raised
            raise CallbackError.of(*order.raised, self._raised) from self._raised
        if order.error:
            raise MiddlewareError(order.error)
        return order

    def defer(self, subscription: SubscriptionHandle) -> None:
        """Delay calls of a subscription's handler until the next other call: it must only store the messages."""
        assert isinstance(subscription, RemoteSubscription)  # noqa: S101  made here
        self.request(Defer(subscription.number))

    # The port

    def now_ns(self) -> int:
        """The time of the network; constant during a callback."""
        return self._now

    steady_ns = now_ns

    def create_node(self, name: str, namespace: str) -> NodeHandle:
        node = RemoteNode(self, self._parts, name, namespace)
        node.number = self.new_number()
        self._nodes[node] = None
        self.request(MakeNode(node.number, name, namespace))
        return node

    def post(self, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        assert isinstance(node, RemoteNode)  # noqa: S101  made here
        node.check_alive()
        number = self.new_number()

        def run(_: Call) -> None:
            del self.handlers[number]
            handler()

        self.handlers[number] = run
        self.request(Post(number, node.number, label))

    def remove(self, node: NodeHandle) -> None:
        assert isinstance(node, RemoteNode)  # noqa: S101  made here
        if node in self._nodes:
            del self._nodes[node]
            self.request(Destroy(node.number))

    def spin_once(self, timeout_ns: int | None) -> bool:
        """Let the whole world go on until a callback of this process has run."""
        self.check_alive()
        return bool(self.ask(Spin(timeout_ns)).value)

    def wait_for(self, predicate: Callable[[], bool], timeout_ns: int | None) -> bool:
        if self._in_callback:
            return predicate()
        self._predicates.append(predicate)
        try:
            return bool(self.ask(Wait(timeout_ns)).value)
        finally:
            self._predicates.pop()

    def wake(self) -> None:
        """Do nothing: while `spin_once` runs, nothing else does."""

    @property
    def alive(self) -> bool:
        return self._alive and not self._ending

    def check_alive(self) -> None:
        if not self._alive:
            raise MiddlewareError("The process has ended.")

    def shutdown(self) -> None:
        if not self.alive:
            return
        self.request(Shutdown())
        self._ending = True
        if not self._in_callback:
            self._end()

    def _end(self) -> None:
        """Mark the process as ended and destroy its nodes, as the simulation has done."""
        self._alive = False
        for node in list(self._nodes):
            node.destroy()

    def nodes(self) -> Sequence[tuple[str, str]]:
        return self.ask(AskNodes()).nodes

    def endpoints(self, name: str | None = None) -> Sequence[EndpointInfo]:
        return self.ask(AskEndpoints(name)).endpoints
