"""Worker processes: how many there are changes no result."""

import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, nullcontext
from math import ceil
from multiprocessing.context import ForkContext, ForkProcess, SpawnContext, SpawnProcess
from multiprocessing.process import BaseProcess
from pathlib import Path
from types import ModuleType
from typing import Any, Final, TypeVar

from sunset.errors import InvalidInputError, SunsetError
from sunset.texts import shown

_QUOTAS: Final = (
    [Path("/sys/fs/cgroup/cpu.max")],
    [Path("/sys/fs/cgroup/cpu/cpu.cfs_quota_us"), Path("/sys/fs/cgroup/cpu/cpu.cfs_period_us")],
)
"""Where a container reads its quota of the processors' time and the period for that, in both versions of cgroups."""

_STARTING: Final = threading.Lock()

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

Progress = Callable[[int, int], None]
"""Called with how much is done and how much there is."""

Stages = Callable[[str, int, int], None]
"""Called with what is being done, how much of it is done, and how much there is."""


def processors() -> int:
    """Return how many processors this process may use, a container's quota rounded up."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    for files in _QUOTAS:
        try:
            quota, period = " ".join(file.read_text(encoding="utf-8") for file in files).split()
        except (OSError, ValueError):
            continue
        if quota.isdecimal():  # neither "max" nor -1
            count = min(count, ceil(int(quota) / int(period)))
    return max(count, 1)


def check_jobs(jobs: int | None) -> None:
    """Make sure that a number of worker processes, None for any, is one.

    Raises:
        InvalidInputError: it is less than 1, or no whole number.
    """
    if jobs is not None and (isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1):
        raise InvalidInputError(f"There must be at least 1 job, got {shown(jobs)}.")


class _Worker(SpawnProcess):
    """A process that imports what it is to do, and not the script whose work that is, which would do it again."""

    def start(self) -> None:
        """Start it; meanwhile there is no script that Python could have it import."""
        with _STARTING:
            script = sys.modules["__main__"]
            sys.modules["__main__"] = ModuleType("__main__")
            try:
                super().start()
            finally:
                sys.modules["__main__"] = script


def _check_caller() -> None:
    """Make sure that this process can have worker processes.

    Raises:
        InvalidInputError: it is one of `multiprocessing.Pool`.
    """
    if multiprocessing.current_process().daemon:
        raise InvalidInputError(
            "A daemonic process, such as one of multiprocessing.Pool, can have no worker processes: use "
            "concurrent.futures.ProcessPoolExecutor."
        )


@contextmanager
def worker_pool(jobs: int, *, forked: bool = False) -> Iterator[ProcessPoolExecutor]:
    """Give worker processes, which end with the context: at once if it ends with an exception.

    They also end when this process does, however it does. They leave interrupts to it, and print to stderr. They do not
    import the script that this process runs, which therefore needs no guard.

    Args:
        jobs: how many there are.
        forked: whether they have what this process has defined, instead of importing what they need.

    Raises:
        InvalidInputError: this process can have none.
        SunsetError: a worker process was killed.
    """
    _check_caller()
    context = ForkContext() if forked else SpawnContext()
    workers: list[BaseProcess] = []

    def make(**options: Any) -> BaseProcess:
        workers.append(ForkProcess(**options) if forked else _Worker(**options))
        return workers[-1]

    context.Process = make  # type: ignore[misc, assignment]  # what the pool calls it for
    try:
        pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_set_up)
    except OSError as error:
        raise SunsetError(
            f"Several processes need shared memory, which the system refused ({error.strerror}): let /dev/shm be "
            "written to, or do with --jobs 1."
        ) from error
    try:
        with warnings.catch_warnings():
            if forked:  # of Python from 3.12 on; the other threads that there may be are not needed there
                warnings.simplefilter("ignore", DeprecationWarning)
            yield pool
    except BaseException as error:
        # the results of running workers are not wanted any more
        for worker in workers:
            if worker.is_alive():
                worker.terminate()
        if not isinstance(error, BrokenProcessPool):
            raise
        raise SunsetError(
            "A worker process ended in the middle of its work: it was killed, for instance for want of memory; what "
            "was finished is kept: run the same command again, with fewer --jobs "
            "if memory was short."
        ) from error
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def spread(
    work: Callable[[_Item], _Result],
    items: Sequence[_Item],
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Iterator[_Result]:
    """Yield the result of every item, in their order.

    Args:
        work: a function of a module, or a `partial` of one, since it goes to other processes.
        items: what it is called with, one by one.
        jobs: processes; as many as there are processors if None. With one it is this process.
        progress: called with items done and items in all.

    Raises:
        InvalidInputError: `jobs` is less than 1.
        SunsetError: a worker process was killed, or what `work` raised.
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
    threading.Thread(target=_end_with_the_parent, daemon=True).start()


def _end_with_the_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
