"""Sets of frames, and the random choice of a batch from them."""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self, TypeAlias

import numpy as np
import numpy.typing as npt

from sunset.classes import CLASSES, IGNORED
from sunset.errors import DataError
from sunset_lab.inputs import HEIGHT, WIDTH
from sunset_ros.seeding import generator

_ARRAYS: Final = ("bgr", "depth", "labels")


Images: TypeAlias = tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16], npt.NDArray[np.uint8]]
"""A frame: colours, depth and labels."""


@dataclass(frozen=True, slots=True)
class FrameSet:
    """Frames in arrays, in memory or mapped from files.

    Attributes:
        bgr: (N, H, W, 3) uint8.
        depth: (N, H, W) uint16.
        labels: (N, H, W) uint8, class indices, or `IGNORED`.
    """

    bgr: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.uint16]
    labels: npt.NDArray[np.uint8]

    @classmethod
    def blank(cls, count: int, height: int, width: int) -> Self:
        """Return black frames, which take no memory."""
        shape = (count, height, width)
        return cls(np.zeros((*shape, 3), np.uint8), np.zeros(shape, np.uint16), np.zeros(shape, np.uint8))

    def __len__(self) -> int:
        return len(self.bgr)

    def images(self, index: int) -> Images:
        """Return a frame."""
        return np.asarray(self.bgr[index]), np.asarray(self.depth[index]), np.asarray(self.labels[index])

    def digest(self) -> str:
        """Return a short checksum of the frames."""
        digest = hashlib.sha256()
        for name in _ARRAYS:
            digest.update(np.ascontiguousarray(getattr(self, name)).data)
        return digest.hexdigest()[:12]

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Map the arrays of a folder; changes of them stay in memory.

        Raises:
            DataError: an array is missing or damaged.
        """
        try:
            bgr, depth, labels = (np.load(folder / f"{name}.npy", mmap_mode="c") for name in _ARRAYS)
        except (EOFError, OSError, ValueError) as error:
            raise DataError(f"The training frames in {folder} cannot be read: {error}.") from error
        return cls(bgr, depth, labels)

    def save(self, folder: Path) -> None:
        """Write the arrays into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for name in _ARRAYS:
            np.save(folder / f"{name}.npy", getattr(self, name))

    def write_into(self, folder: Path, place: int) -> None:
        """Replace frames in the arrays of a folder, from the index `place` on, and flush them to the disk."""
        for name in _ARRAYS:
            array = np.load(folder / f"{name}.npy", mmap_mode="r+")
            array[place : place + len(self)] = getattr(self, name)
            array.flush()


@dataclass(frozen=True, slots=True)
class Draw:
    """The frames of a batch, and how they are augmented.

    Attributes:
        frames: (N,) int64, indices.
        transforms: (N, 2, 3) float32, from a place in the picture to the place in the frame that it shows, as torch's
            `affine_grid` takes it: the corners of both are (-1, -1) and (1, 1).
        gains: (N,) float32, factors of the colours.
        phase: the first row and column of the pixels, every second, on which the loss is computed.
    """

    frames: npt.NDArray[np.int64]
    transforms: npt.NDArray[np.float32]
    gains: npt.NDArray[np.float32]
    phase: tuple[int, int]


def draw(count: int, size: int, seed: int, number: int) -> Draw:
    """Draw a batch of `size` frames from `count`; it depends on the seed and the batch's number only.

    Half of the frames are mirrored, half are cropped and enlarged by up to 1.3, and each is up to 10 % brighter or
    darker. No augmentation resembles a fault (strong darkening, noise, a shift of one sensor, blur): a network that is
    robust to a fault would not show it.
    """
    rng = generator(seed, "training", "batch", number)
    frames = rng.choice(count, size=size, replace=count < size)
    transforms, gains = [], []
    for _ in frames:
        zoom = 1.0 if rng.random() < 0.5 else rng.uniform(1.0, 1.3)  # noqa: PLR2004  half of them
        left, top = rng.random(2) * (1 - 1 / zoom) * (WIDTH, HEIGHT)
        flip = rng.random() < 0.5  # noqa: PLR2004  half of them
        sign, offset = (-1.0, WIDTH - 1.0) if flip else (1.0, 0.0)
        transforms.append(
            (
                (sign / zoom, 0.0, _translation(WIDTH, sign / zoom, left + offset / zoom)),
                (0.0, 1 / zoom, _translation(HEIGHT, 1 / zoom, top)),
            )
        )
        gains.append(1 + rng.uniform(-0.1, 0.1))
    phase = (int(rng.integers(2)), int(rng.integers(2)))
    return Draw(frames, np.array(transforms, np.float32), np.array(gains, np.float32), phase)


def _translation(size: int, scale: float, first: float) -> float:
    """Return the offset, added to `scale` times a place from -1 to 1, with which pixel 0 shows pixel `first`."""
    return (2 * first + 1 - scale) / size - 1 + scale


def class_weights(labels: npt.NDArray[np.uint8], limits: tuple[float, float]) -> npt.NDArray[np.float32]:
    """Return a loss weight for each class, (28,): 1/√share, scaled to 1 for the average pixel, within the limits.

    A class that never occurs has the least weight.

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
