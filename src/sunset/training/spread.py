"""Work over frames, spread over processes; how many there are changes no result."""

import hashlib
import os
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from sunset.workers import check_jobs, processors, worker_pool

__all__ = ["Arrays", "Progress", "keep", "spread"]

Arrays: TypeAlias = tuple[npt.NDArray[Any], ...]

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


def keep(
    work: Callable[[Sequence[int]], Arrays], folder: Path | None, *what: object
) -> Callable[[Sequence[int]], Arrays]:
    """Return work that writes each result to a file, and reads it there instead of doing the work again.

    Args:
        work: as `spread` takes it.
        folder: of the files; None to do the work as it is.
        what: everything that results depend on, by its `repr`.
    """
    if folder is None:
        return work
    of_this = folder / hashlib.sha256(repr(what).encode()).hexdigest()[:16]
    of_this.mkdir(parents=True, exist_ok=True)
    return partial(_kept, work, of_this)


def _kept(work: Callable[[Sequence[int]], Arrays], folder: Path, chunk: Sequence[int]) -> Arrays:
    path = folder / f"{chunk[0]}.npz"
    with suppress(EOFError, OSError, ValueError, zipfile.BadZipFile), np.load(path) as arrays:
        return tuple(arrays.values())
    result = work(chunk)
    temporary = path.with_suffix(f".{os.getpid()}.tmp")
    with temporary.open("wb") as file:
        np.savez(file, *result)
    temporary.replace(path)
    return result
