"""A fork server makes processes that are like any others."""

import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from sunset.forks import UNSEEN, ForkedProcess, ForkServer, can_fork, fork_server, started_ahead

pytestmark = [
    pytest.mark.skipif(not can_fork(), reason="only Linux has what a fork server needs"),
    pytest.mark.thorough,
]

PROGRAM = """
import os, socket, sys
from sunset.forks import await_order
with socket.socket(fileno=os.dup(0)) as door:
    words = await_order(door)
exec("" if words is None else words[-1])
"""
SERVER = (sys.executable, "-c", PROGRAM)
ENDLESS = "import threading; threading.Event().wait()"


@pytest.fixture
def server() -> Iterator[ForkServer]:
    made = ForkServer(SERVER, os.environ | {"COLOUR": "green"})
    yield made
    made.close()


def spoken(process: ForkedProcess) -> str:
    with process.stdout:
        return process.stdout.read()


def ended(process: ForkedProcess) -> int:
    """Return the exit code of a process whose streams nobody needs any more."""
    process.stdout.close()
    process.stdin.close()
    return process.wait()


def test_it_has_streams_of_its_own_and_an_exit_code(server: ForkServer) -> None:
    process = server.fork(["node", "print('Hello', input()); sys.stderr.write('well'); sys.exit(3)"], {})
    assert process.poll() is None
    process.stdin.write(b"world\n")
    assert spoken(process) == "Hello world\nwell"
    assert ended(process) == 3
    assert process.poll() == 3


def test_it_sees_the_end_of_its_input(server: ForkServer) -> None:
    first = server.fork(["sys.stdin.read()"], {})
    second = server.fork([ENDLESS], {})  # which must not hold the other end of the first one's pipe
    first.stdin.close()
    assert ended(first) == 0
    second.kill()
    assert ended(second) == -signal.SIGKILL


def test_a_signal_ends_it_and_a_late_one_does_nothing(server: ForkServer) -> None:
    process = server.fork([ENDLESS], {})
    process.terminate()
    assert ended(process) == -signal.SIGTERM
    process.kill()
    assert process.poll() == -signal.SIGTERM


def test_it_has_the_environment_and_is_a_session_of_its_own(server: ForkServer) -> None:
    said = "print(os.environ['COLOUR'], os.environ['SIZE'], os.getsid(0) == os.getpid(), sys.argv[1])"
    process = server.fork(["depth", said], {"SIZE": "7"})
    assert spoken(process) == "green 7 True depth\n"
    assert ended(process) == 0


def test_a_process_outlives_the_server_but_nobody_sees_its_end(server: ForkServer) -> None:
    process = server.fork(["print(os.getppid()); input()"], {})
    os.kill(int(process.stdout.readline()), signal.SIGKILL)
    with pytest.raises(OSError, match=r"\w"):
        server.fork(["pass"], {})
    assert process.poll() is None
    process.stdin.write(b"\n")
    assert ended(process) == UNSEEN


def test_a_stopped_process_goes_on_when_the_server_ends(server: ForkServer) -> None:
    process = server.fork(
        ["import signal; print(os.getppid()); signal.raise_signal(signal.SIGSTOP); print('on')"], {}
    )
    parent = int(process.stdout.readline())
    stat = Path(f"/proc/{process.pid}/stat")
    while stat.read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "T":
        threading.Event().wait(0.01)
    os.kill(parent, signal.SIGKILL)
    assert spoken(process) == "on\n"
    assert ended(process) == UNSEEN


def test_the_server_ends_when_nobody_can_order_any_more() -> None:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with theirs, ours, subprocess.Popen(SERVER, stdin=theirs.fileno()) as process:
        theirs.close()
        ours.close()
        assert process.wait() == 0


def test_a_server_that_was_started_ahead_is_used_once_and_ends_in_any_case(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "ahead.py").write_text(PROGRAM, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("WHEN", "before")
    with started_ahead("ahead"):
        monkeypatch.setenv("WHEN", "after")
        said = []
        for _ in range(2):
            server = fork_server("ahead")
            assert server is not None
            process = server.fork(["print(os.environ['WHEN'])"], {})
            said.append(spoken(process))
            process.stdin.close()
            server.close()
    assert said == ["before\n", "after\n"]
    with started_ahead("ahead"):
        pass
    server = fork_server("ahead")
    assert server is not None
    process = server.fork(["print(os.environ['WHEN'])"], {})
    assert spoken(process) == "after\n"
    process.stdin.close()
    server.close()
