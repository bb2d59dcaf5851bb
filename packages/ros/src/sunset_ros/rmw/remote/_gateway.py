"""The representative of a process behind a pipe, which takes turns with it."""

import time
from collections.abc import Callable
from typing import Final

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.core.node import Middleware
from sunset_ros.rmw.core.port import CallbackError
from sunset_ros.rmw.remote._protocol import (
    Answer,
    Call,
    Check,
    Done,
    Order,
    Pipe,
    PipeError,
    Raised,
    RaisedError,
    Spin,
    Statement,
    Wait,
    encode,
    read_statements,
)
from sunset_ros.rmw.remote._stand_ins import StandIns

_DEEPEST: Final = 20
"""The most turns within turns: a predicate of a waiting process may wait, too."""
_MOST_HELD: Final = 1 << 20
"""Bytes of messages that wait for the next turn."""


class _NestedError(Exception):
    """A callback or predicate raised while its own process waits."""


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
        self._held: list[Order] = []
        self._held_bytes = 0
        self._stand_ins = StandIns(process, self._call)

    def start(self) -> None:
        """Let the remote process make its nodes."""
        self._call(0, (), b"")

    def _call(self, handler: int, numbers: tuple[int, ...], body: bytes) -> None:
        call = Call(handler, self._process.now_ns(), numbers, body)
        if handler in self._stand_ins.deferred and self._held_bytes < _MOST_HELD:
            self._held.append(call)
            self._held_bytes += len(body)
        else:
            self._turn(call)

    def _turn(self, order: Order) -> bool:
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
                    raise _NestedError if self._depth > 1 else RaisedError(last.reason)
                order = self._answer(last)
        except PipeError as error:
            self.failure = error
            self._end()
            self._on_failure(error)
        finally:
            self._depth -= 1
        return True

    def _exchange(self, order: Order) -> Statement:
        """Send an order after the held calls, carry out the answer's changes, and return its last statement."""
        if self._depth > _DEEPEST:
            raise PipeError("waits for itself")
        if self._longest_ns is not None and self._process.now_ns() - self._began_ns >= self._longest_ns:
            raise PipeError(f"waits for more than {self._longest_ns / 1e9:g} s in a callback")
        start_s = time.monotonic()
        end_s = start_s + self._left_s
        orders, self._held, self._held_bytes = [*self._held, order], [], 0
        self._pipe.send(encode(orders), end_s)
        statements = read_statements(self._pipe.receive(end_s))
        self._left_s -= time.monotonic() - start_s
        if not statements:
            raise PipeError("says nothing")
        for change in statements[:-1]:
            self._stand_ins.change(change)
        return statements[-1]

    def _answer(self, question: Statement) -> Answer:
        process = self._process
        try:
            if isinstance(question, Spin):
                called = process.spin_once(self._bounded(question.timeout_ns))
                return Answer(process.now_ns(), value=called)
            if isinstance(question, Wait):
                timeout_ns = self._bounded(question.timeout_ns)
                value = process.wait_for(lambda: self._turn(Check(process.now_ns())), timeout_ns)
                return Answer(process.now_ns(), value=value)
            return self._stand_ins.answer(question)
        except CallbackError as error:
            if not isinstance(error.__cause__, _NestedError):  # a callback of another process
                raise
            return Answer(process.now_ns(), raised=(error.node, error.callback))
        except _NestedError:
            return Answer(process.now_ns(), error="What it waits for raised.")
        except PipeError:
            raise
        except MiddlewareError as error:
            return Answer(process.now_ns(), error=str(error))

    def _bounded(self, timeout_ns: int | None) -> int | None:
        """Return a timeout of at most the longest wait."""
        return min((limit for limit in (timeout_ns, self._longest_ns) if limit is not None), default=None)
