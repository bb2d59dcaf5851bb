"""The ground of a town: an image of surfaces, painted from the plan.

The image has `Surface` values, down to lane markings, that the renderer looks up under each ray. A second image shows
the ground without its streets: the ground below street bridges and on the railway's bridges.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Final, Self

import cv2
import numpy as np
import numpy.typing as npt

from sunset_town.frame import CARLA_IDS, Ids, Pair, Points
from sunset_town.layout import EXTENT_M, Street, TownPlan

SUBPIXEL_BITS: Final = 4


class Surface(IntEnum):
    """The covers of the ground: class; display colour; strength of broad patches; strength of grain."""

    label: str
    colour: tuple[float, float, float]
    patches: float
    grain: float

    def __new__(cls, label: str, colour: tuple[float, float, float], patches: float, grain: float) -> Self:
        """Number the members from 0."""
        self = int.__new__(cls, len(cls.__members__))
        self._value_ = len(cls.__members__)
        self.label, self.colour, self.patches, self.grain = label, colour, patches, grain
        return self

    FIELD = "terrain", (0.45, 0.46, 0.29), 0.35, 0.1
    LAWN = "terrain", (0.37, 0.43, 0.25), 0.22, 0.12
    GRASS = "terrain", (0.39, 0.43, 0.26), 0.3, 0.14
    ASPHALT = "road", (0.39, 0.39, 0.39), 0.16, 0.06
    MARKING = "road line", (0.8, 0.8, 0.78), 0.14, 0.05
    PAVING = "sidewalk", (0.57, 0.56, 0.53), 0.14, 0.06
    KERB = "sidewalk", (0.64, 0.63, 0.61), 0.1, 0.05
    PLAZA = "ground", (0.61, 0.57, 0.52), 0.14, 0.06
    EARTH = "ground", (0.5, 0.43, 0.34), 0.35, 0.14
    PATH = "ground", (0.63, 0.57, 0.47), 0.16, 0.1
    WATER = "water", (0.17, 0.23, 0.22), 0.2, 0.0
    DECK = "bridge", (0.55, 0.54, 0.53), 0.12, 0.05
    BALLAST = "rail track", (0.44, 0.4, 0.37), 0.15, 0.2
    SLEEPER = "rail track", (0.35, 0.31, 0.28), 0.1, 0.1
    RAIL = "rail track", (0.52, 0.5, 0.49), 0.1, 0.05
    SHRUBS = "vegetation", (0.27, 0.34, 0.2), 0.35, 0.3
    CROPS = "terrain", (0.48, 0.47, 0.3), 0.35, 0.12
    YARD = "ground", (0.52, 0.51, 0.48), 0.22, 0.08
    PITCH = "terrain", (0.33, 0.46, 0.22), 0.14, 0.08
    CHALK = "terrain", (0.74, 0.77, 0.7), 0.1, 0.05
    TARTAN = "ground", (0.58, 0.31, 0.25), 0.12, 0.04
    POOL = "water", (0.3, 0.62, 0.68), 0.06, 0.02
    STUBBLE = "terrain", (0.62, 0.56, 0.36), 0.2, 0.1
    FALLOW = "terrain", (0.43, 0.36, 0.28), 0.25, 0.12


SURFACE_LABELS: Final = np.array([CARLA_IDS[surface.label] for surface in Surface], dtype=np.uint8)
"""Array (24,) uint8: `Surface` → CARLA id."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """A painted square around the town's centre: values of `Surface` (N, N), row = y, column = x.

    It reaches half its side in metres.
    """

    image: Ids
    reach: float

    def at(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Ids:
        """Return the surface at world points; points outside have the surface of the nearest point inside."""
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


class Painter:
    """Draws shapes given in grid coordinates onto an image of a town and the land around it."""

    def __init__(self, plan: TownPlan, reach: float, cells: int) -> None:
        """Begin with an image of fields: a square of cells that reaches so many metres from the centre."""
        self.plan = plan
        self.reach = reach
        self.image: Ids = np.full((cells, cells), Surface.FIELD, dtype=np.uint8)

    def _pixels(self, uv: Points) -> npt.NDArray[np.int32]:
        cells = (self.plan.warp.points(uv) + self.reach) * (len(self.image) / (2 * self.reach)) - 0.5
        return np.round(cells * 2**SUBPIXEL_BITS).astype(np.int32)

    def polygon(self, uv: Points, surface: Surface) -> None:
        """Fill the polygon with corners (N, 2)."""
        cv2.fillPoly(self.image, [self._pixels(uv)], int(surface), cv2.LINE_8, SUBPIXEL_BITS)

    def quad(self, low: Pair, high: Pair, surface: Surface) -> None:
        """Fill a rectangle of the grid, bent as the town is."""
        (u0, v0), (u1, v1) = low, high
        count = 2 + int(max(u1 - u0, v1 - v0) / 6)
        us, vs = np.linspace(u0, u1, count), np.linspace(v0, v1, count)
        sides = (us, v0), (u1, vs), (us[::-1], v1), (u0, vs[::-1])
        self.polygon(np.concatenate([np.column_stack(np.broadcast_arrays(*side)) for side in sides]), surface)

    def strip(self, street: Street, along: Pair, across: Pair, surface: Surface) -> None:
        """Fill part of a street: positions along it, offsets across it, in metres."""
        s, c = along, (street.at + across[0], street.at + across[1])
        low, high = ((s[0], c[0]), (s[1], c[1])) if street.axis == 0 else ((c[0], s[0]), (c[1], s[1]))
        self.quad(low, high, surface)

    def line(self, uv: Points, surface: Surface) -> None:
        """Draw a line through points (N, 2) as thin as the image allows, 0.15 m in a town."""
        cells = [self._pixels(uv)]
        cv2.polylines(self.image, cells, isClosed=False, color=int(surface), shift=SUBPIXEL_BITS)

    def ellipse(self, centre: Pair, radii: Pair, surface: Surface) -> None:
        """Fill an uneven ellipse."""
        angles = np.linspace(0, 2 * np.pi, 48, endpoint=False)
        wobble = 1 + 0.13 * np.sin(3 * angles + centre[0]) + 0.07 * np.sin(5 * angles + centre[1])
        ring = np.column_stack([np.cos(angles) * radii[0] * wobble, np.sin(angles) * radii[1] * wobble])
        self.polygon(ring + np.asarray(centre), surface)

    def curve(self, uv: Points, width: float, surface: Surface) -> None:
        """Fill a band of constant width along a line."""
        direction = np.gradient(uv, axis=0)
        normal = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
        normal *= width / 2 / np.linalg.norm(normal, axis=1, keepdims=True)
        self.polygon(np.concatenate([uv + normal, (uv - normal)[::-1]]), surface)
