"""Signals that ask this process to end, put off until it is safe."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Final

ENDING: Final = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
"""Signals that ask a process to end; not every system has all."""


@contextmanager
def noted_signals(answer: str = "") -> Iterator[list[int]]:
    """Give the signals that ask this process to end and come meanwhile, which do nothing else.

    Ignored ones stay so, and threads that are not the main one leave all alone. The answer is written to stderr when
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
def noted_interrupts() -> Iterator[list[int]]:
    """Give the interrupts that come, which do what they did before: others may raise a `KeyboardInterrupt`, too."""
    came: list[int] = []
    before = signal.getsignal(signal.SIGINT)

    def note(number: int, frame: FrameType | None) -> None:
        came.append(number)
        if callable(before):
            before(number, frame)

    replaced = callable(before) and threading.current_thread() is threading.main_thread()
    if replaced:
        signal.signal(signal.SIGINT, note)
    try:
        yield came
    finally:
        if replaced and signal.getsignal(signal.SIGINT) is note:
            signal.signal(signal.SIGINT, before)


@contextmanager
def held_signals(answer: str = "") -> Iterator[Callable[[], None]]:
    """Hold back the signals that ask this process to end; ignored ones stay so, and other threads leave all alone.

    What a signal's handler raises in the middle of the functions of DDS crashes the interpreter. So it is raised
    only when the function that this gives is called, and when the context ends: a `KeyboardInterrupt` with the number
    of the signal that came first. The answer is written to stderr at once.
    """
    with noted_signals(answer) as came:

        def check() -> None:
            if came:
                raise KeyboardInterrupt(came[0])

        yield check
    check()
