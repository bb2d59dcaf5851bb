"""The process behind the pipe: the managing side."""

import os
import threading
from collections.abc import Callable, Sequence
from functools import partial
from itertools import count
from typing import Final

from sunset.common.errors import MiddlewareError
from sunset.rmw.core.node import NodeHandle, Parts
from sunset.rmw.core.port import CallbackError, EndpointInfo, SubscriptionHandle
from sunset.rmw.remote._entity import (
    RemoteClient,
    RemoteHost,
    RemoteNode,
    RemotePublisher,
    RemoteService,
    RemoteSubscription,
    RemoteTimer,
)
from sunset.rmw.remote._protocol import (
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
    read_orders,
    write_statements,
)

_MOST: Final = LONGEST // 4
"""Bytes of a message, and of those that are sent in one frame before the last of them."""


def describe_error(error: BaseException) -> str:
    """Return what was raised, as the end of a sentence."""
    return f"raised {type(error).__name__}: {error}"


class RemoteProcess(RemoteHost):
    """A process of a simulation that goes on elsewhere.

    Its nodes are made by `main`, and its callbacks run, when the simulation says so; until they return, its time stands
    still.

    Args:
        pipe: what it talks to the simulation through.
        main: makes the nodes.
        describe: says what a callback or `main` has raised, as the end of a sentence.
        describes_types: whether its nodes tell others what their types are made of; in a simulation all know.
    """

    def __init__(
        self,
        pipe: Pipe,
        main: "Callable[[RemoteProcess], None]",
        describe: Callable[[BaseException], str] = describe_error,
        *,
        describes_types: bool = False,
    ) -> None:
        self.handlers = {0: lambda _: main(self)}
        self._pipe = pipe
        self._describe = describe
        self._describes_types = describes_types
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
        """Do what the simulation says, until it closes its end of the pipe."""
        try:
            while True:
                self._obey(read_orders(self._pipe.receive()))
        except EndError:
            return

    def _obey(self, orders: Sequence[Order]) -> None:
        """Do what the simulation says, and tell it how that went."""
        outcome: Statement = Done()
        try:
            for order in orders:
                outcome = Done(self._carry_out(order))
        except EndError:
            raise
        except BaseException as error:  # noqa: BLE001  the simulation is told
            self._raised = error
            outcome = Raised(self._describe(error))
        self._send(outcome)

    def _carry_out(self, order: Order) -> bool:
        """Do what an order says; return the value of the predicate that it asks for, if it does."""
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
        if os.getpid() != self._process:  # a callback has forked this one, which has nothing to say
            os._exit(0)
        statements, self._statements, self._size = self._statements, [], 0
        statements.append(last)
        self._pipe.send(write_statements(statements))

    # What its parts need

    def new_number(self) -> int:
        return next(self._numbers)

    def tell(self, change: Change) -> None:
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
            *waited, order = orders = read_orders(self._pipe.receive())
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
        """Let a subscription's handler be called no earlier than the next of others: it must only take notes."""
        assert isinstance(subscription, RemoteSubscription)  # noqa: S101  it made it
        self.tell(Defer(subscription.number))

    # The port

    @property
    def describes_types(self) -> bool:
        return self._describes_types

    def now_ns(self) -> int:
        """Virtual time: nanoseconds since the simulation began; constant during a callback."""
        return self._now

    steady_ns = now_ns

    def create_node(self, name: str, namespace: str) -> NodeHandle:
        node = RemoteNode(self, self._parts, name, namespace)
        node.number = self.new_number()
        self._nodes[node] = None
        self.tell(MakeNode(node.number, name, namespace))
        return node

    def post(self, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        assert isinstance(node, RemoteNode)  # noqa: S101  it made it
        node.check_alive()
        number = self.new_number()

        def run(_: Call) -> None:
            del self.handlers[number]
            handler()

        self.handlers[number] = run
        self.tell(Post(number, node.number, label))

    def remove(self, node: NodeHandle) -> None:
        assert isinstance(node, RemoteNode)  # noqa: S101  it made it
        if node in self._nodes:
            del self._nodes[node]
            self.tell(Destroy(node.number))

    def spin_once(self, timeout_ns: int | None) -> bool:
        """Let the whole world go on until a callback of this process has run.

        Raises:
            CallbackError: it raised.
            MiddlewareError: called from inside a callback, or nothing is left to happen and no timeout is set.
        """
        self.check_alive()
        return bool(self.ask(Spin(timeout_ns)).value)

    def wait_for(self, predicate: Callable[[], bool], timeout_ns: int | None) -> bool:
        """Let the world go on until a predicate holds; from inside a callback, only look.

        Raises:
            MiddlewareError: nothing is left to happen and no timeout is set.
        """
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
        self.tell(Shutdown())
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
        return [
            EndpointInfo(
                kind=one.kind,
                name=one.name,
                type_name=one.type_name,
                node_name=one.node_name,
                node_namespace=one.node_namespace,
                qos=one.qos,
                gid=one.gid,
            )
            for one in self.ask(AskEndpoints(name)).endpoints
        ]
