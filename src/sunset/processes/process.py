"""A process with a keeper, as its user sees it, and a copy of the user's process as such a process."""

import os
import re
import select
import signal
import socket
import sys
import tempfile
import time
from collections.abc import Callable, Collection
from contextlib import suppress
from itertools import takewhile
from pathlib import Path
from typing import IO, Final, Self

from sunset.errors import SunsetError
from sunset.processes.confinement.walls import MEMORY, limit_memory
from sunset.processes.forking import fork
from sunset.processes.keeper import (
    NOT_STARTED,
    OUT_OF_MEMORY,
    STATUS,
    Entry,
    Files,
    keep,
    remove_folder,
    send_document,
)
from sunset_ros.interruption import ENDING

_MOST_SHOWN: Final = 1 << 20
"""Bytes of a process's output that are shown."""
_PART: Final = 1 << 16
_UNPRINTABLE: Final = re.compile(r"[^\S\n\t ]|[\x00-\x08\x0b-\x1f\x7f-\x9f]")
_FRAME: Final = re.compile(r'File "(?P<file>[^"]+)", line (?P<line>\d+) in (?P<function>\S+)')

Frame = tuple[str, int, str]
"""File, line and function."""


def show(text: str) -> None:
    """Write a process's output to stderr, without characters that would command a terminal."""
    with suppress(OSError, ValueError, AttributeError):  # it is closed, or None
        sys.stderr.write(_UNPRINTABLE.sub("", text))
        sys.stderr.flush()


class ProcessDeath(Exception):  # noqa: N818  not every death is an error
    """The process ended before its work was done.

    Attributes:
        reason: how it ended, as the end of a sentence.
        frames: where it was, innermost first; empty if that is not known.
        running: the node whose code ran, as `Watch.running`; empty if that is not known.
    """

    def __init__(self, reason: str, frames: tuple[Frame, ...] = ()) -> None:
        super().__init__(reason)
        self.reason = reason
        self.frames = frames
        self.running = ""


class Process:
    """A process with a keeper; as a context, nothing of it is left at the end.

    Processes that are forked from its user's can use it, too.

    Attributes:
        socket: a connected stream, whose other end the process has.
        folder: the only folder that a confined process can write to, its working directory; else None.
        returncode: the exit code, as in `subprocess.Popen`; None while the process runs, or if its keeper was killed.
        keeper_pid: the keeper, if it is a child of this process; else 0.
    """

    def __init__(
        self,
        connection: socket.socket,
        keeper: socket.socket,
        *,
        printed: int | None,
        dying: int,
        folder: Path | None,
        on_text: Callable[[str], object],
    ) -> None:
        self.socket = connection
        self.folder = folder
        self.returncode: int | None = None
        self.keeper_pid = 0
        self._on_text = on_text
        self._keeper = keeper
        self._printed = printed
        self._dying = dying
        self._shown = 0
        self._pid = 0
        self._ended = self._closed = False
        self._poll = select.poll()
        for file in (connection.fileno(), keeper.fileno(), printed):
            if file is not None:
                self._poll.register(file, select.POLLIN)

    @property
    def pid(self) -> int:
        """The process's number; waits until the keeper has sent it."""
        while not self._pid:
            if self._ended:
                raise server_error()
            self._hear()
        return self._pid

    @property
    def descriptors(self) -> frozenset[int]:
        """The open files that a copy of the user's process needs to use this one."""
        files = self.socket.fileno(), self._keeper.fileno(), self._dying, self._printed
        return frozenset(file for file in files if file is not None)

    @property
    def ended(self) -> bool:
        """Whether the process has ended."""
        while not self._ended and self._keeper.fileno() in self._ready(0.0):
            self._hear()
        return self._ended

    def wait(self, timeout_s: float | None = None) -> bool:
        """Return whether something can be received, or the stream has ended, before the process's end or a timeout.

        Meanwhile, show the output, since a full pipe would block the process.
        """
        _ = self.pid  # the time that its server takes to start does not count
        limit_s = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            ended = self.ended
            left_s = 0.0 if ended else None if limit_s is None else limit_s - time.monotonic()
            ready = self._ready(left_s)
            if self._printed in ready:
                self._show()
            if self.socket.fileno() in ready:
                return True
            if ended or (left_s is not None and left_s <= 0):
                return False

    def join(self, limit_s: float) -> bool:
        """Wait for the process's end until a time of the monotonic clock; return whether it has ended."""
        keeper = select.poll()
        keeper.register(self._keeper, select.POLLIN)
        while not self.ended and (left_s := limit_s - time.monotonic()) > 0:
            keeper.poll(left_s * 1000)
        return self.ended

    def take_output(self) -> IO[str]:
        """Return the process's output as a file, which the caller closes."""
        assert self._printed is not None  # noqa: S101  taken once
        self._poll.unregister(self._printed)
        file, self._printed = self._printed, None
        os.set_blocking(file, True)
        return os.fdopen(file, encoding=None, errors="replace")

    def send_signal(self, number: int) -> None:
        """Send a signal to the process and its group, unless it has ended."""
        with suppress(OSError):
            self._keeper.send(bytes([number]))

    def kill(self) -> None:
        """End the process and all that it has started; return when nothing of it is left."""
        self._end(signal.SIGKILL)

    def death(self, reason: str = "") -> ProcessDeath:
        """End the process, and return how it ended, and where in its code if that is known.

        A `reason`, such as `did not return within 30 s`, takes precedence, and the process gets a second to write where
        it is.

        Raises:
            SunsetError: the process could not be started.
        """
        self._end(signal.SIGABRT if reason else signal.SIGKILL)
        text = ""
        with suppress(BlockingIOError):
            text = os.read(self._dying, _PART).decode("utf-8", "replace")
        if text.startswith(NOT_STARTED):
            problem = text.removeprefix(NOT_STARTED)
            trouble = (
                "of the managing system could not be confined" if self.folder else "could not be started"
            )
            raise SunsetError(f"The process {trouble}: {problem}.")
        if text.startswith(OUT_OF_MEMORY):
            reason = f"ran out of memory: it may take {MEMORY >> 30} GiB"
        frames = ((match["file"], int(match["line"]), match["function"]) for match in _FRAME.finditer(text))
        own = str(Path(__file__).parent)
        return ProcessDeath(
            reason or _describe_end(self.returncode),
            tuple(takewhile(lambda frame: not frame[0].startswith(own), frames)),
        )

    def close(self) -> None:
        """End the process if it has not ended, and remove its folder."""
        if self._closed:
            return
        self._closed = True
        with suppress(OSError):
            self._end(signal.SIGKILL)
            while self._keeper.recv(1):  # until the keeper has removed the folder
                pass
        self.socket.close()
        self._keeper.close()
        for file in (self._dying, self._printed):
            if file is not None:
                os.close(file)
        if self.folder is not None:
            remove_folder(self.folder)
        if self.keeper_pid:
            with suppress(ChildProcessError):  # the user ignores SIGCHLD, or has waited for it elsewhere
                os.waitpid(self.keeper_pid, 0)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _ready(self, timeout_s: float | None) -> set[int]:
        """Wait for files that can be read, and return them; none after the timeout."""
        limit_ms = None if timeout_s is None else max(timeout_s, 0.0) * 1000
        return {file for file, _ in self._poll.poll(limit_ms)}

    def _hear(self) -> None:
        """Receive the keeper's next message: the process's number, later its exit code."""
        message = b""
        with suppress(ConnectionResetError):  # the server was killed before there was a keeper
            message = self._keeper.recv(STATUS.size, socket.MSG_WAITALL)
        if not message:
            self._ended = True
            return
        (status,) = STATUS.unpack(message)
        if self._pid:
            self.returncode, self._ended = status, True
        else:
            self._pid = status

    def _end(self, number: int) -> None:
        if not self.ended:
            self.send_signal(number)
            while not self._ended:
                self._hear()
        while self._show():
            pass

    def _show(self) -> bool:
        """Read some output, and show it up to 1 MiB in all; return whether there was any."""
        part = b""
        if self._printed is not None:
            with suppress(BlockingIOError):
                part = os.read(self._printed, _PART)
            if not part and not self._ended:
                self._poll.unregister(self._printed)
                os.close(self._printed)
                self._printed = None
        left = _MOST_SHOWN - self._shown
        if left > 0 and part:
            self._shown += len(part)
            text = part[:left].decode("utf-8", "replace")
            self._on_text(
                text if len(part) <= left else f"{text}\n(what it prints beyond 1 MiB is left out)\n"
            )
        return bool(part)


def _describe_end(code: int | None) -> str:
    if code is None:
        return "ended its process"
    if code >= 0:
        return f"ended its process with exit code {code}"
    try:
        return f"ended its process by {signal.Signals(-code).name}"
    except ValueError:  # real-time signals lack names
        return f"ended its process by signal {-code}"


def killed_error(death: ProcessDeath, owner: str) -> SunsetError:
    """Return the error of a process, of `owner`, whose end cannot be due to its own code."""
    killed = signal.SIGKILL.name in death.reason
    cause = ": it was killed, for instance for want of memory" if killed else ""
    remedy = ", with fewer --jobs if memory was short" if killed else ""
    return SunsetError(
        f"The process of the {owner} {death.reason}{cause}; what was finished is kept: run the same command again"
        f"{remedy}."
    )


def server_error() -> SunsetError:
    """Return the error of a server that has ended."""
    return SunsetError(
        "The process that starts managing systems and live nodes has ended: it was killed, for instance for want of "
        "memory; run the same command again."
    )


def open_process(
    on_text: Callable[[str], object] | None, *, has_folder: bool = False
) -> tuple[Process, Files]:
    """Return a process that is yet to be started, and its keeper's files.

    Args:
        on_text: gets up to 1 MiB of output while the user waits for the process; None for output to stderr.
        has_folder: whether the process gets a temporary folder.
    """
    folder = Path(tempfile.mkdtemp(prefix="sunset-")).resolve() if has_folder else None
    connection, theirs = socket.socketpair()
    keeper, keepers = socket.socketpair()
    printed, prints = (None, os.dup(2)) if on_text is None else os.pipe()
    dying, dies = os.pipe()
    for file in (printed, dying, dies):
        if file is not None:
            os.set_blocking(file, False)
    send_document(keeper, str(folder or ""))
    process = Process(
        connection, keeper, printed=printed, dying=dying, folder=folder, on_text=on_text or show
    )
    return process, Files(keepers.detach(), theirs.detach(), prints, dies)


def copy_process(
    function: Entry,
    task: object = None,
    *,
    on_text: Callable[[str], object] | None = show,
    kept: Collection[int] = (),
) -> Process:
    """Start a copy of this process, which calls a function with its socket and the task.

    Args:
        function: any function.
        task: any object.
        on_text: as in `open_process`.
        kept: the pipes and sockets of this process that the copy keeps open.

    Raises:
        OSError: no process can be started.
    """
    process, files = open_process(on_text)
    child: list[int] = []
    try:
        try:
            if fork(child) == 0:
                keep(function, files, lambda _: _limit(task), kept)
        finally:
            process.keeper_pid = sum(child)
            for file in files:
                os.close(file)
    except BaseException:
        process.close()
        raise
    return process


def _limit(task: object) -> object:
    """Ignore interrupts, and limit the memory of this copy; return the task."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGALRM):
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    limit_memory()
    return task
