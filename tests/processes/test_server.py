"""A server forks processes that are like any others, and ends with its user."""

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from sunset.processes.process import Process
from sunset.processes.server import ForkServer, close_server, shared_server

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc"),
    pytest.mark.thorough,
]

ENTRY, PREPARE = "programs:execute", "programs:nothing"
ENDLESS = "import threading; threading.Event().wait()"
PATIENCE_S = 60.0


@pytest.fixture(autouse=True)
def modules(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    monkeypatch.setenv("COLOUR", "green")


@pytest.fixture
def server() -> Iterator[ForkServer]:
    with ForkServer(ENTRY, PREPARE, clean=False) as server:
        yield server


def eventually(holds: Callable[[], object]) -> bool:
    limit = time.monotonic() + PATIENCE_S
    while not holds() and time.monotonic() < limit:
        time.sleep(0.01)  # noqa: TID251  another process is waited for
    return bool(holds())


def exists(pid: int) -> bool:
    return Path(f"/proc/{pid}").exists()


def read(process: Process) -> str:
    with process.take_output() as output:
        return output.read()


def test_a_process_has_an_output_and_an_exit_code(server: ForkServer) -> None:
    with server.start("print('Hello'); sys.stderr.write('world'); sys.exit(3)") as process:
        assert read(process) == "Hello\nworld"
        assert process.join(time.monotonic() + PATIENCE_S)
        assert process.returncode == 3


def test_a_process_sees_the_end_of_its_connection(server: ForkServer) -> None:
    with (
        server.start("connection.recv(1)") as first,
        server.start(ENDLESS) as second,  # which must not hold the other end of the first one's connection
    ):
        assert second.pid
        first.socket.shutdown(2)
        assert first.join(time.monotonic() + PATIENCE_S)
        assert first.returncode == 0
        second.kill()
        assert second.returncode == -signal.SIGKILL


def test_a_signal_ends_a_process_and_a_late_signal_does_nothing(server: ForkServer) -> None:
    with server.start(ENDLESS) as process:
        process.send_signal(signal.SIGTERM)
        assert process.join(time.monotonic() + PATIENCE_S)
        process.kill()
        assert process.returncode == -signal.SIGTERM


def test_a_process_has_the_environment_and_is_a_session_of_its_own(server: ForkServer) -> None:
    with server.start("print(os.environ['COLOUR'], os.getsid(0) == os.getpid())") as process:
        assert read(process) == "green True\n"


def test_a_process_outlives_the_server_and_its_end_is_seen(server: ForkServer) -> None:
    with server.start("print('up'); connection.recv(1); sys.exit(4)") as process:
        assert process.pid
        os.kill(server.pid, signal.SIGKILL)
        assert eventually(lambda: not server.is_running)
        assert not process.ended
        process.socket.send(b"!")
        assert process.join(time.monotonic() + PATIENCE_S)
        assert process.returncode == 4


def test_a_process_ends_with_its_keeper(server: ForkServer) -> None:
    with server.start("print(os.getppid());" + ENDLESS) as process:
        with process.take_output() as output:
            os.kill(int(output.readline()), signal.SIGKILL)
            assert process.join(time.monotonic() + PATIENCE_S)
            assert process.returncode is None
        assert eventually(lambda: not exists(process.pid))


def test_a_server_that_is_started_ahead_is_shared_until_it_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WHEN", "before")
    first = shared_server(ENTRY, PREPARE, clean=False)
    monkeypatch.setenv("WHEN", "after")
    assert shared_server(ENTRY, PREPARE, clean=False) is first
    with first.start("print(os.environ['WHEN'])") as process:
        assert read(process) == "before\n"
    first.close()
    second = shared_server(ENTRY, PREPARE, clean=False)
    with second.start("print(os.environ['WHEN'])") as process:
        assert read(process) == "after\n"
    close_server(os.getpid(), ENTRY)
    assert not second.is_running
