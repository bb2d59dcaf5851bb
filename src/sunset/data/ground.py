"""The ground of a town: an image of surfaces, painted from the plan.

What lies where, down to lane markings, is an image of `Surface` values that the renderer looks up under each
ray. A second image shows the ground without its streets: what lies below their bridges, and on the railway's.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.classes import CARLA_IDS
from sunset.data.frame import Ids
from sunset.data.layout import EXTENT_M


class Surface(IntEnum):
    """What the ground is covered with."""

    FIELD = 0
    LAWN = 1
    GRASS = 2
    ASPHALT = 3
    MARKING = 4
    PAVING = 5
    KERB = 6
    PLAZA = 7
    EARTH = 8
    PATH = 9
    WATER = 10
    DECK = 11
    BALLAST = 12
    SLEEPER = 13
    RAIL = 14
    SHRUBS = 15
    CROPS = 16
    YARD = 17
    PITCH = 18
    CHALK = 19
    TARTAN = 20
    POOL = 21
    STUBBLE = 22
    FALLOW = 23


SURFACE_CLASSES: Final = {
    Surface.FIELD: "terrain",
    Surface.LAWN: "terrain",
    Surface.GRASS: "terrain",
    Surface.ASPHALT: "road",
    Surface.MARKING: "road line",
    Surface.PAVING: "sidewalk",
    Surface.KERB: "sidewalk",
    Surface.PLAZA: "ground",
    Surface.EARTH: "ground",
    Surface.PATH: "ground",
    Surface.WATER: "water",
    Surface.DECK: "bridge",
    Surface.BALLAST: "rail track",
    Surface.SLEEPER: "rail track",
    Surface.RAIL: "rail track",
    Surface.SHRUBS: "vegetation",
    Surface.CROPS: "terrain",
    Surface.YARD: "ground",
    Surface.PITCH: "terrain",
    Surface.CHALK: "terrain",
    Surface.TARTAN: "ground",
    Surface.POOL: "water",
    Surface.STUBBLE: "terrain",
    Surface.FALLOW: "terrain",
}

SURFACE_LABELS: Final = np.array([CARLA_IDS[SURFACE_CLASSES[surface]] for surface in Surface], dtype=np.uint8)
"""Array (24,) uint8: `Surface` → CARLA id."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """A painted square around the town's centre.

    Attributes:
        image: values of `Surface` (N, N), row = y, column = x.
        reach: half the square's side in metres.
    """

    image: Ids
    reach: float

    def at(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Ids:
        """Return the surface at world points, for those outside that of the nearest point inside."""
        scale, last = len(self.image) / (2 * self.reach), len(self.image) - 1
        row, column = (
            np.clip((np.asarray(along) + self.reach) * scale, 0, last).astype(np.int64) for along in (y, x)
        )
        found: Ids = self.image.ravel().take(row * len(self.image) + column)
        return found


@dataclass(frozen=True, slots=True)
class Ground:
    """The painted ground.

    Attributes:
        town: the town.
        bare: the town without its streets.
        country: the land around, more coarsely.
    """

    town: Sheet
    bare: Sheet
    country: Sheet

    def at(self, x: npt.ArrayLike, y: npt.ArrayLike, bare: npt.ArrayLike = False) -> Ids:
        """Return the surface at world points, without streets where `bare`."""
        inside = np.maximum(np.abs(x), np.abs(y)) < EXTENT_M
        built = self.town.at(x, y)
        if np.any(bare):
            built = np.where(bare, self.bare.at(x, y), built)
        return built if np.all(inside) else np.where(inside, built, self.country.at(x, y))
