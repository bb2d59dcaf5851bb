"""Work over frames whose results are kept."""

import hashlib
import zipfile
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from sunset.output_files import draft_of

Arrays: TypeAlias = tuple[npt.NDArray[Any], ...]


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
