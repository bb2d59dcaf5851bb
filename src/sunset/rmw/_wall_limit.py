"""A limit on the wall time of a callback, for code that might hang."""

import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import TypeVar

from sunset.errors import MiddlewareError

__all__ = ["LimitExceeded", "check_possible", "run_limited"]

_REPEAT_S = 0.1

_T = TypeVar("_T")


class LimitExceeded(BaseException):
    """The limit passed. No `Exception`, so that `except Exception` in the callback cannot hide it."""


def check_possible() -> None:
    """Refuse a limit where nothing can be interrupted.

    Raises:
        MiddlewareError: this is not the main thread of a POSIX system.
    """
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        raise MiddlewareError(
            "A wall time limit on callbacks needs the main thread of a POSIX system; leave wall_limit_s unset."
        )


def run_limited(limit_s: float, function: Callable[[], _T]) -> _T:
    """Return what a function returns, and interrupt it after `limit_s` seconds of wall time.

    Raises:
        LimitExceeded: the function ran for longer.
        MiddlewareError: this thread or system cannot interrupt a function.
    """
    check_possible()
    running = True

    def interrupt(_signal: int, _frame: FrameType | None) -> None:
        if running:
            raise LimitExceeded

    previous = signal.signal(signal.SIGALRM, interrupt)
    outer = (0.0, 0.0)  # where a limited function limits another
    try:
        # It repeats, because a callback may swallow even this one.
        outer = signal.setitimer(signal.ITIMER_REAL, limit_s, _REPEAT_S)
        return function()
    finally:
        running = False
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)
        signal.setitimer(signal.ITIMER_REAL, *outer)
