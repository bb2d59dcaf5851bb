"""Work over frames, spread over processes; how many there are changes no result."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

from sunset.errors import InvalidInputError, SunsetError

__all__ = ["Progress", "processors", "spread"]

Progress = Callable[[int, int], None]
"""Called with how much is done and how much there is."""

Result = TypeVar("Result")


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


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
    if jobs is not None and jobs < 1:
        raise InvalidInputError(f"There must be at least 1 job, got {jobs}.")
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
    with _workers(jobs) as pool:
        yield from pool.map(work, chunks)


@contextmanager
def _workers(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Give worker processes, which end with the context: at once if it ends with an exception."""
    others = multiprocessing.active_children()
    pool = ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn"), initializer=_set_up)
    try:
        yield pool
    except BaseException as error:
        for worker in multiprocessing.active_children():
            if worker not in others:
                worker.terminate()
        if not isinstance(error, BrokenProcessPool):
            raise
        raise SunsetError(
            "A worker process ended in the middle of its work, for instance for want of memory: run the same "
            "command again with fewer --jobs."
        ) from error
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _set_up() -> None:
    """Leave interrupts to the parent, and end when it ends, however it does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_the_parent, daemon=True).start()


def _end_with_the_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
