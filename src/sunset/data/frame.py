"""The frame: what the cameras see at one moment."""

from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

Points: TypeAlias = npt.NDArray[np.float64]
Reals: TypeAlias = npt.NDArray[np.float32]
Ids: TypeAlias = npt.NDArray[np.uint8]

FRAME_SIZE: Final = (144, 256)
"""Height and width of a frame in pixels."""

DEPTH_RANGE_M: Final = 1000.0
"""The distance in metres that the largest depth count, 65535, stands for."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One moment's images, aligned pixel by pixel.

    Attributes:
        rgb: colour image (H, W, 3) uint8 in the order blue, green, red.
        depth: planar depth (H, W) uint16; counts * 1000 / 65535 is in metres, 65535 is out of range.
        labels: the CARLA id of what is seen (H, W) uint8, one of `sunset.classes.CARLA_IDS`; 0 where that is not known.
    """

    rgb: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.uint16]
    labels: npt.NDArray[np.uint8]

    @property
    def size(self) -> tuple[int, int]:
        """Height and width in pixels."""
        return self.labels.shape[0], self.labels.shape[1]


def no_labels(depth: npt.NDArray[np.uint16]) -> Ids:
    """Return the labels of an unlabelled frame, in the size of its depth."""
    return np.zeros(depth.shape, np.uint8)
