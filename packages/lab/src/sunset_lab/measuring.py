"""Looking at frames with the networks of a model, spread over processes; and the IoU that they reach."""

import hashlib
import zipfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, TypeAlias, TypedDict, Unpack

import numpy as np
import numpy.typing as npt

from sunset import __version__
from sunset.classes import CLASS_OF_CARLA_ID
from sunset.data import BagReader, read_bag
from sunset.files.outputs import draft_of
from sunset.metrics import ClassCounts, class_iou, count_classes
from sunset.metrics.timeline import Counts
from sunset.perception import Modality, Model, Segmenter, load_model
from sunset.processes.workers import Progress, spread
from sunset_lab.frames import FrameSet, Images

Arrays: TypeAlias = tuple[npt.NDArray[Any], ...]
_Item: TypeAlias = tuple[int, Images | None]
"""A frame's number, and its images unless they are in a bag."""
_Floats: TypeAlias = npt.NDArray[np.float64]


class LookOptions(TypedDict, total=False):
    """The options of `over_frames`."""

    device: str
    """Of the networks, as a `Segmenter` takes it; the processor by default."""
    jobs: int | None
    """Processes; by default as many as there are processors. The result does not depend on it."""
    progress: Progress | None
    """Called with (frames done, frames in all)."""
    kept: Path | None
    """A folder that keeps the results for a set, so that an interrupted call loses little."""


def over_frames(
    look: Callable[..., Arrays],
    arguments: tuple[object, ...],
    model: Model,
    frames: FrameSet | Path,
    chosen: Sequence[int] | None = None,
    **options: Unpack[LookOptions],
) -> Arrays:
    """Return the arrays that a function returns for each frame, stacked over the frames.

    The function is one of a module, and is called with a segmenter of the model, the frame's number, its `Images`, and
    the arguments, which are distinguished by their `repr`. Frames of a bag are resampled to the model's size, and
    `chosen` are their numbers; None chooses all of a set.
    """
    device, kept = options.get("device", "cpu"), options.get("kept")
    bag = frames if isinstance(frames, Path) else None
    work: Callable[[_Item], Arrays] = partial(_look_at, look, arguments, (model.folder, device, bag))
    items: list[_Item] = [(index, None) for index in chosen or ()]
    if isinstance(frames, FrameSet):
        numbers = range(len(frames)) if chosen is None else chosen
        items = [(index, frames.images(index)) for index in numbers]
        if kept is not None:
            digests = [network.digest for _, network in sorted(model.card.networks.items())]
            origin = (__version__, look.__qualname__, arguments, digests, device, frames.digest())
            work = partial(_kept, work, kept / hashlib.sha256(repr(origin).encode()).hexdigest()[:16])
    _opened.cache_clear()  # the files may have changed since this process opened them
    rows = spread(work, items, jobs=options.get("jobs"), progress=options.get("progress"))
    return tuple(np.stack(arrays) for arrays in zip(*rows, strict=True))


def _look_at(
    look: Callable[..., Arrays],
    arguments: tuple[object, ...],
    opening: tuple[Path, str, Path | None],
    item: _Item,
) -> Arrays:
    (index, images), (segmenter, bag) = item, _opened(*opening)
    if bag is not None:
        frame = bag.frame(index)
        images = frame.rgb, frame.depth, CLASS_OF_CARLA_ID[frame.labels]
    return look(segmenter, index, images, *arguments)


@lru_cache(maxsize=1)
def _opened(folder: Path, device: str, bag: Path | None) -> tuple[Segmenter, BagReader | None]:
    """Return a model's segmenter, and a bag, if there is one; both are opened once in each process."""
    model = load_model(folder)
    size = (model.card.height, model.card.width)
    return Segmenter(model, device=device), None if bag is None else read_bag(bag, size=size)


def _kept(work: Callable[[_Item], Arrays], folder: Path, item: _Item) -> Arrays:
    """Return the result of `work` for a frame from a file, which keeps it from the first call on."""
    path = folder / f"{item[0]}.npz"
    with suppress(EOFError, OSError, ValueError, zipfile.BadZipFile), np.load(path) as arrays:
        return tuple(arrays.values())
    result = work(item)
    folder.mkdir(parents=True, exist_ok=True)
    with draft_of(path) as draft, draft.open("wb") as file:
        np.savez(file, *result)
    return result


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """Counts (N, networks, 3, 28) of each frame's pixels by class.

    The three are the pixels of the class in both prediction and truth, in the prediction, and in the truth.
    """

    counts: Counts

    def __len__(self) -> int:
        return len(self.counts)

    def per_image(self) -> _Floats:
        """Return the mean over frames of the mean IoU over the classes in the frame, by network."""
        iou, present = class_iou(ClassCounts(*np.moveaxis(self.counts, -2, 0)))
        means = iou.sum(axis=2) / np.maximum(present.sum(axis=2), 1)  # the IoU of an absent class is 0
        return np.asarray(means.mean(axis=0))

    def by_class(self) -> _Floats:
        """Return the IoU of every class over all frames (networks, 28); NaN where the class is absent."""
        iou, present = class_iou(ClassCounts(*np.moveaxis(self.counts.sum(axis=0), -2, 0)))
        return np.where(present, iou, np.nan)

    def dataset(self) -> _Floats:
        """Return the mIoU of all frames together, by network."""
        return np.asarray(np.nanmean(self.by_class(), axis=1))

    def shares(self) -> _Floats:
        """Return every class's share of the pixels (28,)."""
        truth = self.counts[:, 0, 2].sum(axis=0)
        return np.asarray(truth / max(int(truth.sum()), 1))


def measure(
    model: Model, frames: FrameSet | Path, chosen: Sequence[int] | None = None, **options: Unpack[LookOptions]
) -> Measured:
    """Segment frames with all networks of a model, and compare the labels with the truth; as `over_frames`."""
    modalities = tuple(sorted(model.card.networks))
    (counts,) = over_frames(_count, (modalities,), model, frames, chosen, **options)
    return Measured(counts)


def _count(segmenter: Segmenter, _: int, images: Images, modalities: tuple[Modality, ...]) -> Arrays:
    """Return a frame's counts (networks, 3, 28)."""
    bgr, depth, truth = images
    counts = [count_classes(segmenter.segment(each, bgr, depth).labels, truth) for each in modalities]
    return (np.array([(each.intersection, each.predicted, each.truth) for each in counts]),)
