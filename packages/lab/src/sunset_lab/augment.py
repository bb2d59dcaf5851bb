"""Random batches of augmented frames, computed on the device of the training, and the weights of classes."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional

from sunset.classes import CLASSES, IGNORED
from sunset_lab.architecture import HEIGHT, WIDTH
from sunset_lab.frames import FrameSet
from sunset_ros.seeding import generator

_SHIFT_PX: Final = ((2, 20), (0, 6))
"""Least and greatest movement of the colour picture in a misaligned pair: across, down."""


@dataclass(frozen=True, slots=True)
class Draw:
    """The frames of a batch, and how they are augmented."""

    frames: npt.NDArray[np.int64]  # indices (N,)
    # (N, 2, 3), from a place in the picture to the place in the frame that it shows, as torch's
    # `affine_grid` takes it: the corners of both are (-1, -1) and (1, 1).
    transforms: npt.NDArray[np.float32]
    gains: npt.NDArray[np.float32]  # factors of the colours (N,)
    # The first row and column of the pixels, every second, on which the loss is computed.
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


@dataclass(frozen=True, slots=True)
class Batch:
    """Augmented frames, in tensors on a device, and the phase of their `Draw`.

    `bgr` is (N, 144, 256, 3) uint8, `depth` (N, 144, 256) float32 in counts, and `labels` (N, 144, 256) int64.
    """

    bgr: Tensor
    depth: Tensor
    labels: Tensor
    phase: tuple[int, int]


class DeviceFrames:
    """A set of frames on a device, as integers, which take a fourth of the networks' inputs."""

    def __init__(self, frames: FrameSet, device: torch.device) -> None:
        self._device = device
        self._bgr, self._labels = self._to_device(frames.bgr), self._to_device(frames.labels)
        self._depth = self._to_device(frames.depth.view(np.int16))  # torch can do little with uint16

    def _to_device(self, array: npt.NDArray[np.generic]) -> Tensor:
        return torch.from_numpy(np.require(array, requirements="W")).to(self._device, non_blocking=True)

    def __len__(self) -> int:
        return len(self._bgr)

    def plain(self, indices: npt.NDArray[np.int64]) -> Batch:
        """Return frames without augmentation."""
        chosen = self._to_device(indices)
        depth = self._depth[chosen].int() & 0xFFFF  # the sign was the highest bit
        return Batch(self._bgr[chosen], depth.float(), self._labels[chosen].long(), (0, 0))

    def batch(self, draw: Draw) -> Batch:
        """Return a drawn batch, without waiting for the device."""
        frames, gains = self.plain(draw.frames), self._to_device(draw.gains)
        size = [len(draw.frames), 1, HEIGHT, WIDTH]
        grid = functional.affine_grid(self._to_device(draw.transforms), size, align_corners=False)

        def warped(images: Tensor, mode: str) -> Tensor:
            return functional.grid_sample(images, grid, mode, padding_mode="border", align_corners=False)

        colours = warped(frames.bgr.permute(0, 3, 1, 2).float(), "bilinear").round_()
        depth, labels = warped(torch.stack([frames.depth, frames.labels], 1), "nearest").unbind(1)
        colours = colours.mul_(gains[:, None, None, None]).round_().clamp_(0, 255).to(torch.uint8)
        return Batch(colours.permute(0, 2, 3, 1), depth, labels.long(), draw.phase)


def movement(random: torch.Generator | None = None) -> tuple[int, int]:
    """Draw a movement of the colour picture, across and down, from a generator; torch's own if None."""
    across, down = (
        int(torch.randint(least, most + 1, (), generator=random))
        * (1 - 2 * int(torch.randint(2, (), generator=random)))
        for least, most in _SHIFT_PX
    )
    return across, down


def cells_of(distance: int, stride: int) -> int:
    """Return a distance in cells: at least 1, or 0 for the distance 0."""
    return int(np.sign(distance)) * max(round(abs(distance) / stride), 1)


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
    weights = 1 / np.sqrt(np.where(share > 0, share, np.inf))
    return np.asarray(np.clip(weights / (weights * share).sum(), *limits), np.float32)
