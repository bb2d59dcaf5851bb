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

COLOURS: Final = (
    (204, 121, 82),  # building
    (133, 94, 66),  # fence
    (150, 150, 150),  # other
    (240, 228, 66),  # pole
    (255, 255, 255),  # road line
    (78, 78, 92),  # road
    (200, 182, 214),  # sidewalk
    (0, 128, 88),  # vegetation
    (173, 132, 100),  # wall
    (230, 159, 0),  # traffic sign
    (178, 223, 250),  # sky
    (214, 198, 150),  # ground
    (120, 108, 140),  # bridge
    (108, 76, 52),  # rail track
    (186, 176, 172),  # guard rail
    (255, 196, 60),  # traffic light
    (112, 112, 112),  # static
    (213, 94, 0),  # dynamic
    (0, 72, 140),  # water
    (158, 202, 90),  # terrain
    (214, 40, 110),  # person
    (250, 120, 180),  # rider
    (40, 130, 230),  # car
    (20, 60, 200),  # truck
    (0, 200, 220),  # bus
    (60, 30, 120),  # train
    (170, 60, 170),  # motorcycle
    (230, 130, 230),  # bicycle
)
"""Red, green and blue of each class where labels are shown, by class index; frequent ones differ in lightness, too."""


def _lookup() -> npt.NDArray[np.uint8]:
    table = np.full(256, IGNORED, dtype=np.uint8)
    for index, carla_id in enumerate(CARLA_IDS.values()):
        table[carla_id] = index
    table.flags.writeable = False
    return table


def _palette() -> npt.NDArray[np.uint8]:
    table = np.zeros((256, 3), dtype=np.uint8)
    table[: len(COLOURS)] = COLOURS
    table.flags.writeable = False
    return table


PALETTE: Final = _palette()
"""Array (256, 3) uint8: class index → red, green and blue, as of `COLOURS`; black for what is not a class."""

CLASS_OF_CARLA_ID: Final = _lookup()
"""Array (256,) uint8: recorded CARLA id → class index, `IGNORED` for an id that is not a class."""
