"""A call in a process of its own: whatever it does to the interpreter, hangs in or dies of, its caller goes on.

The process is forked, so that it has at once what its caller has loaded, and leaves nothing behind but its answer. It
contains mistakes, not malice: it may still do to files and to other processes whatever the user may.
"""

import faulthandler
import json
import mmap
import os
import re
import resource
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import Any, Final, NoReturn, TypeVar

from sunset import errors
from sunset.errors import SunsetError
from sunset.forks import signal_after_parent

__all__ = ["ProcessDeath", "Watch", "call_isolated"]

T = TypeVar("T")

_POLL_S: Final = 0.005
_GRACE_S: Final = 1.0
"""From the signal that lets a process say where it hangs to the one that it cannot refuse."""

_MEMORY: Final = 4 << 30
"""How much address space the process may take beyond its caller's, in bytes."""

_CAPACITY: Final = 1 << 16
_LONGEST: Final = 8000
"""Of a text in an answer, in characters; JSON may take six bytes for one."""

_FRAME: Final = re.compile(r'File "(?P<file>[^"]+)", line (?P<line>\d+) in (?P<function>\S+)')


class ProcessDeath(Exception):  # noqa: N818  not every death is an error
    """The process ended before its call did.

    Attributes:
        reason: how, as the end of a sentence.
        frames: where it was, as (file, line, function), the innermost first; empty if that is not known.
    """

    def __init__(self, reason: str, frames: tuple[tuple[str, int, str], ...] = ()) -> None:
        super().__init__(reason)
        self.reason = reason
        self.frames = frames


class Watch:
    """What the process tells its caller's clock: since when code runs that may hang."""

    def __init__(self) -> None:
        self._since = memoryview(mmap.mmap(-1, mmap.PAGESIZE)).cast("q")

    def call(self, function: Callable[[], T]) -> T:
        """Call a function that may hang, or fork; a process that it forks ends when the function does."""
        process = os.getpid()
        self._since[0] = time.monotonic_ns()
        try:
            return function()
        finally:
            if os.getpid() != process:
                os._exit(0)
            self._since[0] = 0

    @property
    def seconds(self) -> float:
        """How long the present call has been running; 0 if there is none."""
        since = self._since[0]
        return (time.monotonic_ns() - since) / 1e9 if since else 0.0


def call_isolated(function: Callable[[Watch], Any], *, limit_s: float) -> Any:
    """Call a function in a process of its own, and return what it returns.

    Args:
        function: gets a `Watch`, and returns what JSON can hold. It ignores interrupts, for its caller has them.
        limit_s: seconds of wall time that each call under the watch may take.

    Raises:
        SunsetError: what the function raised, of the same class.
        ProcessDeath: the process ended by itself, was killed, passed the limit and was killed for it, or took more
            memory than it may.
        RuntimeError: the function raised anything else; the text is its traceback.
    """
    watch = Watch()
    answer, frames = _Pipe(), _Pipe()
    sys.stdout.flush()
    sys.stderr.flush()
    with closing(answer), closing(frames):
        with warnings.catch_warnings():
            # from Python 3.12 on; the other threads that there may be are not needed on the other side
            warnings.simplefilter("ignore", DeprecationWarning)
            pid = os.fork()
        if pid == 0:
            _serve(function, watch, answer, frames)
        code, hung = _await_end(pid, watch, limit_s)
        told = answer.read()
        if code == 0 and told and not hung:
            return _result(told)
        raise ProcessDeath(
            f"did not return within {limit_s:g} s" if hung else _describe_end(code),
            _find_frames(frames.read()),
        )


class _Pipe:
    """A pipe that nobody waits at: it holds 64 KiB, and is read when its writer has ended."""

    def __init__(self) -> None:
        self._end, self.writer = os.pipe()
        os.set_blocking(self._end, False)
        os.set_blocking(self.writer, False)

    def read(self) -> bytes:
        """Return what was written; a process that the writer left behind may still hold the pipe."""
        try:
            return os.read(self._end, _CAPACITY)
        except BlockingIOError:
            return b""

    def close(self) -> None:
        os.close(self._end)
        os.close(self.writer)


def _serve(function: Callable[[Watch], Any], watch: Watch, answer: _Pipe, frames: _Pipe) -> NoReturn:
    """Call the function, write its answer, and end this process: neither threads nor handlers keep it."""
    code = 1
    try:
        _set_up(frames)
        told = json.dumps(_outcome(function, watch)).encode()
        sys.stdout.flush()
        sys.stderr.flush()
        os.write(answer.writer, told)
        code = 0
    finally:
        os._exit(code)


def _set_up(frames: _Pipe) -> None:
    signal_after_parent(signal.SIGKILL)
    os.register_at_fork(after_in_child=lambda: signal_after_parent(signal.SIGKILL))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGALRM):
        signal.signal(number, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    size = Path("/proc/self/statm")
    if size.exists():  # where the system tells how much it is now
        limit = int(size.read_text(encoding="ascii").split()[0]) * resource.getpagesize() + _MEMORY
        _, most = resource.getrlimit(resource.RLIMIT_AS)
        limit = limit if most == resource.RLIM_INFINITY else min(limit, most)
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    faulthandler.enable(frames.writer, all_threads=False)


def _outcome(function: Callable[[Watch], Any], watch: Watch) -> dict[str, object]:
    try:
        return {"result": function(watch)}
    except SunsetError as error:
        # the nearest class that the other side knows
        known = next(kind.__name__ for kind in type(error).__mro__ if kind.__name__ in errors.__all__)
        return {"error": known, "text": str(error)[:_LONGEST]}
    except MemoryError:
        return {"death": f"ran out of memory: it may take {_MEMORY >> 30} GiB"}
    except BaseException:  # noqa: BLE001  the other side raises it
        return {"bug": traceback.format_exc()[-_LONGEST:]}


def _result(told: bytes) -> Any:
    outcome = json.loads(told)
    if "error" in outcome:
        raise getattr(errors, outcome["error"])(outcome["text"])
    if "death" in outcome:
        raise ProcessDeath(outcome["death"])
    if "bug" in outcome:
        raise RuntimeError(outcome["bug"])
    return outcome["result"]


def _await_end(pid: int, watch: Watch, limit_s: float) -> tuple[int, bool]:
    """Wait for a process, and end it if it passes the limit; return its exit code and whether it did."""
    hung = ended = False
    try:
        while True:
            done, status = os.waitpid(pid, os.WNOHANG)
            if done:
                ended = True
                return os.waitstatus_to_exitcode(status), hung
            over_s = watch.seconds - limit_s
            if over_s > _GRACE_S:
                os.kill(pid, signal.SIGKILL)
            elif over_s > 0 and not hung:
                hung = True
                os.kill(pid, signal.SIGABRT)  # its faulthandler tells where it is
            time.sleep(_POLL_S)  # noqa: TID251  another process's end is waited for
    finally:
        if not ended:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
                os.waitpid(pid, 0)


def _describe_end(code: int) -> str:
    if code >= 0:
        return f"ended its process with exit code {code}"
    return f"ended its process by {signal.Signals(-code).name}"


def _find_frames(told: bytes) -> tuple[tuple[str, int, str], ...]:
    text = told.decode("utf-8", "replace")
    return tuple((at["file"], int(at["line"]), at["function"]) for at in _FRAME.finditer(text))
