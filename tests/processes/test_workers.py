import multiprocessing
import os
import threading
from contextlib import suppress
from pathlib import Path

import pytest

from sunset.errors import DataError, InvalidInputError, SunsetError
from sunset.processes import workers
from sunset.processes.workers import processors, spread, worker_pool

pytestmark = pytest.mark.thorough

ITEMS = [0, 1, 3, 6]


def doubled(item: int) -> int:
    return 2 * item


def failing(item: int) -> int:
    if item == 3:
        raise DataError("Number 3 is broken.")
    return item


def dying(item: int) -> int:
    if item == 3:
        os._exit(9)
    return item


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_come_in_order_whoever_makes_them(jobs: int) -> None:
    calls: list[tuple[int, int]] = []
    found = spread(doubled, ITEMS, jobs=jobs, progress=lambda done, total: calls.append((done, total)))
    assert list(found) == [0, 2, 6, 12]
    assert calls == [(1, 4), (2, 4), (3, 4), (4, 4)]


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_error_is_passed_on(jobs: int) -> None:
    with pytest.raises(DataError, match="Number 3 is broken"):
        list(spread(failing, ITEMS, jobs=jobs))


def test_a_process_that_dies_is_told_of() -> None:
    with pytest.raises(SunsetError, match=r"A worker process ended .* with fewer --jobs"):
        list(spread(dying, ITEMS, jobs=2))


def test_only_its_own_processes_end_with_a_pool() -> None:
    with suppress(KeyError), worker_pool(1) as pool:
        pool.submit(doubled, 1).result()
        other = multiprocessing.get_context("fork").Process(target=threading.Event().wait)
        other.start()
        raise KeyError
    assert other.is_alive()
    other.kill()
    other.join()


def test_no_job_at_all_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="at least 1 job, got 0"):
        list(spread(doubled, ITEMS, jobs=0))


def test_there_is_a_processor() -> None:
    assert 1 <= processors() <= (os.cpu_count() or 1)


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("100000 100000\n", 1),
        ("50000 100000\n", 1),
        ("max 100000\n", processors()),
        ("99999999 100000\n", processors()),
        ("\n", processors()),
        (None, processors()),
    ],
)
def test_a_containers_quota_bounds_how_many_workers_there_are(
    text: str | None, count: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if text is not None:
        (tmp_path / "cpu.max").write_text(text)
    monkeypatch.setattr(workers, "_QUOTA", tmp_path / "cpu.max")
    assert processors() == count
