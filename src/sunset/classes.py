"""The 28 classes of SynDrone, and how recorded CARLA ids map to them.

Source: the SynDrone data set's label list; the recorded ids are CARLA's semantic tags.
"""

from types import MappingProxyType
from typing import Final

import numpy as np
import numpy.typing as npt

IGNORED: Final = 255
"""The class index of pixels that take no part in training or evaluation."""

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
"""Class name → recorded CARLA id, in the order of the class indices 0–27."""

CLASSES: Final = tuple(CARLA_IDS)
"""The class names; a name's position is its class index."""


def _lookup() -> npt.NDArray[np.uint8]:
    table = np.full(256, IGNORED, dtype=np.uint8)
    for index, carla_id in enumerate(CARLA_IDS.values()):
        table[carla_id] = index
    table.flags.writeable = False
    return table


CLASS_OF_CARLA_ID: Final = _lookup()
"""Array (256,) uint8: recorded CARLA id → class index, `IGNORED` for an id that is not a class."""
