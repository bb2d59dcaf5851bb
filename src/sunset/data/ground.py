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


SURFACE_LOOKS: Final = {  # class; display colour; strength of broad patches; strength of grain
    Surface.FIELD: ("terrain", (0.45, 0.46, 0.29), 0.35, 0.1),
    Surface.LAWN: ("terrain", (0.37, 0.43, 0.25), 0.22, 0.12),
    Surface.GRASS: ("terrain", (0.39, 0.43, 0.26), 0.3, 0.14),
    Surface.ASPHALT: ("road", (0.39, 0.39, 0.39), 0.16, 0.06),
    Surface.MARKING: ("road line", (0.8, 0.8, 0.78), 0.14, 0.05),
    Surface.PAVING: ("sidewalk", (0.57, 0.56, 0.53), 0.14, 0.06),
    Surface.KERB: ("sidewalk", (0.64, 0.63, 0.61), 0.1, 0.05),
    Surface.PLAZA: ("ground", (0.61, 0.57, 0.52), 0.14, 0.06),
    Surface.EARTH: ("ground", (0.5, 0.43, 0.34), 0.35, 0.14),
    Surface.PATH: ("ground", (0.63, 0.57, 0.47), 0.16, 0.1),
    Surface.WATER: ("water", (0.17, 0.23, 0.22), 0.2, 0.0),
    Surface.DECK: ("bridge", (0.55, 0.54, 0.53), 0.12, 0.05),
    Surface.BALLAST: ("rail track", (0.44, 0.4, 0.37), 0.15, 0.2),
    Surface.SLEEPER: ("rail track", (0.35, 0.31, 0.28), 0.1, 0.1),
    Surface.RAIL: ("rail track", (0.52, 0.5, 0.49), 0.1, 0.05),
    Surface.SHRUBS: ("vegetation", (0.27, 0.34, 0.2), 0.35, 0.3),
    Surface.CROPS: ("terrain", (0.48, 0.47, 0.3), 0.35, 0.12),
    Surface.YARD: ("ground", (0.52, 0.51, 0.48), 0.22, 0.08),
    Surface.PITCH: ("terrain", (0.33, 0.46, 0.22), 0.14, 0.08),
    Surface.CHALK: ("terrain", (0.74, 0.77, 0.7), 0.1, 0.05),
    Surface.TARTAN: ("ground", (0.58, 0.31, 0.25), 0.12, 0.04),
    Surface.POOL: ("water", (0.3, 0.62, 0.68), 0.06, 0.02),
    Surface.STUBBLE: ("terrain", (0.62, 0.56, 0.36), 0.2, 0.1),
    Surface.FALLOW: ("terrain", (0.43, 0.36, 0.28), 0.25, 0.12),
}
SURFACE_LABELS: Final = np.array(
    [CARLA_IDS[SURFACE_LOOKS[surface][0]] for surface in Surface], dtype=np.uint8
)
"""Array (24,) uint8: `Surface` → CARLA id."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """A painted square around the town's centre: values of `Surface` (N, N), row = y, column = x.

    It reaches half its side in metres.
    """

    image: Ids
    reach: float

    def at(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Ids:
        """Return the surface at world points, for those outside that of the nearest point inside."""
        scale, last = len(self.image) / (2 * self.reach), len(self.image) - 1
        row, column = (
            np.clip((np.asarray(along) + self.reach) * scale, 0, last).astype(np.int64) for along in (y, x)
        )
        return self.image.ravel().take(row * len(self.image) + column)


@dataclass(frozen=True, slots=True)
class Ground:
    """The painted ground: the town, the town without its streets, and more coarsely the land around."""

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
