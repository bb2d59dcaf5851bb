"""Campaigns on an executor: what is not right is told in one sentence, and failures change no result."""

import socket
import subprocess
import sys
from concurrent.futures import Executor
from pathlib import Path
from typing import cast

import pytest

from sunset.errors import InvalidInputError, MissingExtraError
from sunset.experiments import BenchSpec, bench, connected_scheduler
from sunset.experiments.cluster import do_run, labelled_versions

BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "cluster.py"


class _Client:
    def get_executor(self) -> Executor:
        raise NotImplementedError


@pytest.mark.parametrize("executor", [2, "threads", object(), Executor])
def test_what_is_not_an_executor_is_told(executor: object, tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match=r"must be a concurrent\.futures\.Executor, got"):
        bench(BenchSpec(), tmp_path, executor=cast("Executor", executor))


def test_a_client_of_dask_is_told_what_gives_an_executor(tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match=r"it gives one by get_executor\(\)\.$"):
        bench(BenchSpec(), tmp_path, executor=cast("Executor", _Client()))


@pytest.mark.parametrize(
    "address", ["", "localhost", "tcp://localhost", "tcp://a b:1", "tcp://localhost:99999"]
)
def test_what_is_not_an_address_is_told(address: str) -> None:
    pytest.importorskip("distributed")
    with pytest.raises(InvalidInputError, match="No scheduler answers at"), connected_scheduler(address):
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


def test_an_extra_that_is_not_installed_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        pytest.raises(MissingExtraError, match=r"sunset-exemplar\[cluster\]"),
        connected_scheduler("tcp://127.0.0.1:1"),
    ):
        pass


def test_a_worker_with_another_version_is_told() -> None:
    ours = labelled_versions()
    name = next(iter(ours))
    theirs = ours | {name: "0.0"}
    # a worker compares before it opens the order, which here could not be opened
    with pytest.raises(
        InvalidInputError,
        match=f"The worker at .* cannot do a run: its {name} is .*, that of the computer .* is 0.0",
    ):
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
