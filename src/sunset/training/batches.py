"""Sets of frames, and which of them a batch consists of."""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self

import numpy as np
import numpy.typing as npt

from sunset.classes import CLASSES, IGNORED
from sunset.errors import DataError
from sunset.seeding import generator
from sunset.training.inputs import HEIGHT, WIDTH

_ARRAYS: Final = ("bgr", "depth", "labels")


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
        frame = self.labels.shape
        shapes = (self.bgr.shape, self.depth.shape, frame)
        if len(frame) != 3 or shapes != ((*frame, 3), frame, frame):  # noqa: PLR2004  N, H, W
            raise DataError(
                "A set of frames consists of three arrays of shapes (N, H, W, 3), (N, H, W) and (N, H, W), got "
                f"shapes {shapes}."
            )

    @classmethod
    def blank(cls, count: int, height: int, width: int) -> Self:
        """Return so many black frames; they take no memory."""
        shape = (count, height, width)
        return cls(np.zeros((*shape, 3), np.uint8), np.zeros(shape, np.uint16), np.zeros(shape, np.uint8))

    def __len__(self) -> int:
        return len(self.bgr)

    def images(
        self, index: int
    ) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16], npt.NDArray[np.uint8]]:
        """Return one frame: colours, depth and labels."""
        return np.asarray(self.bgr[index]), np.asarray(self.depth[index]), np.asarray(self.labels[index])

    def digest(self) -> str:
        """Return a short checksum of the frames."""
        digest = hashlib.sha256()
        for name in _ARRAYS:
            digest.update(np.ascontiguousarray(getattr(self, name)).data)
        return digest.hexdigest()[:12]

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Map the arrays of a folder; what is written into them stays in memory.

        Raises:
            DataError: they are missing or not arrays.
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
        """Write the frames over those of a folder, from a place on; they are on the disk then."""
        for name in _ARRAYS:
            array = np.load(folder / f"{name}.npy", mmap_mode="r+")
            array[place : place + len(self)] = getattr(self, name)
            array.flush()


@dataclass(frozen=True, slots=True)
class Draw:
    """What a batch is to consist of: which frames, what each is enlarged to, and how much brighter it becomes.

    Attributes:
        frames: (N,) int64, indices.
        transforms: (N, 2, 3) float32, from a place in the picture to that in the frame which it shows; both have the
            corners (-1, -1) and (1, 1), as torch's `affine_grid` takes it.
        gains: (N,) float32, what colours are multiplied by.
        phase: the first row and column of the pixels, every second one, that the loss is taken on.
    """

    frames: npt.NDArray[np.int64]
    transforms: npt.NDArray[np.float32]
    gains: npt.NDArray[np.float32]
    phase: tuple[int, int]


def draw(count: int, size: int, seed: int, number: int) -> Draw:
    """Draw the batch of a number from so many frames.

    Each frame is mirrored or not, cropped and enlarged by up to 1.3, and up to 10 % brighter or darker. Nothing here
    resembles a fault (no strong darkening, noise, shift of one sensor, or blur): a network that has learned to shrug
    off a fault would not show it.

    A batch depends on the seed and its number only, so that a resumed run sees what an undisturbed one would have
    seen.
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
    """Return what is added to `scale` times a place from -1 to 1, so that the first pixel shows pixel `first`."""
    return (2 * first + 1 - scale) / size - 1 + scale


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
