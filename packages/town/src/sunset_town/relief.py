"""The heights of a town's ground: rolling land, the river's bed, the railway's embankment, hills around."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset_town.frame import Pair, Points

WATER_M: Final = -2.6
"""Height of the river's water in metres; its banks lie near 0."""
BANK_M: Final = 4.5
"""Width of each sloping bank in metres."""
RAIL_M: Final = 5.9
"""Height of the railway in metres at v = 0."""
GRADE: Final = 0.003
CROWN_M: Final = 5.4
"""Half the width of the embankment's level top in metres."""
SLOPE_M: Final = 8.0
ABUTMENT_M: Final = 0.8
HILLS_M: Final = (400.0, 1100.0)
"""Distances from a town's centre at which the hills around it begin to rise and are highest, in metres."""


@dataclass(frozen=True, slots=True)
class Wave:
    """A wave of the rolling land: height in metres, radians a metre along u and v, phase in radians."""

    height: float
    along: Pair
    phase: float

    def at(self, uv: Points) -> Points:
        """Return the height (...) at grid points (..., 2)."""
        angle = uv[..., 0] * self.along[0] + uv[..., 1] * self.along[1] + self.phase
        height: Points = self.height * np.sin(angle)
        return height


@dataclass(frozen=True, slots=True)
class Relief:
    """Heights in metres above the town's centre, at points of the grid."""

    waves: tuple[Wave, ...]  # of the rolling land
    river: float  # v of the river's middle in metres
    river_width: float  # of its water in metres
    river_bend: Pair  # amplitude of its bends in metres, and their phase
    rail: float  # u of the railway's middle in metres
    underpasses: tuple[Pair, ...]  # v and half the width of each, in metres

    def river_v(self, u: npt.ArrayLike) -> Points:
        """Return v of the river's middle at positions u."""
        return self.river + self.river_bend[0] * np.sin(np.asarray(u) / 55 + self.river_bend[1])

    def streets(self, uv: npt.ArrayLike) -> Points:
        """Return the height (...) of streets and their bridges at grid points (..., 2)."""
        grid = np.asarray(uv, dtype=np.float64)
        centre = sum(wave.at(np.zeros(2)) for wave in self.waves)
        rolling = np.sum([wave.at(grid) for wave in self.waves], axis=0) - centre
        away = np.hypot(grid[..., 0], grid[..., 1])
        rise = np.clip((away - HILLS_M[0]) / (HILLS_M[1] - HILLS_M[0]), 0, 1)
        hills = rise**2 * (3 - 2 * rise) * (62 + 4 * rolling)
        river = (grid[..., 1] - self.river_v(grid[..., 0])) / (55 + 0.12 * away)
        calm = (1 - 0.93 * np.exp(-(river**2))) * (
            1 - 0.93 * np.exp(-(((grid[..., 0] - self.rail) / 50) ** 2))
        )
        level: Points = (rolling + hills) * calm
        return level

    def railway(self, v: npt.ArrayLike) -> Points:
        """Return the height of the rails at positions v along the railway."""
        return RAIL_M + GRADE * np.asarray(v, dtype=np.float64)

    def off_water(self, uv: Points) -> Points:
        """Return the distance (...) of grid points (..., 2) from the river's water, negative in it."""
        return np.abs(uv[..., 1] - self.river_v(uv[..., 0])) - self.river_width / 2

    @property
    def rail_spans(self) -> list[Pair]:
        """The ends along v of every railway bridge, in metres."""
        half = self.river_width / 2 + BANK_M + self.river_bend[0] + 1
        spans = [(at - wide - 1, at + wide + 1) for at, wide in self.underpasses]
        middle = float(self.river_v(self.rail))
        return [*spans, (middle - half, middle + half)]

    def ground(self, uv: npt.ArrayLike) -> Points:
        """Return the height (...) of the ground, or the water on it, at grid points (..., 2)."""
        grid = np.asarray(uv, dtype=np.float64)
        level = self.streets(grid)
        off_water = self.off_water(grid)
        level = WATER_M + (level - WATER_M) * np.clip(off_water / BANK_M, 0, 1)
        free = off_water - BANK_M
        for at, half in self.underpasses:
            free = np.minimum(free, np.abs(grid[..., 1] - at) - half)
        beside = np.abs(grid[..., 0] - self.rail) - CROWN_M
        raised = np.clip(1 - beside / SLOPE_M, 0, 1) * np.clip(free / ABUTMENT_M, 0, 1)
        return level + (self.railway(grid[..., 1]) - level) * raised
