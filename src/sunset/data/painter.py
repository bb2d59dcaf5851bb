"""The brush that paints a town's ground: shapes of the grid, bent as the town is, onto an image."""

from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from sunset.data.frame import Ids, Points
from sunset.data.ground import Surface
from sunset.data.layout import Street, TownPlan

SUBPIXEL_BITS: Final = 4


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

    def quad(self, low: tuple[float, float], high: tuple[float, float], surface: Surface) -> None:
        """Fill a rectangle of the grid, bent as the town is."""
        (u0, v0), (u1, v1) = low, high
        count = 2 + int(max(u1 - u0, v1 - v0) / 6)
        us, vs = np.linspace(u0, u1, count), np.linspace(v0, v1, count)
        sides = [
            np.column_stack([us, np.full(count, v0)]),
            np.column_stack([np.full(count, u1), vs]),
            np.column_stack([us[::-1], np.full(count, v1)]),
            np.column_stack([np.full(count, u0), vs[::-1]]),
        ]
        self.polygon(np.concatenate(sides), surface)

    def strip(
        self, street: Street, along: tuple[float, float], across: tuple[float, float], surface: Surface
    ) -> None:
        """Fill part of a street: positions along it, offsets across it, in metres."""
        s, c = along, (street.at + across[0], street.at + across[1])
        low, high = ((s[0], c[0]), (s[1], c[1])) if street.axis == 0 else ((c[0], s[0]), (c[1], s[1]))
        self.quad(low, high, surface)

    def line(self, uv: Points, surface: Surface) -> None:
        """Draw a line through points (N, 2) as thin as the image allows, 0.15 m in a town."""
        cells = [self._pixels(uv)]
        cv2.polylines(self.image, cells, isClosed=False, color=int(surface), shift=SUBPIXEL_BITS)

    def ellipse(self, centre: tuple[float, float], radii: tuple[float, float], surface: Surface) -> None:
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
