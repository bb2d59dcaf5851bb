"""Servers that fork processes: interpreters that have imported the modules which the processes need.

Python and its packages take half a second of a processor to load; a server loads them once, and forks a process within
milliseconds. A server has a single thread, and has neither its user's memory, nor its arguments or open files.
"""

import atexit
import gc
import importlib
import os
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final, Self

import msgspec

from sunset.files.sources import find_modules, is_installed
from sunset.processes.confinement.walls import View, put_up
from sunset.processes.forking import ONE_THREAD, signal_after_parent
from sunset.processes.keeper import Files, keep, receive_document, send_document
from sunset.processes.process import Process, open_process, server_error, show

_PROGRAM: Final = """
import sys
sys.path = [*dict.fromkeys([*sys.argv[3:], *sys.path])]
from sunset.processes.server import serve
serve(*sys.argv[1:3])
"""
_PACKAGE: Final = Path(__file__).parents[2]
_VARIABLES: Final = ("LANG", "LC_ALL", "LC_CTYPE", "TZ", "PYTHONHASHSEED")
"""Variables of the environment that a clean server has, too."""


class _Order(msgspec.Struct):
    task: object
    folder: str
    view: View | None


class ForkServer:
    """A server of processes; it ends when its user's process ends or closes it.

    Args:
        entry: `module:function`, which each process calls with its socket and its task.
        prepare: `module:function`, which the server calls once.
        clean: whether the server has neither its user's environment, nor its working directory, nor modules that are
            not installed.
        folder: where a clean server finds other modules.
    """

    def __init__(self, entry: str, prepare: str, *, clean: bool = True, folder: Path = _PACKAGE) -> None:
        self._door, theirs = socket.socketpair()
        installed = [place for place in sys.path if place and is_installed(Path(place).resolve())]
        places = [*installed, str(folder.absolute()), str(_PACKAGE)] if clean else []
        safe = ["-P"] if clean else []
        with theirs:
            self._process = subprocess.Popen(  # noqa: S603  it is this interpreter
                [sys.executable, *safe, "-c", _PROGRAM, entry, prepare, *places],
                stdin=theirs.fileno(),
                stdout=subprocess.DEVNULL,
                stderr=None if clean else subprocess.DEVNULL,
                cwd="/" if clean else None,
                env=ONE_THREAD | dict(_clean_environment() if clean else os.environ),
                start_new_session=True,
            )

    def start(
        self,
        task: object,
        view: View | None = None,
        *,
        on_text: Callable[[str], object] = show,
    ) -> Process:
        """Start a process, without waiting for it.

        Args:
            task: of the process, as JSON can hold it.
            view: the paths that a confined process sees; None for a process without walls.
            on_text: as in `open_process`.

        Raises:
            SunsetError: the server has ended.
            OSError: the process's folder cannot be made.
        """
        process, files = open_process(on_text, has_folder=view is not None)
        try:
            try:
                socket.send_fds(self._door, [b"f"], files)
            finally:
                for file in files:
                    os.close(file)
            send_document(process.socket, _Order(task, str(process.folder), view))
        except OSError as error:
            process.close()
            raise server_error() from error
        return process

    @property
    def is_running(self) -> bool:
        """Whether the server runs."""
        return self._process.poll() is None

    @property
    def pid(self) -> int:
        """The server's number."""
        return self._process.pid

    def close(self) -> None:
        """End the server; its processes go on until their users close them or end."""
        self._door.close()
        self._process.kill()
        self._process.wait()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


_shared: dict[tuple[int, str], ForkServer] = {}
"""Servers by process and entry; a fork of this process has the servers of its parent here, too."""


def shared_server(entry: str, prepare: str, *, clean: bool = True) -> ForkServer:
    """Return this process's server of an entry, as in `ForkServer`, and start it unless it runs.

    A server that is started ahead imports modules meanwhile. It ends with this process at the latest.
    """
    key = os.getpid(), entry
    if key in _shared and not _shared[key].is_running:  # it was killed, or its user has closed it
        _shared.pop(key).close()
    if key not in _shared:
        _shared[key] = ForkServer(entry, prepare, clean=clean)
        atexit.register(close_server, *key)
    return _shared[key]


def close_server(owner: int, entry: str) -> None:
    """End the shared server of an entry, unless this process was forked from its owner."""
    if os.getpid() == owner and (owner, entry) in _shared:
        _shared.pop((owner, entry)).close()


def serve(entry: str, prepare: str) -> None:
    """Fork a process for each order that comes through stdin, a socket; return when the user has ended."""
    function = _imported(entry)
    _imported(prepare)()
    signal_after_parent(signal.SIGCONT)  # to notice the user's end, even if this process was stopped
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # keepers are not waited for
    gc.collect()
    gc.freeze()  # the garbage collector would write to pages that all forked processes share
    with socket.socket(fileno=os.dup(0)) as door:
        os.dup2(1, 0)
        while True:
            order, descriptors, _, _ = socket.recv_fds(door, 1, len(Files._fields))
            if not order:
                return
            if len(descriptors) == len(Files._fields) and os.fork() == 0:
                door.detach()
                keep(function, Files(*descriptors), _prepare)
            for descriptor in descriptors:
                os.close(descriptor)


def _imported(place: str) -> Callable[..., object]:
    module, _, name = place.partition(":")
    function: Callable[..., object] = getattr(importlib.import_module(module), name)
    return function


def _prepare(connection: socket.socket) -> object:
    """Receive the task of this process, put up its walls if it has any, and return the task."""
    order = receive_document(connection, _Order)
    if order.view is not None:
        _confine(Path(order.folder), order.view)
    return order.task


def _confine(folder: Path, view: View) -> None:
    os.chdir(folder)
    os.umask(0o077)
    os.environ["HOME"] = os.environ["TMPDIR"] = str(folder)
    tempfile.tempdir = str(folder)
    sys.argv[:] = [""]
    find_modules(view.search, view.modules)
    put_up(view, folder)


def _clean_environment() -> Mapping[str, str]:
    return {
        "PATH": "/usr/local/bin:/usr/bin:/bin",
        **{name: os.environ[name] for name in _VARIABLES if name in os.environ},
    }
