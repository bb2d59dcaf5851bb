"""The frame: the images that the cameras take at a moment."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

Pair: TypeAlias = tuple[float, float]
Points: TypeAlias = npt.NDArray[np.float64]
Reals: TypeAlias = npt.NDArray[np.float32]
Ids: TypeAlias = npt.NDArray[np.uint8]
Indices: TypeAlias = npt.NDArray[np.int64]
Flags: TypeAlias = npt.NDArray[np.bool_]

FRAME_SIZE: Final = (144, 256)
"""Height and width of a frame in pixels."""

DEPTH_RANGE_M: Final = 1000.0
"""The distance in metres of the largest depth count, 65535."""

CARLA_IDS: Final = MappingProxyType(
    {
        "building": 1,
        "fence": 2,
        "other": 3,
        "pole": 5,
        "road line": 6,
        "road": 7,
        "sidewalk": 8,
        "vegetation": 9,
        "wall": 11,
        "traffic sign": 12,
        "sky": 13,
        "ground": 14,
        "bridge": 15,
        "rail track": 16,
        "guard rail": 17,
        "traffic light": 18,
        "static": 19,
        "dynamic": 20,
        "water": 21,
        "terrain": 22,
        "person": 40,
        "rider": 41,
        "car": 100,
        "truck": 101,
        "bus": 102,
        "train": 103,
        "motorcycle": 104,
        "bicycle": 105,
    }
)
"""Class → id in a frame's labels: CARLA's ids as the data set SynDrone records them."""


@dataclass(frozen=True, slots=True)
class Frame:
    """The images of a moment, aligned pixel by pixel."""

    rgb: Ids  #: colour image (H, W, 3) uint8 in the order blue, green, red
    depth: npt.NDArray[np.uint16]  #: planar (H, W); in counts of 1000 / 65535 m, 65535 is out of range
    labels: Ids  #: the CARLA id of each pixel's class (H, W) uint8; 0 where the class is unknown

    @property
    def size(self) -> tuple[int, int]:
        """Height and width in pixels."""
        return self.labels.shape[0], self.labels.shape[1]
