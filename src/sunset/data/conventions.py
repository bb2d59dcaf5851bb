"""Conventions for the values in label and depth images, and their conversion to a frame's values."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from sunset.classes import CARLA_IDS
from sunset.data.pixels import FAR, counts_of_metres
from sunset.errors import DataError
from sunset.images import Pixels

IDS_OF_NO_CLASS: Final = MappingProxyType({"none": 0, "pedestrians": 4, "vehicles": 10, "any": 255})
"""CARLA's ids outside SynDrone's classes: such pixels are ignored, not refused."""

_NEWER_CARLA: Final = (
    *("none", "road", "sidewalk", "building", "wall", "fence", "pole", "traffic light", "traffic sign"),
    *("vegetation", "terrain", "sky", "person", "rider", "car", "truck", "bus", "train", "motorcycle"),
    *("bicycle", "static", "dynamic", "other", "water", "road line", "ground", "bridge", "rail track"),
    "guard rail",
)
"""The meanings of the ids from 0 on since CARLA 0.9.14."""

IDS: Final[Mapping[str, Mapping[int, int]]] = MappingProxyType(
    {
        "syndrone": {number: number for number in (*CARLA_IDS.values(), *IDS_OF_NO_CLASS.values())},
        "carla": {number: CARLA_IDS.get(name, 0) for number, name in enumerate(_NEWER_CARLA)} | {255: 255},
        "classes": dict(enumerate(CARLA_IDS.values())) | {255: 255},
    }
)
"""Convention → value in a label image → id in a frame: SynDrone's, those since CARLA 0.9.14, or class indices."""
_NAMES: Final = MappingProxyType(
    {
        "syndrone": "SynDrone's label ids (0 to 22, 40, 41, 100 to 105; 255 for none)",
        "carla": "label ids of CARLA since 0.9.14 (0 to 28; 255 for none)",
        "classes": "class indices (0 to 27; 255 for none)",
    }
)
DEPTH_UNITS: Final = ("counts", "mm")
"""Units of whole numbers in a depth image: counts of 1000 / 65535 m, or millimetres."""


@dataclass(frozen=True, slots=True)
class Reading:
    """A convention of label and depth images.

    Attributes:
        ids: one of `IDS`.
        depth_unit: one of `DEPTH_UNITS`, for whole numbers; floating-point numbers are in metres.
    """

    ids: str = "syndrone"
    depth_unit: str = "counts"

    def __str__(self) -> str:
        unit = {"counts": "counts of 1000 / 65535 m", "mm": "millimetres"}[self.depth_unit]
        return f"Labels are read as {_NAMES[self.ids]}, whole numbers of depth as {unit}."

    def labels(self, pixels: npt.NDArray[np.uint8], place: str) -> npt.NDArray[np.uint8]:
        """Return the labels (H, W) of a frame.

        Raises:
            DataError: a value is not in the convention; `place` names the image.
        """
        table = IDS[self.ids]
        strange = np.isin(np.arange(256), list(table), invert=True).astype(np.uint8)
        if cv2.LUT(pixels, strange).any():
            numbers = np.unique(pixels)
            values = ", ".join(str(number) for number in numbers[strange[numbers] > 0])
            raise DataError(
                f"The image {place} must hold {_NAMES[self.ids]}, got {values}; say what they are with "
                "'sunset data import --ids', or map them to these."
            )
        if self.ids == "syndrone":
            return pixels
        return np.asarray(
            cv2.LUT(pixels, np.array([table.get(number, 0) for number in range(256)], np.uint8))
        )

    def depth(self, pixels: Pixels) -> npt.NDArray[np.uint16]:
        """Return depth (H, W) as counts; in millimetres, 0 and the largest value are unknown."""
        if pixels.dtype.kind == "f":
            return counts_of_metres(pixels)
        if self.depth_unit == "counts":
            return pixels
        return counts_of_metres(np.where(np.isin(pixels, (0, FAR)), np.nan, pixels / 1000).astype(np.float32))


SYNDRONE: Final = Reading()
"""The convention of SynDrone, the default."""
