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
from multiprocessing.synchronize import Event
from pathlib import Path
from traceback import walk_stack
from typing import TypeVar

from sunset.errors import InvalidInputError, SunsetError
from sunset.texts import shown

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

Progress = Callable[[int, int], None]
"""Called with how much is done and how much there is."""

Stages = Callable[[str, int, int], None]
"""Called with what is being done, how much of it is done, and how much there is."""


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def check_jobs(jobs: int | None) -> None:
    """Make sure that a number of worker processes, None for any, is one.

    Raises:
        InvalidInputError: it is less than 1, or no whole number.
    """
    if jobs is not None and (isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1):
        raise InvalidInputError(f"There must be at least 1 job, got {shown(jobs)}.")


def end_if_imported() -> None:
    """End this process at once if it is a worker process that still imports the script whose work it is to do.

    It would do all of the script's work again. Its parent says what is wrong.
    """
    for frame, _ in walk_stack(None):
        if frame.f_code.co_name == "<module>" and frame.f_globals.get("__name__") == "__mp_main__":
            os._exit(1)


def _check_caller(*, forked: bool) -> None:
    """Make sure that this process can have worker processes.

    Raises:
        InvalidInputError: it is one of `multiprocessing.Pool`, or its script cannot be imported.
    """
    if multiprocessing.current_process().daemon:
        raise InvalidInputError(
            "A daemonic process, such as one of multiprocessing.Pool, can have no worker processes: use "
            "concurrent.futures.ProcessPoolExecutor."
        )
    main = sys.modules["__main__"]
    script = getattr(main, "__file__", None) if main.__spec__ is None else None
    if script is not None and not forked and not Path(script).is_file():
        raise InvalidInputError(
            f"Worker processes import the script that calls this, and {script} is not a file: save it as one, with "
            "the call below 'if __name__ == \"__main__\":'."
        )


@contextmanager
def worker_pool(jobs: int, *, forked: bool = False) -> Iterator[ProcessPoolExecutor]:
    """Give worker processes, which end with the context: at once if it ends with an exception.

    They also end when this process does, however it does. They leave interrupts to it, and print to stderr.

    Args:
        jobs: how many there are.
        forked: whether they have what this process has defined, instead of importing what they need.

    Raises:
        InvalidInputError: this process can have none, or its script does not let itself be imported.
        SunsetError: a worker process was killed.
    """
    end_if_imported()
    _check_caller(forked=forked)
    others = multiprocessing.active_children()
    context = multiprocessing.get_context("fork" if forked else "spawn")
    begun = context.Event()
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_set_up, initargs=(begun,))
    try:
        with warnings.catch_warnings():
            if forked:  # of Python from 3.12 on; the other threads that there may be are not needed there
                warnings.simplefilter("ignore", DeprecationWarning)
            yield pool
    except BaseException as error:
        # nobody waits for results that are not wanted any more
        for worker in multiprocessing.active_children():
            if worker not in others:
                worker.terminate()
        if not isinstance(error, BrokenProcessPool):
            raise
        if not begun.is_set():
            raise InvalidInputError(
                "Worker processes import the script that calls this, and ended while they did: the call must stand "
                "below 'if __name__ == \"__main__\":'."
            ) from None
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


def _set_up(begun: Event) -> None:
    begun.set()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stdout = sys.stderr
    threading.Thread(target=_end_with_the_parent, daemon=True).start()


def _end_with_the_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
