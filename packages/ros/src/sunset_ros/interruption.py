"""Signals that ask this process to end, held back until it is safe."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Final

ENDING: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that ask a process to end."""


@contextmanager
def noted_signals(answer: str = "") -> Iterator[list[int]]:
    """Give the signals that ask this process to end and come meanwhile; they do nothing else.

    Ignored signals stay ignored, and threads other than the main one change nothing. `answer` is written to stderr when
    the first signal comes.
    """
    came: list[int] = []
    before = {}

    def note(number: int, _: FrameType | None) -> None:
        if answer and not came:
            with suppress(OSError):  # the terminal may be gone
                os.write(2, f"{answer}\n".encode())  # unlike print, it may interrupt another print
        came.append(number)

    if threading.current_thread() is threading.main_thread():
        for number in ENDING:
            if signal.getsignal(number) not in {signal.SIG_IGN, None}:
                before[number] = signal.signal(number, note)
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def held_signals(answer: str = "") -> Iterator[Callable[[], None]]:
    """Hold back the signals that ask this process to end, as `noted_signals`.

    An exception that a signal's handler raises within DDS crashes the interpreter. So a `KeyboardInterrupt` with the
    number of the first signal is raised only by the function that the context gives, and at the context's end.
    """
    with noted_signals(answer) as came:

        def check() -> None:
            if came:
                raise KeyboardInterrupt(came[0])

        yield check
    check()
