"""Campaigns on an executor or a scheduler: what is not right is told in one sentence, and failures change no result."""

import socket
import subprocess
import sys
import threading
from concurrent.futures import Executor
from contextlib import suppress
from pathlib import Path

import pytest

from sunset.errors import InvalidInputError, MissingExtraError
from sunset.experiments import connected_scheduler
from sunset.experiments.cluster import check_executor
from sunset.experiments.worker import check_same, do_run, labelled_versions

BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "cluster.py"


class _Client:
    def get_executor(self) -> Executor:
        raise NotImplementedError


@pytest.mark.parametrize("executor", [2, "threads", object(), Executor])
def test_what_is_not_an_executor_is_told(executor: object) -> None:
    with pytest.raises(InvalidInputError, match=r"must be a concurrent\.futures\.Executor, got"):
        check_executor(executor)


def test_a_client_of_dask_is_told_what_gives_an_executor() -> None:
    with pytest.raises(InvalidInputError, match=r"it gives one by get_executor\(\)\.$"):
        check_executor(_Client())


@pytest.mark.parametrize(
    "address", ["", "localhost", "localhost:8786", "tcp://localhost", "http://localhost:8786", "tcp://a b:1"]
)
def test_what_is_not_an_address_is_told(address: str) -> None:
    pytest.importorskip("distributed")
    with pytest.raises(InvalidInputError, match="must be tcp://HOST:PORT"), connected_scheduler(address):
        pass


def test_a_port_where_nothing_listens_is_told() -> None:
    pytest.importorskip("distributed")
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with (
        pytest.raises(InvalidInputError, match=r"No scheduler answers at .*start one with 'dask scheduler'"),
        connected_scheduler(f"tcp://127.0.0.1:{port}"),
    ):
        pass


@pytest.mark.parametrize("said", [b"SSH-2.0-OpenSSH_9.2\r\n", b"\0" * 100_000])
def test_what_speaks_and_is_not_a_scheduler_is_told(said: bytes) -> None:
    pytest.importorskip("distributed")

    def speak(door: socket.socket) -> None:
        connection, _ = door.accept()
        with connection, suppress(OSError):
            connection.sendall(said)

    with socket.create_server(("127.0.0.1", 0)) as door:
        threading.Thread(target=speak, args=(door,), daemon=True).start()
        address = f"tcp://127.0.0.1:{door.getsockname()[1]}"
        with pytest.raises(InvalidInputError, match="is not a scheduler"), connected_scheduler(address):
            pass


@pytest.mark.thorough
def test_a_worker_that_dask_has_paused_is_named(caplog: pytest.LogCaptureFixture) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        processes=False,
        protocol="tcp://",
        dashboard_address=None,
        memory_limit=0,  # so that dask itself neither pauses it nor lets it go on
    ) as cluster:
        with connected_scheduler(cluster.scheduler_address):
            assert "is paused" not in caplog.text
        cluster.workers[0].status = distributed.core.Status.paused
        with connected_scheduler(cluster.scheduler_address):
            assert "is paused, as dask does where memory is short" in caplog.text


def test_an_extra_that_is_not_installed_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sunset.experiments.cluster.find_spec", {}.get)
    with (
        pytest.raises(MissingExtraError, match=r"sunset-exemplar\[cluster\]"),
        connected_scheduler("tcp://127.0.0.1:1"),
    ):
        pass


def test_a_worker_with_another_version_is_told() -> None:
    ours = labelled_versions()
    name = next(iter(ours))
    theirs = ours | {name: "0.0"}
    with pytest.raises(InvalidInputError, match=f"its {name} is 0.0, that of the computer which began"):
        check_same(theirs, ours)
    # a worker compares before it opens the order, which here could not be opened
    with pytest.raises(InvalidInputError, match=f"The worker at .* cannot do a run: its {name} is"):
        do_run(theirs, b"not a pickle")


@pytest.mark.thorough
@pytest.mark.xdist_group("campaign")
def test_a_cluster_that_fails_changes_no_result() -> None:
    pytest.importorskip("distributed")
    done = subprocess.run(
        [sys.executable, str(BENCHMARK), "--scenarios", "1"], check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "one of two workers is killed" in done.stdout
    assert "the scheduler is killed" in done.stdout
    assert "are byte for byte those of the campaign with --jobs 2" in done.stdout
