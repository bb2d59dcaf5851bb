"""Looking at frames with a model's networks, spread over processes."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from sunset import __version__
from sunset.classes import CLASS_OF_CARLA_ID
from sunset.data import read_bag
from sunset.perception import Model, Segmenter, load_model
from sunset.processes.workers import Progress, spread
from sunset.training.batches import FrameSet
from sunset.training.spread import Arrays, keep

Images: TypeAlias = tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16], npt.NDArray[np.uint8]]
"""A frame: colours, depth and the true labels."""


def over_frames(
    look: Callable[..., Arrays],
    arguments: tuple[object, ...],
    model: Model,
    frames: FrameSet | Path,
    *,
    chosen: Sequence[int] | None = None,
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
        frames: a set, or a bag, whose frames are resampled to the model's size.
        chosen: the numbers of those that are looked at; all of a set if None.
        device: what the networks run on, as a `Segmenter` takes it.
        jobs: processes; as many as there are processors if None. It has no influence on the result.
        progress: called with frames done and frames in all.
        kept: a folder that keeps what was found in a set, so that an interrupted call loses little; None for nowhere.
    """
    with _on_disk(frames) as place:
        opening = partial(_opened, model.folder, device, place, isinstance(frames, FrameSet))
        work: Callable[[int], Arrays] = partial(_look_at, look, arguments, opening)
        if isinstance(frames, FrameSet):
            digests = [network.digest for _, network in sorted(model.card.networks.items())]
            what = (__version__, look.__qualname__, arguments, digests, device, kept and frames.digest())
            work = keep(work, kept, *what)
            chosen = range(len(frames)) if chosen is None else chosen
        _opened.cache_clear()  # what the paths name may have changed since this process looked before
        found = list(spread(work, chosen or (), jobs=jobs, progress=progress))
    return tuple(np.stack(arrays) for arrays in zip(*found, strict=True))


@contextmanager
def _on_disk(frames: FrameSet | Path) -> Iterator[Path]:
    """Give the place where other processes find frames."""
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
    """Return model and what gives the frames, opened once a process."""
    model = load_model(folder)
    if saved:
        return Segmenter(model, device=device), FrameSet.load(place).images
    bag = read_bag(place, size=(model.card.height, model.card.width))

    def images(index: int) -> Images:
        frame = bag.frame(index)
        return frame.rgb, frame.depth, CLASS_OF_CARLA_ID[frame.labels]

    return Segmenter(model, device=device), images
