"""Calls in a copy of this process, which may change the interpreter, hang or die there.

The copy has at once what this process has loaded. It contains mistakes, not malice: it may do to files and to other
processes whatever the user may.
"""

import json
import mmap
import os
import socket
import time
import traceback
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path
from typing import Final, TypeVar, cast

from sunset import errors
from sunset.errors import SunsetError
from sunset.processes.process import Process, ProcessDeath, copy_process

T = TypeVar("T")

_POLL_S: Final = 0.05
_GRACE_S: Final = 1.0
"""How long a process may take to end when its connection is closed."""
_PART: Final = 1 << 16
_LOOK_S: Final = 0.5
_PATIENCE: Final = 10
"""Seconds of wall time that a second of processor time may take."""
_NAME_END: Final = 256
_LONGEST: Final = 4000
"""Characters of a traceback in an answer."""
_RESULT, _BUG = "result", "bug"


class Patience:
    """A limit of processor time, and of ten times as much wall time; without `/proc`, only of wall time.

    Args:
        limit_s: seconds of processor time.
        live: whether time is real, so that the limit is of wall time.

    Attributes:
        longest_s: seconds of wall time that the processes may take.
    """

    def __init__(self, limit_s: float, *, live: bool = False) -> None:
        self.longest_s = limit_s if live else _PATIENCE * limit_s
        self._limit_s = limit_s
        self._since_s = self._next_s = 0.0
        self._first_s: float | None = None

    def passed(self, group: int, since_s: float) -> str:
        """Return which limit was passed, as the end of a sentence; empty if none was.

        Args:
            group: the group of the processes, whose processor time is read every half second.
            since_s: when the processes last showed a sign of life, by the clock `time.monotonic`.
        """
        now_s = time.monotonic()
        if since_s != self._since_s:
            self._since_s, self._next_s, self._first_s = since_s, since_s + _LOOK_S, None
        if now_s > since_s + self.longest_s:
            return f"did not return within {self.longest_s:g} s"
        if now_s >= self._next_s:
            taken_s = _processor_time(group)
            self._next_s = now_s + _LOOK_S
            self._first_s = taken_s if self._first_s is None else self._first_s
            if taken_s - self._first_s > self._limit_s:
                return f"did not return within {self._limit_s:g} s of processor time"
        return ""


def _processor_time(group: int) -> float:
    """Return the seconds of processor time that a group of processes has taken; 0 without `/proc`."""
    ticks = 0
    for file in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # the process has ended meanwhile
            fields = file.read_bytes().rpartition(b")")[2].split()
            if int(fields[2]) == group:
                ticks += sum(map(int, fields[11:15]))  # with ended children
    return ticks / os.sysconf("SC_CLK_TCK")


class UnexpectedError(Exception):
    """The call raised another exception than a `SunsetError`; the text is its traceback."""


class Watch:
    """Memory that the caller shares with the process: the last sign of life, and the node whose code runs."""

    def __init__(self) -> None:
        page = memoryview(mmap.mmap(-1, mmap.PAGESIZE))
        self._last, self._running = page[:8].cast("q"), page[8:_NAME_END]
        self.tick()

    @property
    def running(self) -> str:
        """The node whose code runs, or raised; empty if that is not known."""
        return bytes(self._running).rstrip(b"\0").decode("utf-8", "replace")

    @running.setter
    def running(self, name: str) -> None:
        self._running[:] = name.encode()[: len(self._running)].ljust(len(self._running), b"\0")

    def tick(self) -> None:
        """Show a sign of life."""
        self._last[0] = time.monotonic_ns()

    def call_named(self, name: str, function: Callable[[], T]) -> T:
        """Call a function; `running` names its node until it returns, and still when it has raised."""
        self.running = name
        result = function()
        self.running = ""
        return result

    @property
    def last_s(self) -> float:
        """The time of the last sign of life, by the clock `time.monotonic`."""
        return self._last[0] / 1e9


def call_isolated(function: Callable[[Watch], T], *, limit_s: float, kept: Collection[int] = ()) -> T:
    """Call a function in a copy of this process, and return its result.

    Args:
        function: returns what JSON can hold. Interrupts are ignored there, and its output goes to stderr.
        limit_s: seconds of processor time that it may take without a sign of life, as in `Patience`.
        kept: the pipes and sockets of this process that it keeps open.

    Raises:
        SunsetError: the function raised it, or a subclass of it that only the copy knows.
        ProcessDeath: the process ended early, was killed, passed the limit, or took more memory than it may.
        UnexpectedError: the function raised anything else.
    """
    watch = Watch()

    def answer(connection: socket.socket, _: object) -> None:
        process = os.getpid()
        outcome = json.dumps(_outcome(function, watch)).encode()
        if os.getpid() == process:  # else the function has forked it
            connection.sendall(outcome)

    try:
        with copy_process(answer, on_text=None, kept=kept) as process:
            return cast("T", _result(_await_answer(process, watch, limit_s)))
    except ProcessDeath as death:
        death.running = watch.running
        raise


def _outcome(function: Callable[[Watch], object], watch: Watch) -> tuple[str, object]:
    """Return the name of an error that the caller knows with its text, `_RESULT` or `_BUG`."""
    try:
        return _RESULT, function(watch)
    except SunsetError as error:
        return next(kind.__name__ for kind in type(error).__mro__ if _own_error(kind.__name__)), str(error)
    except MemoryError:
        raise
    except BaseException:  # noqa: BLE001  the caller raises it
        return _BUG, traceback.format_exc()[-_LONGEST:]


def _own_error(name: str) -> type[SunsetError] | None:
    kind = getattr(errors, name, None)
    return kind if isinstance(kind, type) and issubclass(kind, SunsetError) else None


def _await_answer(process: Process, watch: Watch, limit_s: float) -> bytes:
    """Return the answer of a process; raise `ProcessDeath` unless it ends in order."""
    answer, patience = bytearray(), Patience(limit_s)
    while not process.ended or process.wait(0.0):
        if process.wait(_POLL_S):
            part = process.socket.recv(_PART)
            if not part:
                process.join(time.monotonic() + _GRACE_S)
                break
            answer += part
        elif late := patience.passed(process.pid, watch.last_s):
            raise process.death(late)
    if process.returncode or not answer:
        raise process.death()
    return bytes(answer)


def _result(answer: bytes) -> object:
    try:
        kind, value = json.loads(answer)
    except (TypeError, ValueError, RecursionError) as error:
        raise ProcessDeath("ended its process without an answer that can be read") from error
    if kind == _RESULT:
        return cast("object", value)
    raise (_own_error(str(kind)) or UnexpectedError)(str(value))
