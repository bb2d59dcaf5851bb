"""Looking at frames with the networks of a model, spread over processes."""

import hashlib
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import lru_cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias, TypedDict, Unpack

import numpy as np
import numpy.typing as npt

from sunset import __version__
from sunset.classes import CLASS_OF_CARLA_ID
from sunset.data import read_bag
from sunset.files.outputs import draft_of
from sunset.perception import Model, Segmenter, load_model
from sunset.processes.workers import Progress, spread
from sunset_lab.batches import FrameSet, Images

Arrays: TypeAlias = tuple[npt.NDArray[Any], ...]


class LookOptions(TypedDict, total=False):
    """The options of `over_frames`.

    Attributes:
        device: of the networks, as a `Segmenter` takes it; the processor by default.
        jobs: processes; by default as many as there are processors. The result does not depend on it.
        progress: called with (frames done, frames in all).
        kept: a folder that keeps the results for a set, so that an interrupted call loses little.
    """

    device: str
    jobs: int | None
    progress: Progress | None
    kept: Path | None


def over_frames(
    look: Callable[..., Arrays],
    arguments: tuple[object, ...],
    model: Model,
    frames: FrameSet | Path,
    chosen: Sequence[int] | None = None,
    **options: Unpack[LookOptions],
) -> Arrays:
    """Return the arrays that a function returns for each frame, stacked over the frames.

    Args:
        look: a function of a module, called with a segmenter, the frame's number, its `Images`, and the arguments.
        arguments: distinguished by their `repr`.
        model: its networks are run by the segmenter.
        frames: a set, or a bag, whose frames are resampled to the model's size.
        chosen: the numbers of the frames; all of a set if None.
        **options: see `LookOptions`.
    """
    device, kept = options.get("device", "cpu"), options.get("kept")
    with _on_disk(frames) as place:
        opening = partial(_opened, model.folder, device, place, isinstance(frames, FrameSet))
        work: Callable[[int], Arrays] = partial(_look_at, look, arguments, opening)
        if isinstance(frames, FrameSet):
            digests = [network.digest for _, network in sorted(model.card.networks.items())]
            origin = (__version__, look.__qualname__, arguments, digests, device, kept and frames.digest())
            work = keep(work, kept, *origin)
            chosen = range(len(frames)) if chosen is None else chosen
        _opened.cache_clear()  # the files may have changed since this process opened them
        rows = list(spread(work, chosen or (), jobs=options.get("jobs"), progress=options.get("progress")))
    return tuple(np.stack(arrays) for arrays in zip(*rows, strict=True))


@contextmanager
def _on_disk(frames: FrameSet | Path) -> Iterator[Path]:
    """Give the place where other processes read the frames."""
    if isinstance(frames, Path):
        yield frames
        return
    with TemporaryDirectory(prefix="sunset-") as name:
        frames.save(Path(name))
        yield Path(name)


def _look_at(
    look: Callable[..., Arrays],
    arguments: tuple[object, ...],
    opening: Callable[[], tuple[Segmenter, Callable[[int], Images]]],
    index: int,
) -> Arrays:
    segmenter, images = opening()
    return look(segmenter, index, images(index), *arguments)


@lru_cache(maxsize=1)
def _opened(folder: Path, device: str, place: Path, saved: bool) -> tuple[Segmenter, Callable[[int], Images]]:
    """Return a model's segmenter, and a function that reads frames; both are opened once in each process."""
    model = load_model(folder)
    if saved:
        return Segmenter(model, device=device), FrameSet.load(place).images
    bag = read_bag(place, size=(model.card.height, model.card.width))

    def images(index: int) -> Images:
        frame = bag.frame(index)
        return frame.rgb, frame.depth, CLASS_OF_CARLA_ID[frame.labels]

    return Segmenter(model, device=device), images


def keep(work: Callable[[int], Arrays], folder: Path | None, *origin: object) -> Callable[[int], Arrays]:
    """Return a function that keeps each result of `work` in a file, and reads it on the next call.

    `origin` is everything that the results depend on, by its `repr`. Without a folder, `work` itself is returned.
    """
    if folder is None:
        return work
    own = folder / hashlib.sha256(repr(origin).encode()).hexdigest()[:16]
    own.mkdir(parents=True, exist_ok=True)
    return partial(_kept, work, own)


def _kept(work: Callable[[int], Arrays], folder: Path, index: int) -> Arrays:
    path = folder / f"{index}.npz"
    with suppress(EOFError, OSError, ValueError, zipfile.BadZipFile), np.load(path) as arrays:
        return tuple(arrays.values())
    result = work(index)
    with draft_of(path) as draft, draft.open("wb") as file:
        np.savez(file, *result)
    return result
