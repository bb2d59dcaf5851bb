"""Confined processes, as their user sees them."""

import json
import os
import re
import select
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from itertools import takewhile
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from sunset.confinement.server import (
    ABORT,
    KILL,
    LENGTH,
    NOT_CONFINED,
    OUT_OF_MEMORY,
    STATUS,
    Entry,
    environment,
    keep,
    limit_copy,
    remove_folder,
)
from sunset.confinement.walls import MEMORY, View
from sunset.errors import SunsetError
from sunset.forks import ONE_THREAD
from sunset.isolation import FORKING, ProcessDeath, describe_end, find_frames, flush_streams, fork
from sunset.source_files import is_installed

_PROGRAM: Final = """
import sys
sys.path = [*dict.fromkeys([*sys.argv[2:], *sys.path])]
from sunset.confinement.server import serve
serve(sys.argv[1])
"""
_PACKAGE: Final = Path(__file__).parents[2]
_MOST_SHOWN: Final = 1 << 20
"""How much of what a process prints is shown, in bytes."""
_PART: Final = 1 << 16
_DYING: Final = 1 << 16
_UNPRINTABLE: Final = re.compile(r"[^\S\n\t ]|[\x00-\x08\x0b-\x1f\x7f-\x9f]")


def show(text: str) -> None:
    """Write what a confined process printed to stderr; what would command a terminal is left out."""
    with suppress(OSError, ValueError, AttributeError):  # it is closed, or None
        sys.stderr.write(_UNPRINTABLE.sub("", text))
        sys.stderr.flush()


class ConfinedProcess:
    """A confined process; as a context, it is gone at the end, with all that it has started and its folder.

    Processes that are forked from the one that started it can use it, too.

    Attributes:
        socket: what it is talked to through: a connected stream, the other end of which is its only way out.
        folder: the only folder that it can write to; its working directory.
    """

    def __init__(
        self,
        *,
        connection: socket.socket,
        keeper: socket.socket,
        printed: int,
        dying: int,
        folder: Path,
        on_text: Callable[[str], object],
    ) -> None:
        self.socket = connection
        self.folder = folder
        self._on_text = on_text
        self._keeper = keeper
        self._printed: int | None = printed
        self._dying = dying
        self._shown = 0
        self._pid = 0
        self._code: int | None = None
        self._closed = False
        self._poll = select.poll()
        for file in (connection.fileno(), keeper.fileno(), printed):
            self._poll.register(file, select.POLLIN)

    @property
    def pid(self) -> int:
        """Its number; waits until it has one."""
        if not self._pid:
            self._pid = self._hear()
        return self._pid

    @property
    def descriptors(self) -> frozenset[int]:
        """The open files that it is talked to through, which a process that forks must not close to use it."""
        files = {self.socket.fileno(), self._keeper.fileno(), self._dying}
        return frozenset(files if self._printed is None else {*files, self._printed})

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait until something can be received, and forward its output meanwhile; a full pipe would block it.

        Returns:
            Whether something can be, the end of the stream included; False if it has ended, or time is up.
        """
        if self._code is not None:
            return False
        _ = self.pid
        limit_s = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            left_s = None if limit_s is None else limit_s - time.monotonic()
            ready = self._look(left_s)
            if (file := self._printed) in ready and not self._show() and file is not None:
                self._poll.unregister(file)
            if self.socket.fileno() in ready:
                return True
            if self._keeper.fileno() in ready or (left_s is not None and left_s <= 0):
                return False

    @property
    def ended(self) -> bool:
        """Whether it has ended."""
        return self._code is not None or (bool(self.pid) and self._keeper.fileno() in self._look(0.0))

    def _look(self, timeout_s: float | None) -> set[int]:
        """Return which of its files have something to be read, as soon as there is one; nothing if time is up."""
        return {
            file for file, _ in self._poll.poll(None if timeout_s is None else max(timeout_s, 0.0) * 1000)
        }

    def _show(self) -> bool:
        """Read some of what was printed, and hand on what is not too much; return whether there was any."""
        part = b""
        if self._printed is not None:
            with suppress(BlockingIOError):
                part = os.read(self._printed, _PART)
            if not part and self._code is None:
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

    def kill(self) -> None:
        """End it and all that it has started; return when nothing of it is left."""
        self._end(KILL)

    def abort(self) -> None:
        """End it as `kill` does, after it had a second to tell where it hangs, which `death` then knows."""
        self._end(ABORT)

    def _end(self, how: bytes) -> None:
        if self._code is None:
            _ = self.pid
            with suppress(OSError):
                self._keeper.send(how)
            self._code = self._hear()
            while self._show():
                pass

    def _hear(self) -> int:
        """Return what the keeper tells next."""
        self._keeper.settimeout(None)
        told = b""
        while len(told) < STATUS.size:
            part = self._keeper.recv(STATUS.size - len(told))
            if not part:
                raise _server_error()
            told += part
        return int(STATUS.unpack(told)[0])

    def death(self, reason: str = "") -> ProcessDeath:
        """End it, and return how it ended, and where in its code that was, if it is known.

        Args:
            reason: how, if its user knows better: it `did not return within 30 s`, for instance; it then has time to
                tell where it is.

        Raises:
            SunsetError: it could not be confined, so that it has run nothing.
        """
        self._end(ABORT if reason else KILL)
        told = b""
        with suppress(BlockingIOError):
            told = os.read(self._dying, _DYING)
        text = told.decode("utf-8", "replace")
        if text.startswith(NOT_CONFINED):
            raise SunsetError(
                f"The process of the managing system could not be confined: {text.removeprefix(NOT_CONFINED)}."
            )
        if text.startswith(OUT_OF_MEMORY):
            reason = f"ran out of memory: it may take {MEMORY >> 30} GiB"
        frames = takewhile(
            lambda frame: not frame[0].startswith(str(Path(__file__).parent)), find_frames(told)
        )
        return ProcessDeath(reason or describe_end(self._code), "", tuple(frames))

    def close(self) -> None:
        """End it, if it has not ended, and remove its folder."""
        if self._closed:
            return
        self._closed = True
        with suppress(SunsetError, OSError):
            self._end(KILL)
            while self._keeper.recv(1):  # until the folder is gone, too
                pass
        self.socket.close()
        self._keeper.close()
        for file in (self._dying, self._printed):
            if file is not None:
                os.close(file)
        remove_folder(self.folder)

    def __enter__(self) -> Self:
        """Return this process."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self.close()


def _open(on_text: Callable[[str], object]) -> tuple[ConfinedProcess, list[int]]:
    """Return a process that is yet to be, and the files that it and its keeper get."""
    folder = Path(tempfile.mkdtemp(prefix="sunset-")).resolve()
    ours, theirs = socket.socketpair()
    keeper, keepers = socket.socketpair()
    printed, prints = os.pipe()
    dying, dies = os.pipe()
    for end in (printed, dying, dies):
        os.set_blocking(end, False)
    keeper.sendall(LENGTH.pack(len(os.fsencode(folder))) + os.fsencode(folder))
    process = ConfinedProcess(
        connection=ours, keeper=keeper, printed=printed, dying=dying, folder=folder, on_text=on_text
    )
    return process, [keepers.detach(), theirs.detach(), prints, dies]


def _server_error() -> SunsetError:
    """Return what a user is told when the server has ended."""
    return SunsetError(
        "The process that confines managing systems has ended: it was killed, for instance for want of memory; run the "
        "same command again."
    )


def copy_process(
    function: Entry, task: object, *, on_text: Callable[[str], object] = show
) -> ConfinedProcess:
    """Start a process that has what this one has, and sees what it sees: one for what only this one can make.

    There are no walls around it, but it ends as a confined one does, with all that it has started.

    Args:
        function: gets its socket and its task.
        task: anything.
        on_text: as of `Confinement.start`.

    Raises:
        OSError: no process can be made.
    """
    process, files = _open(on_text)
    try:
        try:
            with FORKING:
                flush_streams()
                pid = fork([])
            if pid == 0:
                try:
                    os.setsid()
                    if os.fork() == 0:
                        keep(function, files, lambda _, parent: limit_copy(task, parent))
                finally:
                    os._exit(0)
        finally:
            for file in files:
                os.close(file)
        with suppress(ChildProcessError):  # it has been waited for elsewhere
            os.waitpid(pid, 0)
    except OSError:
        process.close()
        raise
    return process


class Confinement:
    """A server of confined processes; it ends when its user's process does, or closes it.

    Args:
        entry: `module:function`, which each process calls with its socket and its task. The module is imported by the
            server, once.
        folder: where that module is looked up besides where Python does.
    """

    def __init__(self, entry: str, folder: Path = _PACKAGE) -> None:
        self._door, theirs = socket.socketpair()
        installed = [entry for entry in sys.path if entry and is_installed(Path(entry).resolve())]
        with theirs:
            self._process = subprocess.Popen(  # noqa: S603  it is this interpreter
                [
                    sys.executable,
                    "-P",
                    "-c",
                    _PROGRAM,
                    entry,
                    *installed,
                    str(folder.absolute()),
                    str(_PACKAGE),
                ],
                stdin=theirs.fileno(),
                stdout=subprocess.DEVNULL,
                cwd="/",
                env=ONE_THREAD | dict(environment()),
                start_new_session=True,
            )

    def start(self, task: object, view: View, *, on_text: Callable[[str], object] = show) -> ConfinedProcess:
        """Start a process; it may still be on its way when this returns.

        Args:
            task: what the entry gets besides its socket: what JSON can hold.
            view: what it can see.
            on_text: gets what it prints, up to 1 MiB of it, when its user waits for it.

        Raises:
            SunsetError: the server has ended.
            OSError: no folder can be made for it.
        """
        process, files = _open(on_text)
        try:
            try:
                socket.send_fds(self._door, [b"f"], files)
            finally:
                for file in files:
                    os.close(file)
            folder = str(process.folder)
            document = json.dumps({"folder": folder, "view": view.to_json(), "task": task}).encode()
            process.socket.sendall(LENGTH.pack(len(document)) + document)
        except OSError as error:
            process.close()
            raise _server_error() from error
        return process

    @property
    def is_running(self) -> bool:
        """Whether it has not ended."""
        return self._process.poll() is None

    def close(self) -> None:
        """End the server; what it has forked goes on until its user closes it or ends."""
        self._door.close()
        self._process.kill()
        self._process.wait()

    def __enter__(self) -> Self:
        """Return this server."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self.close()
