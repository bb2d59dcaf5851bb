"""Batches of augmented frames, computed on the device of the training."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional

from sunset_lab.batches import Draw, FrameSet
from sunset_lab.inputs import HEIGHT, WIDTH

_SHIFT_PX: Final = ((2, 20), (0, 6))
"""Least and greatest movement of the colour picture in a misaligned pair: across, down."""


@dataclass(frozen=True, slots=True)
class Batch:
    """Augmented frames, in tensors on a device.

    Attributes:
        bgr: (N, 144, 256, 3) uint8.
        depth: (N, 144, 256) float32, counts.
        labels: (N, 144, 256) int64.
        phase: the first row and column of the pixels, every second, on which the loss is computed.
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
