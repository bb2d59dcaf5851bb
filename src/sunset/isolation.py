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
import select
import signal
import stat
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from itertools import takewhile
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Final, NoReturn, TypeVar, cast

from sunset import errors
from sunset.errors import SunsetError
from sunset.forks import fill_standard_streams, signal_after_parent
from sunset.interruption import ENDING, noted_signals

T = TypeVar("T")

FORKING: Final = threading.RLock()
"""Held while a process is forked, and by a thread that uses libraries whose own locks its copy would find held."""

_POLL_S: Final = 0.05
_SHORT_POLL_S: Final = 0.005
"""Where the system does not tell at once that a process has ended."""
_LOOK_S: Final = 0.5
_PATIENCE: Final = 10
"""How many seconds of wall time a second of processor time may take."""
_GRACE_S: Final = 1.0
"""From the signal that lets a process say where it hangs to the one that it cannot refuse."""

_MEMORY: Final = 4 << 30
"""How much memory the process may take beyond its caller's, in bytes."""

_NAME_END: Final = 256
_LONGEST: Final = 4000
"""Of the text of an error in an answer, in characters."""

_FRAME: Final = re.compile(r'File "(?P<file>[^"]+)", line (?P<line>\d+) in (?P<function>\S+)')


class ProcessDeath(Exception):  # noqa: N818  not every death is an error
    """The process ended before its call did.

    Attributes:
        reason: how, as the end of a sentence.
        running: whose code ran, as `Watch.running`.
        frames: where it was, as (file, line, function), the innermost first; empty if that is not known.
    """

    def __init__(self, reason: str, running: str, frames: tuple[tuple[str, int, str], ...] = ()) -> None:
        super().__init__(reason)
        self.reason = reason
        self.running = running
        self.frames = frames


class UnexpectedError(Exception):
    """The call raised what is not a `SunsetError`; the text is its traceback."""


class Watch:
    """What the process tells its caller: when it last did anything, and whose code runs."""

    def __init__(self) -> None:
        page = memoryview(mmap.mmap(-1, mmap.PAGESIZE))
        self._last, self._running = page[:8].cast("q"), page[8:_NAME_END]
        self.tick()

    @property
    def running(self) -> str:
        """Whose code runs, as it was told; whose raised, if it did not return. Empty if that is not known."""
        return bytes(self._running).rstrip(b"\0").decode("utf-8", "replace")

    @running.setter
    def running(self, name: str) -> None:
        self._running[:] = name.encode()[: len(self._running)].ljust(len(self._running), b"\0")

    def tick(self) -> None:
        """Show a sign of life."""
        self._last[0] = time.monotonic_ns()

    def call_named(self, name: str, function: Callable[[], T]) -> T:
        """Call a function; `running` names whose it is until it returns, and still when it has raised."""
        self.running = name
        result = function()
        self.running = ""
        return result

    @property
    def last_s(self) -> float:
        """When there was a sign of life last, by the clock `time.monotonic`."""
        return self._last[0] / 1e9


class Patience:
    """How long other processes may take, however busy the computer is.

    The limit is one of processor time. What sleeps, or waits for the network, takes none, and may take ten times as
    long in wall time. Where the system does not tell how much processor time was taken, that is the only limit.

    Args:
        limit_s: seconds of processor time.
        live: whether time is real, so that the limit is one of wall time.

    Attributes:
        longest_s: seconds of wall time that they may take.
    """

    def __init__(self, limit_s: float, *, live: bool = False) -> None:
        self.longest_s = limit_s if live else _PATIENCE * limit_s
        self._limit_s = limit_s
        self._since_s = self._next_s = 0.0
        self._first_s: float | None = None

    def passed(self, group: int, since_s: float) -> str:
        """Return which limit was passed, as the end of a sentence; empty if none was.

        Args:
            group: the group of the processes; every half second it is found out how much they have taken.
            since_s: when they were last known to do what they should, by the clock `time.monotonic`.
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
    """Return how many seconds of processor time a group of processes has taken; 0 where the system does not tell."""
    ticks = 0
    for file in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # the process has ended meanwhile
            fields = file.read_bytes().rpartition(b")")[2].split()
            if int(fields[2]) == group:
                ticks += sum(map(int, fields[11:15]))  # of the children that have ended, too
    return ticks / os.sysconf("SC_CLK_TCK")


def call_isolated(function: Callable[[Watch], T], *, limit_s: float, kept: Collection[int] = ()) -> T:
    """Call a function in a process of its own, and return what it returns.

    What the process has started and left running is ended with it, but for what made itself a session of its own.

    Args:
        function: gets a `Watch`, and returns what JSON can hold. It ignores interrupts, for its caller has them, and
            what it prints goes to stderr.
        limit_s: seconds of processor time that it may take without a sign of life, as of `Patience`.
        kept: which of the caller's pipes and sockets it keeps open.

    Raises:
        SunsetError: what the function raised, of the same class.
        ProcessDeath: the process ended by itself, was killed, passed the limit and was killed for it, or took more
            memory than it may.
        UnexpectedError: the function raised anything else.
    """
    watch = Watch()
    fill_standard_streams()
    made: list[int] = []
    code = None
    flush_streams()
    # files, since a pipe holds only 64 KiB
    with TemporaryFile() as answer, TemporaryFile() as frames:
        held = signal.pthread_sigmask(signal.SIG_BLOCK, ())
        try:
            with FORKING:
                # what a signal's handler raises in the middle of a fork is lost
                signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
                pid = fork(made)
            if pid == 0:
                _serve(function, watch, answer.fileno(), frames.fileno(), kept)
            signal.pthread_sigmask(signal.SIG_SETMASK, held)
            hung = _await_end(pid, watch, limit_s)
        finally:
            for pid in made:
                code = _reap(pid)
            signal.pthread_sigmask(signal.SIG_SETMASK, held)
        if hung:
            raise ProcessDeath(hung, watch.running, find_frames(_written(frames)))
        told = _written(answer)
        if code or not told:
            raise ProcessDeath(describe_end(code), watch.running, find_frames(_written(frames)))
        return cast("T", _result(told, watch))


def flush_streams() -> None:
    """Write what is still to be written to stdout and stderr, so that a fork does not write it again."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError, ValueError):  # it is None or of a class of the user's, or closed
            stream.flush()


def fork(made: list[int]) -> int:
    """Fork; signals that come meanwhile come again after it, where they are blocked in this thread.

    Where another thread takes a signal, its handler runs in this one all the same, and what it raises is lost in one of
    the functions that Python calls at a fork. It may also raise before the caller has the number of the new process,
    which is therefore put into `made`.
    """
    with noted_signals() as came, warnings.catch_warnings():
        # of Python from 3.12 on; the other threads that there may be are not needed on the other side
        warnings.simplefilter("ignore", DeprecationWarning)
        pid = os.fork()
        made += [pid] if pid else []
    for number in came if pid else ():
        signal.raise_signal(number)
    return pid


def _written(file: IO[bytes]) -> bytes:
    """Return what another process wrote to a file."""
    file.seek(0)
    return file.read()


def _serve(
    function: Callable[[Watch], object], watch: Watch, answer: int, frames: int, kept: Collection[int]
) -> NoReturn:
    """Call the function, write its answer, and end this process: neither threads nor handlers keep it."""
    process, code = os.getpid(), 1
    try:
        told = json.dumps(_outcome(function, watch, {*kept}, frames)).encode()
        for stream in (sys.stdout, sys.stderr):
            with suppress(Exception):  # who closes them gets nothing more to see
                stream.flush()
        if os.getpid() == process:  # else the function has forked it, and it has nothing to answer
            with open(answer, "wb", closefd=False) as file:
                file.write(told)
        code = 0
    finally:
        os._exit(code)


def _set_up(kept: set[int], frames: int) -> None:
    """Make this process one that its caller can end, and that has nothing of its caller's to talk through."""
    os.setsid()
    signal_after_parent(signal.SIGKILL)
    os.register_at_fork(after_in_child=lambda: signal_after_parent(signal.SIGKILL))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGALRM):
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    os.dup2(2, 1)
    for name in list(Path("/dev/fd").iterdir()):
        opened = int(name.name)
        with suppress(OSError):  # the one of the list itself is closed already
            mode = os.fstat(opened).st_mode
            if opened > 2 and opened not in kept and (stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)):  # noqa: PLR2004
                os.close(opened)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    limit_memory()
    faulthandler.enable(frames, all_threads=False)


def limit_memory() -> None:
    """Let this process take 4 GiB of memory beyond what it has, where the system tells how much that is."""
    size = Path("/proc/self/statm")
    if size.exists():
        limit = int(size.read_text(encoding="ascii").split()[5]) * resource.getpagesize() + _MEMORY
        _, most = resource.getrlimit(resource.RLIMIT_DATA)
        limit = limit if most == resource.RLIM_INFINITY else min(limit, most)
        resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))


def _outcome(
    function: Callable[[Watch], object], watch: Watch, kept: set[int], frames: int
) -> dict[str, object]:
    try:
        _set_up(kept, frames)
        return {"result": function(watch)}
    except SunsetError as error:
        # the nearest class that the other side knows
        known = next(kind.__name__ for kind in type(error).__mro__ if _class_of_ours(kind.__name__))
        return {"error": known, "text": str(error)}
    except MemoryError:
        return {"death": f"ran out of memory: it may take {_MEMORY >> 30} GiB"}
    except BaseException:  # noqa: BLE001  the other side raises it
        return {"bug": traceback.format_exc()[-_LONGEST:]}


def _class_of_ours(name: str) -> type[SunsetError] | None:
    found = getattr(errors, name, None)
    return found if isinstance(found, type) and issubclass(found, SunsetError) else None


def _result(told: bytes, watch: Watch) -> object:
    """Return what a process answered, or raise it; it may have been tampered with."""
    try:
        outcome = dict(json.loads(told))
    except (TypeError, ValueError, RecursionError) as error:
        raise ProcessDeath("ended its process without an answer that can be read", watch.running) from error
    if kind := _class_of_ours(str(outcome.get("error"))):
        raise kind(str(outcome.get("text")))
    if "death" in outcome:
        raise ProcessDeath(str(outcome["death"]), watch.running)
    if "result" not in outcome:
        raise UnexpectedError(str(outcome.get("bug")))
    return outcome["result"]


def _await_end(pid: int, watch: Watch, limit_s: float) -> str:
    """Wait for a process, and end it if it passes a limit; return which one, if so."""
    hung, grace_over, patience = "", 0.0, Patience(limit_s)
    with _pauses(pid) as pause:
        while _runs(pid):
            if hung:
                if time.monotonic() > grace_over:
                    os.kill(pid, signal.SIGKILL)
            elif hung := patience.passed(pid, watch.last_s):
                grace_over = time.monotonic() + _GRACE_S
                os.kill(pid, signal.SIGABRT)  # its faulthandler tells where it is
            pause()
    return hung


@contextmanager
def _pauses(pid: int) -> Iterator[Callable[[], object]]:
    """Give what waits for a moment, or until a process has ended."""
    try:
        handle = os.pidfd_open(pid)  # of Linux
    except (AttributeError, OSError):
        yield partial(time.sleep, _SHORT_POLL_S)  # noqa: TID251  another process
        return
    ended = select.poll()
    ended.register(handle, select.POLLIN)
    try:
        yield partial(ended.poll, _POLL_S * 1000)
    finally:
        os.close(handle)


def _runs(pid: int) -> bool:
    try:
        return os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None
    except ChildProcessError:  # the caller ignores SIGCHLD, or its handler has reaped it
        return False


def _reap(pid: int) -> int | None:
    """End a process, if it has not ended, and the rest of its group; return its exit code, None if it was lost."""
    for end in (os.killpg, os.kill):  # it may not have made a group yet
        with suppress(ProcessLookupError, PermissionError):
            end(pid, signal.SIGKILL)
    try:
        _, status = os.waitpid(pid, 0)
    except ChildProcessError:
        return None
    return os.waitstatus_to_exitcode(status)


def describe_end(code: int | None) -> str:
    """Return how a process ended, as the end of a sentence; `code` is its exit code, None if it was lost."""
    if code is None:
        return "ended its process"
    if code >= 0:
        return f"ended its process with exit code {code}"
    try:
        return f"ended its process by {signal.Signals(-code).name}"
    except ValueError:  # those of real time have no names
        return f"ended its process by signal {-code}"


def find_frames(told: bytes) -> tuple[tuple[str, int, str], ...]:
    """Return where a process was, as (file, line, function), the innermost first, as its faulthandler told."""
    text = told.decode("utf-8", "replace")
    frames = ((at["file"], int(at["line"]), at["function"]) for at in _FRAME.finditer(text))
    return tuple(takewhile(lambda frame: frame[2] != _outcome.__name__, frames))
