"""The keeper of a process: another process, which forks it, reports its end, and ends it with its children.

It ends the process when the user orders it, closes the connection or ends.
"""

import faulthandler
import io
import math
import os
import select
import shutil
import signal
import socket
import stat
import struct
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, NamedTuple, NoReturn, TypeVar

import msgspec

from sunset.processes.forking import adopt_orphans, signal_after_parent

T = TypeVar("T")

STATUS: Final = struct.Struct("<q")
"""A message of the keeper: first the process's number, then its exit code."""
NOT_STARTED: Final = "NotStarted "
OUT_OF_MEMORY: Final = "MemoryError"
"""What a process writes to `Files.dying` where its exit code does not say why it ended."""

_LENGTH: Final = struct.Struct("<q")
_KILL, _ABORT = bytes([signal.SIGKILL]), bytes([signal.SIGABRT])
_DYING_S: Final = 1.0
"""How long a process may go on after SIGABRT, upon which it writes where it hangs."""

Entry = Callable[[socket.socket, Any], object]
"""The function that a process runs, with its socket and its task."""
Preparation = Callable[[socket.socket], object]
"""Prepares a new process for its task, which it returns."""


class Files(NamedTuple):
    """Open files of a keeper and its process."""

    keeper: int
    """The keeper's socket."""
    connection: int
    """The process's socket."""
    printed: int
    """For the process's output."""
    dying: int
    """For the reason and the place of the process's death."""


def send_document(connection: socket.socket, document: object) -> None:
    """Send an object as JSON."""
    text = msgspec.json.encode(document, enc_hook=str)  # paths
    connection.sendall(_LENGTH.pack(len(text)) + text)


def receive_document(connection: socket.socket, kind: type[T]) -> T:
    """Return the object of a type that the other end sends by `send_document`."""
    (size,) = _LENGTH.unpack(connection.recv(_LENGTH.size, socket.MSG_WAITALL))
    text = connection.recv(size, socket.MSG_WAITALL)
    return msgspec.json.decode(
        text, type=kind, dec_hook=lambda kind, value: Path(value) if kind is Path else value
    )


def keep(function: Entry, files: Files, prepare: Preparation, kept: Collection[int] = ()) -> NoReturn:
    """Be a keeper: fork a process, and end this one when nothing is left of that process.

    Args:
        function: the process runs it.
        files: of both processes.
        prepare: the process runs it before the function.
        kept: the pipes and sockets that the process keeps open besides its files.
    """
    code = 1
    try:
        os.setsid()
        adopt_orphans()
        ended, noted = socket.socketpair()
        for end in (ended, noted):
            end.setblocking(False)
        signal.set_wakeup_fd(noted.fileno())
        signal.signal(signal.SIGCHLD, lambda *_: None)
        pid = os.fork()
        if pid == 0:
            _run(function, files, prepare, kept)
        _close_connections({files.keeper, ended.fileno(), noted.fileno()})
        with socket.socket(fileno=files.keeper) as user:
            folder = receive_document(user, str)
            with suppress(OSError):
                user.send(STATUS.pack(pid))
            _await_end(pid, user, ended)
            exit_code = _reap(pid)
            with suppress(OSError):
                user.send(STATUS.pack(exit_code))
            if folder:
                remove_folder(Path(folder))
        code = 0
    finally:
        os._exit(code)


def _await_end(pid: int, user: socket.socket, ended: socket.socket) -> None:
    """Return when a process has ended or must be killed, since its user has ordered it or has ended."""
    limit_s = math.inf
    poll = select.poll()
    for end in (ended, user):
        poll.register(end, select.POLLIN)
    while (left_s := limit_s - time.monotonic()) > 0:
        ready = {file for file, _ in poll.poll(None if left_s == math.inf else left_s * 1000)}
        if ended.fileno() in ready:
            with suppress(BlockingIOError):
                ended.recv(4096)
            if os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None:
                return
        if user.fileno() in ready:
            order = b""
            with suppress(ConnectionResetError):  # its user has ended, and had not read all
                order = user.recv(1)
            if order in {b"", _KILL}:
                return
            if order == _ABORT:
                limit_s = time.monotonic() + _DYING_S
            _send(pid, order[0])


def _send(pid: int, number: int) -> None:
    """Send a signal to a process that has not been reaped, and to its group."""
    try:
        os.killpg(pid, number)
    except (ProcessLookupError, PermissionError):  # it may not have a group yet
        with suppress(ProcessLookupError, PermissionError):
            os.kill(pid, number)


def _reap(pid: int) -> int:
    """End a process and its group, and return its exit code when nothing of it is left."""
    _send(pid, signal.SIGKILL)
    _, status = os.waitpid(pid, 0)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL)
    with suppress(ChildProcessError):
        while True:
            os.waitpid(-pid, 0)
    return os.waitstatus_to_exitcode(status)


def remove_folder(folder: Path) -> None:
    """Remove a folder with any content; do nothing if it is missing."""
    try:
        shutil.rmtree(folder)
    except FileNotFoundError:
        return
    except (OSError, RecursionError):  # closed to its owner, or deeper than Python can go
        for command in (("chmod", "-R", "u+rwx"), ("rm", "-rf")):
            subprocess.run([*command, "--", str(folder)], check=False, capture_output=True)  # noqa: S603  ours


def _close_connections(kept: Collection[int]) -> None:
    """Close all pipes and sockets of this process except the standard streams and `kept`."""
    for entry in list(Path("/dev/fd").iterdir()):
        file = int(entry.name)
        with suppress(OSError):  # the descriptor of the listing is closed already
            mode = os.fstat(file).st_mode
            if file > 2 and file not in kept and (stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)):  # noqa: PLR2004
                os.close(file)


def _run(function: Entry, files: Files, prepare: Preparation, kept: Collection[int]) -> NoReturn:
    code, parent = 1, os.getppid()
    try:
        os.setsid()
        signal.set_wakeup_fd(-1)
        for number in (signal.SIGCHLD, signal.SIGCONT):
            signal.signal(number, signal.SIG_DFL)
        _close_connections({*files[1:], *kept})
        _print_to(files.printed)
        faulthandler.enable(files.dying, all_threads=False)
        connection = socket.socket(fileno=files.connection)
        try:
            task = prepare(connection)
        except BaseException as error:
            os.write(files.dying, f"{NOT_STARTED}{type(error).__name__}: {error}".encode()[:4000])
            raise
        signal_after_parent(signal.SIGKILL)  # not earlier, since a change of the user undoes it
        if os.getppid() == parent:
            code = _call(function, connection, task, files.dying)
    finally:
        os._exit(code)


def _print_to(file: int) -> None:
    """Let stdout and stderr write to a file at once."""
    for standard in (1, 2):
        os.dup2(file, standard)
    os.close(file)
    for name in ("stdout", "stderr"):
        stream = io.TextIOWrapper(io.FileIO(1, "w", closefd=False), "utf-8", "replace", write_through=True)
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)


def _call(function: Entry, connection: socket.socket, task: object, dying: int) -> int:
    process = os.getpid()
    try:
        function(connection, task)
    except SystemExit as error:
        return error.code if isinstance(error.code, int) else int(error.code is not None)
    except MemoryError:
        os.write(dying, OUT_OF_MEMORY.encode())
        return 1
    except BaseException:  # noqa: BLE001  whatever it is, it is printed
        if os.getpid() == process:
            traceback.print_exc()
        return 1
    return 0
