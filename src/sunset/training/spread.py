"""Work over frames, spread over processes; how many there are changes no result."""

import hashlib
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext, suppress
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from sunset.output_files import draft_of
from sunset.workers import Progress, check_jobs, processors, worker_pool

Arrays: TypeAlias = tuple[npt.NDArray[Any], ...]

Item = TypeVar("Item")
Result = TypeVar("Result")


def spread(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Iterator[Result]:
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


def keep(work: Callable[[int], Arrays], folder: Path | None, *what: object) -> Callable[[int], Arrays]:
    """Return work on numbers of frames that writes each result to a file, and reads it instead of being done again.

    `what` is everything that results depend on, by its `repr`. Without a folder, the work is done as it is.
    """
    if folder is None:
        return work
    of_this = folder / hashlib.sha256(repr(what).encode()).hexdigest()[:16]
    of_this.mkdir(parents=True, exist_ok=True)
    return partial(_kept, work, of_this)


def _kept(work: Callable[[int], Arrays], folder: Path, index: int) -> Arrays:
    path = folder / f"{index}.npz"
    with suppress(EOFError, OSError, ValueError, zipfile.BadZipFile), np.load(path) as arrays:
        return tuple(arrays.values())
    result = work(index)
    with draft_of(path) as draft, draft.open("wb") as file:
        np.savez(file, *result)
    return result
