"""Pools of worker processes; their number changes no result."""

import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, nullcontext, suppress
from math import ceil
from multiprocessing.context import ForkContext, ForkProcess, SpawnContext, SpawnProcess
from multiprocessing.process import BaseProcess
from pathlib import Path
from types import ModuleType
from typing import Any, Final, TypeVar

from sunset.errors import InvalidInputError, SunsetError
from sunset_ros.texts import shown

_QUOTA: Final = Path("/sys/fs/cgroup/cpu.max")
"""A container's quota of the processors' time, and its period."""

_STARTING: Final = threading.Lock()

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

Progress = Callable[[int, int], None]
"""Called with the number of finished items, and of all."""

Stages = Callable[[str, int, int], None]
"""Called with the name of a stage, the number of its finished items, and of all its items."""


def processors() -> int:
    """Return how many processors this process may use, a container's quota rounded up."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    with suppress(OSError, ValueError):  # outside of containers, the file is missing, or its quota is "max"
        quota, period = map(int, _QUOTA.read_text(encoding="utf-8").split())
        count = min(count, ceil(quota / period))
    return max(count, 1)


def check_jobs(jobs: int | None) -> None:
    """Check a number of worker processes, where None stands for any.

    Raises:
        InvalidInputError: the number is not an integer of at least 1.
    """
    if jobs is not None and (isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1):
        raise InvalidInputError(f"There must be at least 1 job, got {shown(jobs)}.")


class _Worker(SpawnProcess):
    """A spawned process that does not import the script `__main__`, which would do its work again."""

    def start(self) -> None:
        with _STARTING:
            script = sys.modules["__main__"]
            sys.modules["__main__"] = ModuleType("__main__")
            try:
                super().start()
            finally:
                sys.modules["__main__"] = script


@contextmanager
def worker_pool(jobs: int, *, forked: bool = False) -> Iterator[ProcessPoolExecutor]:
    """Give a pool of worker processes, which end with the context: at once if it ends with an exception.

    They also end with this process. They ignore interrupts, print to stderr, and do not import the script `__main__`.

    Args:
        jobs: the number of processes.
        forked: whether they are copies of this process, with the classes that it has defined.

    Raises:
        InvalidInputError: this process cannot have worker processes.
        SunsetError: a worker process was killed.
    """
    workers: list[BaseProcess] = []
    pool = _new_pool(jobs, workers, forked=forked)
    try:
        with warnings.catch_warnings():
            if forked:  # Python 3.12 warns of other threads, which the workers do not need
                warnings.simplefilter("ignore", DeprecationWarning)
            yield pool
    except BaseException as error:
        for worker in workers:
            if worker.is_alive():
                worker.terminate()
        if not isinstance(error, BrokenProcessPool):
            raise
        raise SunsetError(
            "A worker process ended early: it was killed, perhaps for lack of memory. Finished work is kept: "
            "run the same command again, with fewer --jobs "
            "if memory was short."
        ) from error
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _new_pool(jobs: int, workers: list[BaseProcess], *, forked: bool) -> ProcessPoolExecutor:
    """Return a pool that appends its processes to a list."""
    if multiprocessing.current_process().daemon:
        raise InvalidInputError(
            "A daemonic process, such as one of multiprocessing.Pool, can have no worker processes: use "
            "concurrent.futures.ProcessPoolExecutor."
        )

    def start(**options: Any) -> BaseProcess:
        workers.append(ForkProcess(**options) if forked else _Worker(**options))
        return workers[-1]

    context = ForkContext() if forked else SpawnContext()
    context.Process = start  # type: ignore[misc, assignment]  # the pool calls it for each worker
    try:
        return ProcessPoolExecutor(jobs, mp_context=context, initializer=_set_up)
    except OSError as error:
        raise SunsetError(
            f"Several processes need shared memory, which the system refused ({error.strerror}): let /dev/shm be "
            "written to, or do with --jobs 1."
        ) from error


def spread(
    work: Callable[[_Item], _Result],
    items: Sequence[_Item],
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Iterator[_Result]:
    """Yield the result of every item, in the order of the items.

    Args:
        work: a function of a module, or a `partial` of one, since other processes import it.
        items: its arguments.
        jobs: worker processes, or None for as many as there are processors. With a single job, this process works.
        progress: called after each item.

    Raises:
        InvalidInputError: `jobs` is less than 1.
        SunsetError: a worker process was killed, or `work` raised it.
    """
    check_jobs(jobs)
    count = min(jobs or processors(), max(len(items), 1))
    with nullcontext() if count == 1 else worker_pool(count) as pool:
        results = pool.map(work, items) if pool else map(work, items)
        for done, result in enumerate(results, 1):
            yield result
            if progress is not None:
                progress(done, len(items))


def _set_up() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stdout = sys.stderr
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
