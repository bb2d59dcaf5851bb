"""Batches of augmented frames."""

from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from sunset.classes import CLASSES, IGNORED
from sunset.errors import DataError
from sunset.seeding import generator
from sunset.training.inputs import HEIGHT, WIDTH

__all__ = ["ARRAY_FILES", "Batch", "FrameSet", "augment", "batches", "class_weights"]

_MAX_ZOOM: Final = 1.3
_BRIGHTNESS: Final = 0.1
_ARRAYS: Final = ("bgr", "depth", "labels")
ARRAY_FILES: Final = tuple(f"{name}.npy" for name in _ARRAYS)
"""The files of a set of frames."""


@dataclass(frozen=True, slots=True)
class FrameSet:
    """Frames in arrays, in memory or mapped from files.

    Attributes:
        bgr: (N, H, W, 3) uint8.
        depth: (N, H, W) uint16.
        labels: (N, H, W) uint8, class indices; `IGNORED` takes no part.
    """

    bgr: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.uint16]
    labels: npt.NDArray[np.uint8]

    def __post_init__(self) -> None:
        """Refuse arrays that do not belong together."""
        frame = self.labels.shape
        shapes = (self.bgr.shape, self.depth.shape, frame)
        if len(frame) != 3 or shapes != ((*frame, 3), frame, frame):  # noqa: PLR2004  N, H, W
            raise DataError(
                "A set of frames consists of three arrays of shapes (N, H, W, 3), (N, H, W) and (N, H, W), got "
                f"shapes {shapes}."
            )

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.bgr)

    @classmethod
    def load(cls, folder: Path) -> "FrameSet":
        """Map the arrays of a folder.

        Raises:
            DataError: they are missing or no arrays.
        """
        try:
            bgr, depth, labels = (np.load(folder / f"{name}.npy", mmap_mode="r") for name in _ARRAYS)
        except (EOFError, OSError, ValueError) as error:
            raise DataError(f"The training frames in {folder} cannot be read: {error}.") from error
        return cls(bgr, depth, labels)

    def save(self, folder: Path) -> None:
        """Write the arrays into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for name in _ARRAYS:
            np.save(folder / f"{name}.npy", getattr(self, name))


@dataclass(frozen=True, slots=True)
class Batch:
    """Augmented frames.

    Attributes:
        bgr: (N, 144, 256, 3) uint8.
        depth: (N, 144, 256) float32, counts.
        labels: (N, 144, 256) int64.
        phase: the first row and column of the pixels, every second one, that the loss is taken on.
    """

    bgr: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.float32]
    labels: npt.NDArray[np.int64]
    phase: tuple[int, int]


def augment(
    bgr: npt.NDArray[np.uint8],
    depth: npt.NDArray[np.uint16],
    labels: npt.NDArray[np.uint8],
    rng: np.random.Generator,
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32], npt.NDArray[np.uint8]]:
    """Return a frame mirrored or not, cropped and enlarged by up to 1.3, and up to 10 % brighter or darker.

    Nothing here resembles a fault (no strong darkening, noise, shift of one sensor, or blur): a network
    that has learned to shrug off a fault would not show it.
    """
    zoom = 1.0 if rng.random() < 0.5 else rng.uniform(1.0, _MAX_ZOOM)  # noqa: PLR2004  half of them
    left, top = rng.random(2) * (1 - 1 / zoom) * (WIDTH, HEIGHT)
    flip = rng.random() < 0.5  # noqa: PLR2004  half of them
    sign, offset = (-1.0, WIDTH - 1.0) if flip else (1.0, 0.0)
    # Destination to source: x_source = left + (mirrored x) / zoom.
    matrix = np.array([[sign / zoom, 0, left + offset / zoom], [0, 1 / zoom, top]])
    nearest = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    linear = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = (WIDTH, HEIGHT)
    gain = 1 + rng.uniform(-_BRIGHTNESS, _BRIGHTNESS)
    picture = cv2.warpAffine(bgr, matrix, size, flags=linear, borderMode=cv2.BORDER_REPLICATE)
    return (
        cv2.convertScaleAbs(picture, alpha=gain),
        cv2.warpAffine(depth, matrix, size, flags=nearest, borderMode=cv2.BORDER_REPLICATE).astype(
            np.float32
        ),
        cv2.warpAffine(labels, matrix, size, flags=nearest, borderMode=cv2.BORDER_REPLICATE),
    )


def _batch(frames: FrameSet, size: int, seed: int, number: int) -> Batch:
    rng = generator(seed, "training", "batch", number)
    chosen = rng.choice(len(frames), size=size, replace=len(frames) < size)
    parts = [augment(frames.bgr[i], frames.depth[i], frames.labels[i], rng) for i in chosen]
    bgr, depth, labels = (np.stack(arrays) for arrays in zip(*parts, strict=True))
    phase = (int(rng.integers(2)), int(rng.integers(2)))
    return Batch(bgr, depth, labels.astype(np.int64), phase)


def batches(frames: FrameSet, size: int, seed: int, numbers: Iterable[int]) -> Iterator[Batch]:
    """Yield the batches of some numbers, prepared one ahead in a thread.

    A batch depends on the seed and its number only, so that a resumed run sees what an undisturbed one
    would have seen.
    """
    with ThreadPoolExecutor(1) as pool:
        coming: Future[Batch] | None = None
        for number in numbers:
            before, coming = coming, pool.submit(_batch, frames, size, seed, number)
            if before is not None:
                yield before.result()
        if coming is not None:
            yield coming.result()


def class_weights(labels: npt.NDArray[np.uint8], limits: tuple[float, float]) -> npt.NDArray[np.float32]:
    """Return a loss weight per class, (28,): 1/√share, 1 for the average pixel, within the limits.

    A class that never occurs gets the least weight.

    >>> labels = np.zeros((1, 10, 10), dtype=np.uint8)
    >>> labels[0, 0, 0] = 1
    >>> class_weights(labels, (0.5, 3.0))[:3].round(2).tolist()
    [0.9200000166893005, 3.0, 0.5]
    """
    counts = np.bincount(labels.ravel(), minlength=IGNORED + 1)[: len(CLASSES)].astype(float)
    share = counts / max(counts.sum(), 1)
    seen = share > 0
    weights = np.zeros(len(CLASSES))
    weights[seen] = 1 / np.sqrt(share[seen])
    weights[seen] /= (weights * share).sum()
    return np.clip(weights, *limits).astype(np.float32)
