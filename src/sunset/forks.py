"""Processes that are forked from one which has imported already what all of them need.

Python, numpy and DDS take half a second of a processor to load, for every node and again whenever one is redeployed. A
fork server loads them once; a process that it forks is there within milliseconds. The server has one thread, joins no
network and knows nothing of the nodes: it is a module that calls `await_order` when it has imported what is needed.

Both ends of it are here. A request is a JSON list, of arguments for the new process and of variables of its
environment, with two open files: what it reads and what it writes. The answer is its number. A request that is a number
reaps that process, which has ended; the answer is its exit code.
"""

import ctypes
import json
import os
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import IO, Final

ONE_THREAD: Final = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""A node computes little but inference, which has one thread anyway; idle threads cost time to start."""

UNSEEN: Final = 256
"""Takes the place of an exit code that was not seen, since the server was gone."""

_LONGEST: Final = 65536
_FIRST_S: Final = 30.0
"""How long the server may take for its first answer, which comes when it has imported everything."""
_PATIENCE_S: Final = 5.0
"""How long it may take for any other."""
_DEATH_SIGNAL: Final = 1
"""PR_SET_PDEATHSIG of Linux's prctl(2)."""


def can_fork() -> bool:
    """Return whether this system has what a fork server needs."""
    return sys.platform == "linux" and hasattr(os, "pidfd_open")


def signal_after_parent(number: int) -> None:
    """Let this process get a signal when its parent ends, where the system can; even if it is stopped."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_DEATH_SIGNAL, number)


def fill_standard_streams() -> None:
    """Open what is closed of stdin, stdout and stderr, so that no other file takes its descriptor and is written to."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:  # noqa: PLR2004  stderr's
        os.set_inheritable(descriptor, True)
    os.close(descriptor)


class ForkedProcess:
    """A process that a fork server made: as much of `subprocess.Popen` as its user needs.

    Attributes:
        pid: its number.
        stdin: the other end of what it reads.
        stdout: the other end of what it writes, as text.
        returncode: its exit code, as of `Popen`, or `UNSEEN`; None as long as `poll` did not find its end.
    """

    def __init__(self, server: "ForkServer", pid: int, stdin: IO[bytes], stdout: IO[str]) -> None:
        self.pid = pid
        self.stdin = stdin
        self.stdout = stdout
        self.returncode: int | None = None
        self._server = server
        self._handle = os.pidfd_open(pid)
        self._end = select.poll()
        self._end.register(self._handle, select.POLLIN)

    def poll(self) -> int | None:
        """Return the exit code; None while it runs."""
        return self._look(0.0)

    def wait(self) -> int:
        """Wait for its end, and return the exit code."""
        code = self._look(None)
        assert code is not None  # noqa: S101  it waited for it
        return code

    def _look(self, timeout_s: float | None) -> int | None:
        if self.returncode is None and self._end.poll(timeout_s):
            self.returncode = self._server.reap(self.pid)
            os.close(self._handle)
        return self.returncode

    def send_signal(self, number: int) -> None:
        """Send a signal, unless it has ended."""
        if self.poll() is None:
            with suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._handle, number)

    def terminate(self) -> None:
        """Ask it to end."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """End it at once."""
        self.send_signal(signal.SIGKILL)


class ForkServer:
    """A fork server, as its user sees it; it ends with the user's process.

    Args:
        command: what starts a process that calls `await_order` with its stdin as a socket.
        environment: its variables, and those of what it forks.
    """

    def __init__(self, command: Sequence[str], environment: Mapping[str, str]) -> None:
        self._door, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._door.settimeout(_FIRST_S)
        with theirs:
            self._process: subprocess.Popen[bytes] = subprocess.Popen(  # noqa: S603  the command is the caller's
                command,
                stdin=theirs.fileno(),
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=dict(environment),
                start_new_session=True,
            )

    def fork(self, arguments: Sequence[str], environment: Mapping[str, str]) -> ForkedProcess:
        """Return a new process with these arguments, and with variables besides the server's.

        Raises:
            OSError: the server does not answer; it is of no more use.
        """
        their_input, stdin = os.pipe()
        stdout, their_output = os.pipe()
        try:
            pid = self._ask([list(arguments), dict(environment)], [their_input, their_output])
        except OSError:
            os.close(stdin)
            os.close(stdout)
            raise
        finally:
            os.close(their_input)
            os.close(their_output)
        return ForkedProcess(
            self, pid, os.fdopen(stdin, "wb", buffering=0), os.fdopen(stdout, encoding=None, errors="replace")
        )

    def reap(self, pid: int) -> int:
        """Return the exit code of a process that has ended, once; `UNSEEN` if the server is gone."""
        try:
            return self._ask(pid)
        except OSError:
            return UNSEEN

    def _ask(self, order: list[object] | int, files: Sequence[int] = ()) -> int:
        try:
            socket.send_fds(self._door, [json.dumps(order).encode()], list(files))
            answer = self._door.recv(_LONGEST)
            self._door.settimeout(_PATIENCE_S)
        except OSError:
            self.close()
            raise
        if not answer:
            self.close()
            raise ConnectionError("The fork server has ended.")
        return int(answer)

    def close(self) -> None:
        """End the server; what it forked goes on."""
        self._door.close()
        self._process.kill()
        self._process.wait()


_AHEAD: Final[dict[str, ForkServer]] = {}


def fork_server(module: str) -> ForkServer | None:
    """Start a module as a server, unless that was done ahead; it is ready when it has imported what it needs.

    Returns:
        The server, which the caller closes; None where the system lacks what a server needs.
    """
    if not can_fork():
        return None
    return _AHEAD.pop(module, None) or ForkServer(
        (sys.executable, "-m", module), ONE_THREAD | dict(os.environ)
    )


@contextmanager
def started_ahead(module: str) -> Iterator[None]:
    """Start the server of the next `fork_server(module)`, so that it imports what it needs while its user does."""
    server = fork_server(module)
    if server is None:
        yield
        return
    _AHEAD[module] = server
    try:
        yield
    finally:
        _AHEAD.pop(module, None)
        server.close()


def await_order(door: socket.socket) -> list[str] | None:
    """Fork whenever it is asked for at a door: the server's side.

    Returns:
        In each forked process, the arguments that it shall run; in the server None, when its user has gone.
    """
    signal_after_parent(signal.SIGKILL)
    while True:
        order, files, _, _ = socket.recv_fds(door, _LONGEST, 2)
        if not order:
            return None
        wanted = json.loads(order)
        if isinstance(wanted, int):
            answer = os.waitstatus_to_exitcode(os.waitpid(wanted, 0)[1])
        else:
            answer = os.fork()
            if answer == 0:
                door.close()
                arguments, environment = wanted
                os.environ.update(environment)
                _become(arguments, *files)
                return list(arguments)
            for file in files:
                os.close(file)
        door.send(str(answer).encode())


def _become(arguments: list[str], stdin: int, stdout: int) -> None:
    """Make of a copy of the server a process of its own, which goes on when the server ends, even if it is stopped."""
    signal_after_parent(signal.SIGCONT)  # at once, for it may be stopped while it starts
    os.setsid()
    for number, file in enumerate((stdin, stdout, stdout)):
        os.dup2(file, number)
    os.close(stdin)
    os.close(stdout)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(line_buffering=True)  # type: ignore[union-attr]  # as they are at the start of a program
    sys.argv[1:] = arguments
