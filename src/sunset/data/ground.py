"""The ground of a town: an image of surfaces, painted from the plan.

What lies where, down to lane markings, is an image of `Surface` values that the renderer looks up under each
ray. A second image shows the ground without its streets: what lies below their bridges, and on the railway's.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from sunset.classes import CARLA_IDS
from sunset.data.frame import Ids
from sunset.data.layout import EXTENT_M, PAVEMENT_M, Block, BlockKind, Street, TownPlan

__all__ = ["CELLS_PER_M", "SURFACE_LABELS", "Ground", "Surface", "has_zebra", "paint_ground", "parking_stalls"]

CELLS: Final = 4096
CELLS_PER_M: Final = CELLS / (2 * EXTENT_M)
SUBPIXEL_BITS: Final = 4
NARROW_M: Final = 7.0
"""A narrower carriageway has no centre line."""


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
}

SURFACE_LABELS: Final = np.array([CARLA_IDS[SURFACE_CLASSES[surface]] for surface in Surface], dtype=np.uint8)
"""Array (18,) uint8: `Surface` → CARLA id."""


@dataclass(frozen=True, slots=True)
class Ground:
    """The painted ground.

    Attributes:
        surfaces: values of `Surface` (4096, 4096), row = y, column = x, covering the town's extent.
        bare: the same without streets.
    """

    surfaces: Ids
    bare: Ids

    def at(self, x: npt.ArrayLike, y: npt.ArrayLike, bare: npt.ArrayLike = False) -> Ids:  # noqa: FBT002
        """Return the surface at world points, without streets where `bare`; fields lie outside the town."""
        column = np.floor((np.asarray(x) + EXTENT_M) * CELLS_PER_M).astype(np.int64)
        row = np.floor((np.asarray(y) + EXTENT_M) * CELLS_PER_M).astype(np.int64)
        inside = (column >= 0) & (column < CELLS) & (row >= 0) & (row < CELLS)
        cell = np.clip(row, 0, CELLS - 1), np.clip(column, 0, CELLS - 1)
        found = np.where(bare, self.bare[cell], self.surfaces[cell])
        return np.where(inside, found, np.uint8(Surface.FIELD))


class _Painter:
    """Draws shapes given in grid coordinates onto the image."""

    def __init__(self, plan: TownPlan) -> None:
        self.plan = plan
        self.image: npt.NDArray[np.uint8] = np.full((CELLS, CELLS), Surface.FIELD, dtype=np.uint8)

    def _pixels(self, uv: npt.NDArray[np.float64]) -> npt.NDArray[np.int32]:
        cells = (self.plan.warp.points(uv) + EXTENT_M) * CELLS_PER_M - 0.5
        return np.round(cells * 2**SUBPIXEL_BITS).astype(np.int32)

    def polygon(self, uv: npt.NDArray[np.float64], surface: Surface) -> None:
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

    def line(self, street: Street, along: tuple[float, float], offset: float) -> None:
        """Draw a marking as thin as the image allows, 0.15 m, along part of a street."""
        at = np.linspace(along[0], along[1], 2 + int((along[1] - along[0]) / 6))
        cells = self._pixels(street.points(at, offset))
        cv2.polylines(self.image, [cells], False, int(Surface.MARKING), 1, cv2.LINE_8, SUBPIXEL_BITS)

    def ellipse(self, centre: tuple[float, float], radii: tuple[float, float], surface: Surface) -> None:
        angles = np.linspace(0, 2 * np.pi, 48, endpoint=False)
        wobble = 1 + 0.13 * np.sin(3 * angles + centre[0]) + 0.07 * np.sin(5 * angles + centre[1])
        ring = np.column_stack([np.cos(angles) * radii[0] * wobble, np.sin(angles) * radii[1] * wobble])
        self.polygon(ring + np.asarray(centre), surface)

    def curve(self, uv: npt.NDArray[np.float64], width: float, surface: Surface) -> None:
        """Fill a band of constant width along a line."""
        direction = np.gradient(uv, axis=0)
        normal = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
        normal *= width / 2 / np.linalg.norm(normal, axis=1, keepdims=True)
        self.polygon(np.concatenate([uv + normal, (uv - normal)[::-1]]), surface)


def paint_ground(plan: TownPlan) -> Ground:
    """Return the ground of a town as its plan says."""
    painter = _Painter(plan)
    for block in plan.blocks:
        _paint_block(painter, block)
    along = np.arange(-430.0, 431.0, 4.0)
    painter.curve(plan.river_points(along), plan.relief.river_width + 2.5, Surface.EARTH)
    painter.curve(plan.river_points(along), plan.relief.river_width, Surface.WATER)
    _paint_railway(painter)
    bare = painter.image.copy()
    wet = np.isin(painter.image, (Surface.WATER, Surface.EARTH))
    _paint_streets(painter)
    painter.image[wet & np.isin(painter.image, (Surface.PAVING, Surface.KERB))] = Surface.DECK
    for street in plan.streets:
        _paint_markings(painter, street)
    for image in (painter.image, bare):
        image.flags.writeable = False
    return Ground(painter.image, bare)


_BASE: Final = {
    BlockKind.TOWERS: Surface.PLAZA,
    BlockKind.PERIMETER: Surface.LAWN,
    BlockKind.HOUSES: Surface.LAWN,
    BlockKind.PARK: Surface.GRASS,
    BlockKind.PLAZA: Surface.PLAZA,
    BlockKind.PARKING: Surface.ASPHALT,
    BlockKind.INDUSTRY: Surface.YARD,
    BlockKind.SITE: Surface.EARTH,
    BlockKind.RIVERBANK: Surface.GRASS,
    BlockKind.RAILSIDE: Surface.CROPS,
}


def _paint_block(painter: _Painter, block: Block) -> None:
    painter.quad(block.low, block.high, _BASE[block.kind])
    (u0, v0), (u1, v1) = block.low, block.high
    centre = ((u0 + u1) / 2, (v0 + v1) / 2)
    if block.kind is BlockKind.PARK:
        _paint_park(painter, block)
    elif block.kind is BlockKind.PARKING:
        for stall in parking_stalls(block):
            painter.quad(
                (stall[0] - 1.45, stall[1] - 2.6), (stall[0] - 1.15, stall[1] + 2.6), Surface.MARKING
            )
    elif block.kind is BlockKind.TOWERS:
        painter.quad((u0 + 3, v0 + 3), (u0 + 11, v1 - 3), Surface.LAWN)
        painter.quad((u1 - 11, v0 + 3), (u1 - 3, v1 - 3), Surface.LAWN)
    elif block.kind is BlockKind.PLAZA:
        painter.ellipse(centre, (9, 7), Surface.LAWN)
    elif block.kind is BlockKind.PERIMETER:
        painter.quad((u0 + 15, centre[1] - 1.3), (u1 - 15, centre[1] + 1.3), Surface.PATH)


def _paint_park(painter: _Painter, block: Block) -> None:
    (u0, v0), (u1, v1) = block.low, block.high
    u, v = (u0 + u1) / 2, (v0 + v1) / 2
    ends = ((u0, v0), (u1, v1)), ((u0, v1), (u1, v0))
    for (a, b), (c, d) in ends if block.index % 3 else ends[:1]:
        steps = np.linspace(0, 1, 24)
        bow = np.sin(steps * np.pi) * block.size[1] * 0.18
        painter.curve(np.column_stack([a + (c - a) * steps, b + (d - b) * steps + bow]), 2.4, Surface.PATH)
    if block.index % 2 == 0:
        painter.ellipse(
            (u + block.size[0] * 0.16, v), (block.size[0] * 0.24, block.size[1] * 0.26), Surface.SHRUBS
        )
        painter.ellipse(
            (u + block.size[0] * 0.16, v), (block.size[0] * 0.21, block.size[1] * 0.22), Surface.WATER
        )


def parking_stalls(block: Block) -> npt.NDArray[np.float64]:
    """Return the centres (N, 2), in grid coordinates, of a parking block's stalls; cars stand along v."""
    us = np.arange(block.low[0] + 5, block.high[0] - 4, 2.6)
    vs = np.arange(block.low[1] + 5, block.high[1] - 4, 15.5)
    rows = np.concatenate([vs, vs + 5.4])
    rows = rows[rows < block.high[1] - 3]
    return np.stack(np.meshgrid(us, rows, indexing="ij"), axis=-1).reshape(-1, 2)


def _paint_railway(painter: _Painter) -> None:
    along = np.arange(-430.0, 431.0, 4.0)
    rail = painter.plan.relief.rail
    painter.curve(np.column_stack([np.full(len(along), rail), along]), 9.5, Surface.BALLAST)
    for track in (-2.3, 2.3):
        for at in np.arange(-430.0, 430.0, 0.9):
            low, high = (rail + track - 1.15, float(at)), (rail + track + 1.15, float(at) + 0.35)
            painter.quad(low, high, Surface.SLEEPER)
        for side in (-0.72, 0.72):
            line = np.column_stack([np.full(len(along), rail + track + side), along])
            painter.curve(line, 0.26, Surface.RAIL)


def _paint_streets(painter: _Painter) -> None:
    layers = ((PAVEMENT_M, Surface.PAVING), (0.35, Surface.KERB), (0.0, Surface.ASPHALT))
    for margin, surface in layers:
        for street in painter.plan.streets:
            half = street.width / 2 + margin
            for before, after in painter.plan.stretches(street):
                painter.strip(street, (before.at, after.at), (-half, half), surface)


def _paint_markings(painter: _Painter, street: Street) -> None:
    """Paint one street's lines between its crossings, and zebra crossings at some."""
    for before, after in painter.plan.stretches(street):
        start, end = before.at + before.width / 2, after.at - after.width / 2
        half = street.width / 2
        lines = [start + 1.5, end - 1.5]
        for side, other in enumerate((before, after)):
            if not has_zebra(street, other):
                continue
            inward = 1 - 2 * side
            zebra = sorted(((start, end)[side] + inward * 0.8, (start, end)[side] + inward * 4.0))
            for bar in np.arange(-half + 0.5, half - 0.6, 1.1):
                painter.strip(street, (zebra[0], zebra[1]), (bar, bar + 0.5), Surface.MARKING)
            stop = sorted(((start, end)[side] + inward * 5.0, (start, end)[side] + inward * 5.35))
            # Right-hand traffic: those who approach the end keep to one half, those who approach the start
            # to the other.
            right = (-1 if street.axis == 0 else 1) * (-inward)
            across = sorted((right * 0.3, right * (half - 0.3)))
            painter.strip(street, (stop[0], stop[1]), (across[0], across[1]), Surface.MARKING)
            lines[side] = (start, end)[side] + inward * 6.2
        _paint_lanes(painter, street, (lines[0], lines[1]))


def has_zebra(street: Street, other: Street) -> bool:
    """Say whether a street has a zebra crossing and stop lines where it meets another."""
    return street.avenue or other.avenue or int(street.at * 7 + other.at * 11) % 3 == 0


def _paint_lanes(painter: _Painter, street: Street, along: tuple[float, float]) -> None:
    half = street.width / 2
    if street.avenue:
        for offset in (-0.25, 0.25):
            painter.line(street, along, offset)
        for offset in (-half / 2, half / 2):
            _dashes(painter, street, along, offset)
        for offset in (-half + 0.35, half - 0.35):
            painter.line(street, along, offset)
    elif street.width > NARROW_M:
        _dashes(painter, street, along, 0.0)


def _dashes(painter: _Painter, street: Street, along: tuple[float, float], offset: float) -> None:
    for at in np.arange(along[0], along[1] - 3, 7.5):
        painter.line(street, (float(at), float(at) + 3.0), offset)
