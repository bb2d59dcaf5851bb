"""Work over frames, spread over processes; how many there are changes no result."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from sunset.workers import check_jobs, processors, worker_pool

__all__ = ["Progress", "spread"]

Progress = Callable[[int, int], None]
"""Called with how much is done and how much there is."""

Result = TypeVar("Result")


def spread(
    work: Callable[[Sequence[int]], Result],
    chunks: Sequence[Sequence[int]],
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Iterator[Result]:
    """Yield the result of every chunk, in their order.

    Args:
        work: a function of a module, or a `partial` of one, since it goes to other processes.
        chunks: the numbers of the frames of each piece of work.
        jobs: processes; as many as there are processors if None. With one it is this process.
        progress: called with frames done and frames in all.

    Raises:
        InvalidInputError: `jobs` is less than 1.
        SunsetError: a worker process was killed, or what `work` raised.
    """
    check_jobs(jobs)
    count = min(jobs or processors(), max(len(chunks), 1))
    total, done = sum(map(len, chunks)), 0
    for chunk, result in zip(chunks, _results(work, chunks, count), strict=True):
        yield result
        done += len(chunk)
        if progress is not None:
            progress(done, total)


def _results(
    work: Callable[[Sequence[int]], Result], chunks: Sequence[Sequence[int]], jobs: int
) -> Iterator[Result]:
    if jobs == 1:
        yield from map(work, chunks)
        return
    with worker_pool(jobs) as pool:
        yield from pool.map(work, chunks)
