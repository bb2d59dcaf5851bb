"""The representative of a process behind a pipe, which takes turns with it."""

import time
from collections.abc import Callable
from functools import partial
from typing import Final

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message, deserialize, get_message, get_service, serialize
from sunset_ros.rmw.core.node import Endpoint, Middleware, NodeHandle
from sunset_ros.rmw.core.port import CallbackError, EndpointKind, RequestId
from sunset_ros.rmw.remote._protocol import (
    Act,
    Answer,
    Ask,
    Call,
    Done,
    MakeEndpoint,
    MakeNode,
    MakeTimer,
    Pipe,
    PipeError,
    Raised,
    RaisedError,
    Statement,
    Wait,
    encode,
    read_statements,
)
from sunset_ros.texts import shorten

_DEEPEST: Final = 20
"""The most turns within turns: a predicate of a waiting process may wait, too."""
_BYTES: Final = 2**26
"""The most bytes of messages in a burst, and in a minute."""
_OVERHEAD: Final = 2**11
"""Bytes that each message counts in addition to its own."""


class Gateway:
    """Represents a remote process by nodes, endpoints and timers of a process on the network, simulated or live.

    When one of their handlers is called, the remote process runs its own, and the network's process waits. A remote
    process that raises, does not answer in time or violates the protocol has failed: its representative ends, and the
    network goes on.

    Args:
        process: the process on the network.
        pipe: the connection to the remote process.
        limit_s: seconds of wall time that a callback may take.
        longest_ns: the longest wait in a callback, in the network's time; None for no limit.
        end: ends the process on the network after a failure.
        on_failure: called with the failure.

    Attributes:
        failure: the failure, whose text is the end of a sentence; None before.
    """

    def __init__(
        self,
        process: Middleware,
        pipe: Pipe,
        *,
        limit_s: float,
        longest_ns: int | None = None,
        end: Callable[[], object],
        on_failure: Callable[[PipeError], object] = lambda _: None,
    ) -> None:
        self.failure: PipeError | None = None
        self._end = end
        self._on_failure = on_failure
        self._process = process
        self._pipe = pipe
        self._limit_s = limit_s
        self._left_s = limit_s
        self._longest_ns = longest_ns
        self._began_ns = process.now_ns()
        self._depth = 0
        self._held: list[Call | Answer] = []
        self._deferred: set[int] = set()
        self._things: dict[int, object] = {0: process}
        self._first_ns = process.now_ns()
        self._sent = 0

    def start(self) -> None:
        """Let the remote process make its nodes."""
        self._call(0)

    def _call(self, handler: int, *received: Message | RequestId | int) -> None:
        """Call a handler of the remote process with a message, after the id of a request or response, or nothing."""
        body = b"".join(serialize(each) for each in received if isinstance(each, Message))
        ids = tuple(each for each in received if not isinstance(each, Message))
        call = Call(handler, self._process.now_ns(), ids, body)
        if handler in self._deferred:
            self._held.append(call)
        else:
            self._turn(call)

    def _turn(self, order: Call | Answer) -> bool:
        """Give the remote process its turn until it is done; return the value of a predicate, True after a failure."""
        if self._depth == 0:
            self._left_s = self._limit_s
            self._began_ns = self._process.now_ns()
        self._depth += 1
        try:
            while self.failure is None:
                last = self._exchange(order)
                if isinstance(last, Done):
                    return last.value
                if isinstance(last, Raised):
                    raise RaisedError(last.reason)
                order = self._answer(last)
        except PipeError as error:
            self.failure = error
            self._end()
            self._on_failure(error)
        finally:
            self._depth -= 1
        return True

    def _exchange(self, order: Call | Answer) -> Statement:
        """Send an order after the held calls, carry out the answer's changes, and return its last statement."""
        if self._depth > _DEEPEST:
            raise PipeError("waits for itself")
        if self._longest_ns is not None and self._process.now_ns() - self._began_ns >= self._longest_ns:
            raise PipeError(f"waits for more than {self._longest_ns / 1e9:g} s in a callback")
        start_s = time.monotonic()
        end_s = start_s + self._left_s
        orders, self._held = [*self._held, order], []
        self._pipe.send(encode(orders), end_s)
        statements = read_statements(self._pipe.receive(end_s))
        self._left_s -= time.monotonic() - start_s
        if not statements:
            raise PipeError("says nothing")
        for change in statements[:-1]:
            self._change(change)
        return statements[-1]

    def _answer(self, question: Statement) -> Answer:
        process = self._process
        try:
            if not isinstance(question, Wait):
                return self._look_up(question)
            timeout_ns = self._bounded(question.timeout_ns)
            handler = question.handler
            if handler is None:
                value = process.spin_once(timeout_ns)
            else:
                value = process.wait_for(lambda: self._turn(Call(handler, process.now_ns())), timeout_ns)
            return Answer(process.now_ns(), value=value)
        except (CallbackError, PipeError):  # a callback of another process
            raise
        except MiddlewareError as error:
            return Answer(process.now_ns(), error=str(error))

    def _bounded(self, timeout_ns: int | None) -> int | None:
        """Return a timeout of at most the longest wait."""
        return min((limit for limit in (timeout_ns, self._longest_ns) if limit is not None), default=None)

    # Statements, which are not trusted

    def _change(self, change: Statement) -> None:
        """Carry out a statement without an answer."""
        try:
            if isinstance(change, MakeNode):
                self._things[change.number] = self._process.create_node(change.name, change.namespace)
            elif isinstance(change, MakeEndpoint):
                self._things[change.number] = self._endpoint(change)
            elif isinstance(change, MakeTimer):
                self._make_timer(change)
            else:
                self._act(change)
        except PipeError:
            raise
        except (AttributeError, MiddlewareError, OverflowError, TypeError) as error:
            raise PipeError(f"asked for what cannot be: {error}") from error

    def _node(self, number: int) -> NodeHandle:
        node = self._things.get(number)
        if not isinstance(node, NodeHandle):
            raise PipeError(f"speaks of {number}, which is not a node")
        return node

    def _endpoint(self, change: MakeEndpoint) -> Endpoint:
        is_topic = change.kind in {EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION}
        ros_type = get_message(change.type_name) if is_topic else get_service(change.type_name)
        part: type[Endpoint] = getattr(self._process.parts, change.kind.value)
        node, handler = self._node(change.node), partial(self._call, change.number)
        return part(node, ros_type, change.name, change.qos, handler=handler, label=shorten(change.label))

    def _make_timer(self, change: MakeTimer) -> None:
        node, handler = self._node(change.node), partial(self._call, change.number)
        if change.period_ns is None:
            node.post(handler, shorten(change.label))
        else:
            self._things[change.number] = node.create_timer(change.period_ns, handler, shorten(change.label))

    def _act(self, act: Statement) -> None:
        if not isinstance(act, Act):
            raise PipeError("goes on when it is not its turn any more")
        thing = self._things.get(act.number)
        if act.verb == "defer":
            self._deferred.add(act.number)
            return
        method = getattr(thing, act.verb, None)
        if method is None:
            raise PipeError(f"speaks of {act.number}, which cannot {act.verb}")
        arguments: list[object] = [] if act.argument is None else [act.argument]
        if act.body is not None:
            arguments.append(self._message(thing, act.body))
        method(*arguments)
        if act.verb == "destroy":
            del self._things[act.number]
            self._deferred.discard(act.number)

    def _message(self, sender: object, body: bytes) -> Message:
        self._sent += len(body) + _OVERHEAD
        if self._sent > _BYTES * (1 + (self._process.now_ns() - self._first_ns) / 60e9):
            raise PipeError(
                f"sends more than {_BYTES >> 20} MiB, or {_BYTES // _OVERHEAD} messages, in a minute"
            )
        if not isinstance(sender, Endpoint):
            raise PipeError("sends a message from a part that sends none")
        return deserialize(body, sender.sent)

    def _look_up(self, question: Statement) -> Answer:
        if not isinstance(question, Ask):
            raise PipeError("sent no final statement")
        now_ns = self._process.now_ns()
        if question.about == "nodes":
            return Answer(now_ns, nodes=list(self._process.nodes()))
        if question.about == "endpoints":
            return Answer(now_ns, endpoints=list(self._process.endpoints(question.name)))
        value = getattr(self._things.get(question.number), question.about, None)
        if value is None:
            raise PipeError(f"speaks of {question.number}, which has no {question.about}")
        return Answer(now_ns, value=value() if callable(value) else value)
