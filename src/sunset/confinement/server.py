"""The server of confined processes, and what they are before they run anything: `serve` is its program.

It forks a *keeper* for every process, which forks the process. The keeper ends it, with all that it has started, when
the keeper's user says so or is gone, and tells how it ended.
"""

import faulthandler
import gc
import importlib
import io
import json
import os
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from select import select
from typing import Any, Final, NoReturn

from sunset.confinement._libc import libc
from sunset.confinement.walls import View, prepare, put_up
from sunset.forks import signal_after_parent
from sunset.interruption import ENDING
from sunset.isolation import limit_memory
from sunset.source_files import find_modules

STATUS: Final = struct.Struct("<q")
"""What a keeper tells: first the process's number, then its exit code."""
KILL: Final = b"k"
ABORT: Final = b"a"
FILES: Final = 4
"""How many open files an order has: keeper's socket, process's socket, what it prints to, what it dies to."""
LENGTH: Final = struct.Struct("<q")

OUT_OF_MEMORY: Final = "MemoryError"
NOT_CONFINED: Final = "NotConfined "
"""What a process writes before it dies, where its exit code does not tell why."""

_GRACE_S: Final = 1.0
_SUBREAPER: Final = 36
"""PR_SET_CHILD_SUBREAPER of Linux's prctl(2)."""

Entry = Callable[[socket.socket, Any], object]


def serve(entry: str) -> None:
    """Fork a process whenever it is asked for at the door, which is stdin; return when the asking process has gone.

    Args:
        entry: `module:function`, which each process calls with its socket and its task.
    """
    module, _, name = entry.partition(":")
    function: Entry = getattr(importlib.import_module(module), name)
    prepare()
    signal_after_parent(signal.SIGCONT)  # to see that its user is gone, even if it was stopped
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nothing waits for keepers
    gc.collect()
    gc.freeze()  # the garbage collector would write to pages that all forked processes share
    with socket.socket(fileno=os.dup(0)) as door:
        os.dup2(1, 0)
        while True:
            order, files, _, _ = socket.recv_fds(door, 1, FILES)
            if not order:
                return
            if len(files) == FILES and os.fork() == 0:
                door.detach()
                keep(function, files, _confine)
            for file in files:
                os.close(file)


def keep(function: Entry, files: list[int], become: Callable[[socket.socket, int], object]) -> NoReturn:
    """Fork a process, and end it in time.

    Args:
        function: what the process runs.
        files: what an order has.
        become: makes the process what it is to be, from its socket and the number of this one; returns its task.
    """
    code = 1
    try:
        keeper, theirs, printed, dying = files
        _close_others(set(files))
        _become_reaper()
        ended, noted = socket.socketpair()
        for end in (ended, noted):
            end.setblocking(False)
        signal.set_wakeup_fd(noted.fileno())
        signal.signal(signal.SIGCHLD, lambda *_: None)
        pid = os.fork()
        if pid == 0:
            _run(function, theirs, printed, dying, become)
        for file in (theirs, printed, dying):
            os.close(file)
        with socket.socket(fileno=keeper) as user:
            folder = Path(os.fsdecode(_receive_text(user)))
            with suppress(OSError):
                user.send(STATUS.pack(pid))
            _await_end(pid, user, ended)
            exit_code = _reap(pid)
            with suppress(OSError):
                user.send(STATUS.pack(exit_code))
            remove_folder(folder)
        code = 0
    finally:
        os._exit(code)


def _become_reaper() -> None:
    """Let what a process leaves behind become this one's, so that its end can be waited for; where the system can."""
    if sys.platform == "linux":
        libc().prctl(_SUBREAPER, 1, 0, 0, 0)


def _await_end(pid: int, user: socket.socket, ended: socket.socket) -> None:
    """Return when the process has ended, or its user wants it to, or is gone."""
    limit_s: float | None = None
    while True:
        ready, _, _ = select([user, ended], [], [], limit_s)
        if ended in ready:
            with suppress(BlockingIOError):
                ended.recv(4096)
            if os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None:
                return
        if user in ready:
            if user.recv(1) != ABORT:
                return
            os.kill(pid, signal.SIGABRT)  # it tells where it is
            limit_s = _GRACE_S
        if not ready:
            return


def _reap(pid: int) -> int:
    """End a process and its group, and return its exit code when nothing of it is left."""
    for end in (os.killpg, os.kill):  # it may not have a group yet
        with suppress(ProcessLookupError, PermissionError):
            end(pid, signal.SIGKILL)
    _, status = os.waitpid(pid, 0)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL)
    with suppress(ChildProcessError):
        while True:
            os.waitpid(-pid, 0)
    return os.waitstatus_to_exitcode(status)


def remove_folder(folder: Path) -> None:
    """Remove a folder, unless that was done, whatever is in it."""
    try:
        shutil.rmtree(folder)
    except FileNotFoundError:
        return
    except (OSError, RecursionError):  # closed to its owner, or deeper than Python can go
        for command in (("chmod", "-R", "u+rwx"), ("rm", "-rf")):
            subprocess.run([*command, "--", str(folder)], check=False, capture_output=True)  # noqa: S603  ours


def _close_others(kept: set[int]) -> None:
    """Close all files of this process but the standard ones and those that are kept."""
    first = 3
    for file in sorted(kept):
        os.closerange(first, file)
        first = max(first, file + 1)
    os.closerange(first, os.sysconf("SC_OPEN_MAX"))


def _run(
    function: Entry,
    theirs: int,
    printed: int,
    dying: int,
    become: Callable[[socket.socket, int], object],
) -> NoReturn:
    """Make this process what it is to be, and run what it is for."""
    code, parent = 1, os.getppid()
    try:
        os.setsid()
        signal.set_wakeup_fd(-1)
        for number in (signal.SIGCHLD, signal.SIGCONT):
            signal.signal(number, signal.SIG_DFL)
        _close_others({theirs, printed, dying})
        for standard in (1, 2):
            os.dup2(printed, standard)
        os.close(printed)
        faulthandler.enable(dying, all_threads=False)
        for name in ("stdout", "stderr"):
            stream = io.TextIOWrapper(
                io.FileIO(1, "w", closefd=False), "utf-8", "replace", write_through=True
            )
            setattr(sys, name, stream)
            setattr(sys, f"__{name}__", stream)
        task_socket = socket.socket(fileno=theirs)
        try:
            task = become(task_socket, parent)
        except BaseException as error:
            os.write(dying, f"{NOT_CONFINED}{type(error).__name__}: {error}".encode()[:4000])
            raise
        code = _call(function, task_socket, task, dying)
    finally:
        os._exit(code)


def _confine(task_socket: socket.socket, parent: int) -> object:
    """Read what this process is to be, and make it so; return its task."""
    document = json.loads(_receive_text(task_socket))
    folder, view = Path(document["folder"]), View.from_json(document["view"])
    os.chdir(folder)
    os.umask(0o077)
    os.environ["HOME"] = os.environ["TMPDIR"] = str(folder)
    tempfile.tempdir = str(folder)
    sys.argv[:] = [""]
    find_modules(view.search, view.modules)
    put_up(view, folder)
    _end_with(parent)  # after the user has changed, which undoes it
    return document["task"]


def _end_with(parent: int) -> None:
    signal_after_parent(signal.SIGKILL)
    if os.getppid() != parent:
        raise ConnectionError("its keeper has ended")


def limit_copy(task: object, parent: int) -> object:
    """Make this process, a copy of its user's, one that ends in time; it sees what its user does. Return its task.

    It may take as much memory as a confined one beyond what its user has.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGALRM):
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    limit_memory()
    _end_with(parent)
    return task


def _receive_text(connection: socket.socket) -> bytes:
    """Return the next text, which has its length before it."""
    return _receive(connection, LENGTH.unpack(_receive(connection, LENGTH.size))[0])


def _receive(task_socket: socket.socket, size: int) -> bytes:
    data = bytearray()
    while len(data) < size:
        part = task_socket.recv(size - len(data))
        if not part:
            raise ConnectionError("the task's connection closed early")
        data += part
    return bytes(data)


def _call(function: Entry, task_socket: socket.socket, task: object, dying: int) -> int:
    """Call what this process is for; return its exit code."""
    process = os.getpid()
    try:
        function(task_socket, task)
    except SystemExit as error:
        return error.code if isinstance(error.code, int) else int(error.code is not None)
    except MemoryError:
        os.write(dying, OUT_OF_MEMORY.encode())
        return 1
    except BaseException:  # noqa: BLE001  whatever it is, it is told
        if os.getpid() == process:
            traceback.print_exc()
        return 1
    return 0


def environment() -> Mapping[str, str]:
    """Return the variables of a server: what Python needs, and nothing that tells of its user."""
    kept = ("LANG", "LC_ALL", "LC_CTYPE", "TZ", "PYTHONHASHSEED")
    return {
        "PATH": "/usr/local/bin:/usr/bin:/bin",
        **{name: os.environ[name] for name in kept if name in os.environ},
    }
