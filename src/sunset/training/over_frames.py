"""Looking at every frame of a set with a model's networks, spread over processes."""

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from sunset import __version__
from sunset.perception import Model, Segmenter, load_model
from sunset.training.batches import FrameSet
from sunset.training.spread import Arrays, Progress, keep, spread

__all__ = ["Images", "over_frames"]

Images: TypeAlias = tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16], npt.NDArray[np.uint8]]
"""A frame: colours, depth and the true labels."""


def over_frames(
    look: Callable[..., Arrays],
    arguments: tuple[object, ...],
    model: Model,
    frames: FrameSet,
    *,
    device: str = "cpu",
    jobs: int | None = None,
    progress: Progress | None = None,
    kept: Path | None = None,
) -> Arrays:
    """Return what a function finds in every frame: its arrays, stacked over the frames.

    Args:
        look: a function of a module, called with a segmenter, the frame's number, its `Images`, and the arguments.
        arguments: with a `repr` that tells them apart.
        model: whose networks the segmenter runs.
        frames: which are looked at one by one.
        device: what the networks run on, as a `Segmenter` takes it.
        jobs: processes; as many as there are processors if None. It has no influence on the result.
        progress: called with frames done and frames in all.
        kept: a folder that keeps what was found, so that an interrupted call loses little; None for nowhere.
    """
    digests = [network.digest for _, network in sorted(model.card.networks.items())]
    what = (__version__, look.__qualname__, arguments, digests, device, kept and frames.digest())
    with TemporaryDirectory(prefix="sunset-") as name:
        frames.save(Path(name))  # where other processes find them
        opening = partial(_opened, model.folder, device, Path(name))
        work = keep(partial(_look_at, look, arguments, opening), kept, *what)
        _opened.cache_clear()  # what the paths name may have changed since this process looked before
        found = list(spread(work, [(index,) for index in range(len(frames))], jobs=jobs, progress=progress))
    return tuple(np.stack(arrays) for arrays in zip(*found, strict=True))


def _look_at(
    look: Callable[..., Arrays],
    arguments: tuple[object, ...],
    opening: Callable[[], tuple[Segmenter, FrameSet]],
    indices: Sequence[int],
) -> Arrays:
    segmenter, frames = opening()
    (index,) = indices
    images = (
        np.asarray(frames.bgr[index]),
        np.asarray(frames.depth[index]),
        np.asarray(frames.labels[index]),
    )
    return look(segmenter, index, images, *arguments)


@lru_cache(maxsize=1)
def _opened(folder: Path, device: str, saved: Path) -> tuple[Segmenter, FrameSet]:
    """Return model and frames, opened once a process."""
    return Segmenter(load_model(folder), device=device), FrameSet.load(saved)
