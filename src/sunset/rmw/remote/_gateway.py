"""What stands on the network for a process behind a pipe, and takes turns with it."""

import time
from collections.abc import Callable
from typing import Final

from sunset.common.errors import MiddlewareError
from sunset.rmw.core.node import Middleware
from sunset.rmw.core.port import CallbackError
from sunset.rmw.remote._protocol import (
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
    read_statements,
    write_orders,
)
from sunset.rmw.remote._stand_ins import StandIns

_DEEPEST: Final = 20
"""Turns within turns: of a process that waits, in a predicate that it waits for, and so on."""
_MOST_HELD: Final = 1 << 20
"""Bytes of messages that wait for the next turn."""


class _NestedError(Exception):
    """A callback or predicate raised while its own process waits, which is told of it."""


class Gateway:
    """Stands on the network for a process that lives elsewhere, and does what that one says.

    Its nodes, endpoints and timers are those of a process of the network: simulated, or live. Where a handler of one of
    them is called, the other side calls its own, and that process waits for it. A process that raises, says nothing in
    time, or says what is not of the protocol has failed: it ends, and the network goes on.

    Args:
        process: the process on the network.
        pipe: the other side is at its other end.
        limit_s: how long the other side may take for a callback, in seconds of wall time.
        longest_ns: how long it may wait in a callback, in the network's time; None for ever.
        end: ends the process on the network when the other side has failed.
        on_failure: called when the process has failed, with how.

    Attributes:
        failure: how the process has failed, as the end of a sentence; None as long as it has not.
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
        """Let the other side make its nodes."""
        self._call(0, (), b"")

    def _call(self, handler: int, numbers: tuple[int, ...], body: bytes) -> None:
        call = Call(handler, self._process.now_ns(), numbers, body)
        if handler in self._stand_ins.deferred and self._held_bytes < _MOST_HELD:
            self._held.append(call)
            self._held_bytes += len(body)
        else:
            self._turn(call)

    def _turn(self, order: Order) -> bool:
        """Give the other side its turn, and do what it says until it is done; return the value of a predicate.

        Where it has failed, that is True: nothing is waited for any more.
        """
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
        """Send what has waited and an order, and do what the other side says; return how it gives the turn back."""
        if self._depth > _DEEPEST:
            raise PipeError("waits for itself")
        if self._longest_ns is not None and self._process.now_ns() - self._began_ns >= self._longest_ns:
            raise PipeError(f"waits for more than {self._longest_ns / 1e9:g} s in a callback")
        start_s = time.monotonic()
        end_s = start_s + self._left_s
        orders, self._held, self._held_bytes = [*self._held, order], [], 0
        self._pipe.send(write_orders(orders), end_s)
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
            if not isinstance(error.__cause__, _NestedError):  # it is not the other side's
                raise
            return Answer(process.now_ns(), raised=(error.node, error.callback))
        except _NestedError:
            return Answer(process.now_ns(), error="What it waits for raised.")
        except PipeError:
            raise
        except MiddlewareError as error:
            return Answer(process.now_ns(), error=str(error))

    def _bounded(self, timeout_ns: int | None) -> int | None:
        """Return how long the other side may wait at most, of the time that it asks for."""
        return min((one for one in (timeout_ns, self._longest_ns) if one is not None), default=None)
