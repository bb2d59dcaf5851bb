"""The 28 classes of SynDrone, and how recorded CARLA ids map to them.

Source: the SynDrone data set's label list; the recorded ids are CARLA's semantic tags.
"""

from types import MappingProxyType
from typing import Final

import numpy as np
import numpy.typing as npt

IGNORED: Final = 255
"""The class index of pixels that take no part in training or evaluation."""

_TABLE: Final = MappingProxyType(
    {
        "building": (1, (204, 121, 82)),
        "fence": (2, (133, 94, 66)),
        "other": (3, (150, 150, 150)),
        "pole": (5, (240, 228, 66)),
        "road line": (6, (255, 255, 255)),
        "road": (7, (78, 78, 92)),
        "sidewalk": (8, (200, 182, 214)),
        "vegetation": (9, (0, 128, 88)),
        "wall": (11, (173, 132, 100)),
        "traffic sign": (12, (230, 159, 0)),
        "sky": (13, (178, 223, 250)),
        "ground": (14, (214, 198, 150)),
        "bridge": (15, (120, 108, 140)),
        "rail track": (16, (108, 76, 52)),
        "guard rail": (17, (186, 176, 172)),
        "traffic light": (18, (255, 196, 60)),
        "static": (19, (112, 112, 112)),
        "dynamic": (20, (213, 94, 0)),
        "water": (21, (0, 72, 140)),
        "terrain": (22, (158, 202, 90)),
        "person": (40, (214, 40, 110)),
        "rider": (41, (250, 120, 180)),
        "car": (100, (40, 130, 230)),
        "truck": (101, (20, 60, 200)),
        "bus": (102, (0, 200, 220)),
        "train": (103, (60, 30, 120)),
        "motorcycle": (104, (170, 60, 170)),
        "bicycle": (105, (230, 130, 230)),
    }
)
"""Class name → recorded CARLA id; red, green and blue. Frequent classes also differ in lightness."""

CARLA_IDS: Final = MappingProxyType({name: carla_id for name, (carla_id, _) in _TABLE.items()})
"""Class name → recorded CARLA id, in the order of the class indices 0–27."""

CLASSES: Final = tuple(CARLA_IDS)
"""The class names; a name's position is its class index."""

COLOURS: Final = tuple(colour for _, colour in _TABLE.values())
"""Red, green and blue of each class in pictures of labels, by class index."""

PALETTE: Final[npt.NDArray[np.uint8]] = np.zeros((256, 3), dtype=np.uint8)
"""Array (256, 3) uint8: class index → its red, green and blue; black for other indices."""
PALETTE[: len(COLOURS)] = COLOURS
PALETTE.flags.writeable = False

CLASS_OF_CARLA_ID: Final[npt.NDArray[np.uint8]] = np.full(256, IGNORED, dtype=np.uint8)
"""Array (256,) uint8: recorded CARLA id → class index, `IGNORED` for an unknown id."""
CLASS_OF_CARLA_ID[list(CARLA_IDS.values())] = range(len(CLASSES))
CLASS_OF_CARLA_ID.flags.writeable = False
