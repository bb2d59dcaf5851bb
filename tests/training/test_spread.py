import os
from collections.abc import Sequence

import pytest

from sunset.errors import DataError, InvalidInputError, SunsetError
from sunset.training.spread import spread
from sunset.workers import processors

pytestmark = pytest.mark.thorough

CHUNKS = [(0,), (1, 2), (3, 4, 5), (6,)]


def doubled(chunk: Sequence[int]) -> list[int]:
    return [2 * number for number in chunk]


def failing(chunk: Sequence[int]) -> int:
    if 3 in chunk:
        raise DataError("Number 3 is broken.")
    return len(chunk)


def dying(chunk: Sequence[int]) -> int:
    if 3 in chunk:
        os._exit(9)
    return len(chunk)


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_come_in_order_whoever_makes_them(jobs: int) -> None:
    calls: list[tuple[int, int]] = []
    found = spread(doubled, CHUNKS, jobs=jobs, progress=lambda done, total: calls.append((done, total)))
    assert list(found) == [[0], [2, 4], [6, 8, 10], [12]]
    assert calls == [(1, 7), (3, 7), (6, 7), (7, 7)]


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_error_is_passed_on(jobs: int) -> None:
    with pytest.raises(DataError, match="Number 3 is broken"):
        list(spread(failing, CHUNKS, jobs=jobs))


def test_a_process_that_dies_is_told_of() -> None:
    with pytest.raises(SunsetError, match=r"A worker process ended .* with fewer --jobs"):
        list(spread(dying, CHUNKS, jobs=2))


def test_no_job_at_all_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="at least 1 job, got 0"):
        list(spread(doubled, CHUNKS, jobs=0))


def test_there_is_a_processor() -> None:
    assert 1 <= processors() <= (os.cpu_count() or 1)
