"""The ground inside blocks: lawns, paths, ponds, pitches, pools, parking stalls."""

from collections.abc import Callable
from typing import Final

import numpy as np

from sunset_town.frame import Points
from sunset_town.ground import Painter, Surface
from sunset_town.layout import Block, BlockKind


def paint_block(painter: Painter, block: Block) -> None:
    """Paint what a block is used for."""
    base, paint = _USES[block.kind]
    painter.quad(block.low, block.high, base)
    if paint is not None:
        paint(painter, block)


def _paint_parking(painter: Painter, block: Block) -> None:
    for u, v in parking_stalls(block).tolist():
        ends = np.array([(u - 1.3, v - 2.6), (u - 1.3, v + 2.6)])
        painter.line(ends, Surface.MARKING)


def _paint_site(painter: Painter, block: Block) -> None:
    """Tracks, concrete and heaps of sand on bare earth."""
    (u0, v0), (u1, v1) = block.low, block.high
    u, v = (u0 + u1) / 2, (v0 + v1) / 2
    painter.quad((u0, v - 2.5), (u1, v + 2.5), Surface.FALLOW)
    painter.quad((u - 11, v + 5), (u + 12, min(v + 20, v1 - 2)), Surface.YARD)
    for index in range(5):
        centre = (u0 + (u1 - u0) * (0.12 + 0.19 * index), v0 + (v1 - v0) * (0.2 + 0.11 * (index * 3 % 5)))
        surface = (Surface.PATH, Surface.STUBBLE, Surface.GRASS)[index % 3]
        painter.ellipse(centre, (5.0 + index % 2 * 3, 4.0), surface)


def _paint_towers(painter: Painter, block: Block) -> None:
    (u0, v0), (u1, v1) = block.low, block.high
    painter.quad((u0 + 2, v0 + 2), (u0 + (u1 - u0) * 0.22, v1 - 2), Surface.LAWN)
    painter.quad((u1 - (u1 - u0) * 0.22, v0 + 2), (u1 - 2, v1 - 2), Surface.LAWN)
    if block.size[0] > 60:
        painter.ellipse(((u0 + u1) / 2, (v0 + v1) / 2), (8, block.size[1] * 0.3), Surface.GRASS)


def _paint_plaza(painter: Painter, block: Block) -> None:
    (u0, v0), (u1, v1) = block.low, block.high
    painter.ellipse(((u0 + u1) / 2, (v0 + v1) / 2), (9, 7), Surface.LAWN)
    for u in (u0 + 3, u1 - 9):
        painter.quad((u, v0 + 12), (u + 6, v1 - 12), Surface.LAWN)


def _paint_perimeter(painter: Painter, block: Block) -> None:
    """A yard between the houses: lawn with a path, or paved, with parking or a playground."""
    (u0, v0), (u1, v1) = block.low, block.high
    middle = (v0 + v1) / 2
    if block.index % 3 == 0:
        painter.quad((u0 + 14, v0 + 14), (u1 - 14, v1 - 14), Surface.YARD)
        painter.ellipse(((u0 + u1) / 2, middle), (7, 4), Surface.LAWN)
    elif block.index % 3 == 1:
        painter.ellipse((u0 + block.size[0] * 0.35, middle + 2), (5, 4), Surface.EARTH)
    painter.quad((u0 + 15, middle - 1), (u1 - 15, middle + 1), Surface.PATH)


def _paint_houses(painter: Painter, block: Block) -> None:
    """Drives to the street, terraces, beds, and here and there a pool."""
    (u0, v0), (u1, v1) = block.low, block.high
    middle, count = (v0 + v1) / 2, max(1, int((u1 - u0) / 16))
    plot = (u1 - u0) / count
    for row, front in ((-1, v0), (1, v1)):
        for index in range(count):
            u, draw = u0 + plot * (index + 0.5), (block.index * 31 + index * 17 + row * 5) % 7
            drive = sorted((front, front - row * 8))
            painter.quad((u + plot / 2 - 3.6, drive[0]), (u + plot / 2 - 0.8, drive[1]), Surface.YARD)
            back = sorted((middle + row * 2.0, middle + row * 6.0))
            if draw == 0:
                painter.quad((u - 3.6, back[0] - 0.6), (u + 4.1, back[1] + 0.6), Surface.PLAZA)
                painter.quad((u - 3, back[0]), (u + 3.5, back[1]), Surface.POOL)
            elif draw in (1, 2):
                painter.quad((u - 5, back[0]), (u + 1, back[1]), Surface.FALLOW)
            elif draw == 3:
                painter.ellipse((u, middle + row * 4), (4.5, 2.5), Surface.SHRUBS)


def _paint_sport(painter: Painter, block: Block) -> None:
    """A football pitch along the block, with a running track where there is room, and a court."""
    (u0, v0), (u1, v1) = block.low, block.high
    u, v = (u0 + u1) / 2, (v0 + v1) / 2
    half = np.array([block.size[0] / 2 - 7, block.size[1] / 2 - 7])
    if min(half) > 15:
        painter.quad((u - half[0] - 4, v - half[1] - 4), (u + half[0] + 4, v + half[1] + 4), Surface.TARTAN)
    for stripe in range(8):
        low = u - half[0] + half[0] / 4 * stripe
        surface = Surface.PITCH if stripe % 2 else Surface.LAWN
        painter.quad((low, v - half[1]), (low + half[0] / 4, v + half[1]), surface)
    ring = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])
    for scale in ((0.97, 0.95), (0.0, 0.95)):
        painter.line(ring * half * scale + (u, v), Surface.CHALK)
    for side in (-1, 1):
        painter.line(ring * half * (0.12, 0.4) + (u + side * half[0] * 0.85, v), Surface.CHALK)
    angles = np.linspace(0, 2 * np.pi, 25)
    painter.line(np.column_stack([np.cos(angles), np.sin(angles)]) * 6 + (u, v), Surface.CHALK)


def _paint_allotments(painter: Painter, block: Block) -> None:
    """Many small gardens: beds, lawns and earth, with paths between."""
    (u0, v0), (u1, v1) = block.low, block.high
    beds = (Surface.FALLOW, Surface.CROPS, Surface.LAWN, Surface.EARTH, Surface.SHRUBS, Surface.LAWN)
    columns, rows = int(block.size[0] / 9), int(block.size[1] / 7)
    for i, j in np.ndindex(columns, rows):
        u, v = u0 + block.size[0] / columns * i, v0 + block.size[1] / rows * j
        surface = beds[(i * 7 + j * 5 + i * j * 3 + block.index) % len(beds)]
        painter.quad((u + 1, v + 0.8), (u + 5.2 + (i * j) % 3, v + 5.4), surface)
    middle = (v0 + v1) / 2
    painter.quad((u0, middle - 1.1), (u1, middle + 1.1), Surface.PATH)


def _paint_park(painter: Painter, block: Block) -> None:
    (u0, v0), (u1, v1) = block.low, block.high
    u, v = (u0 + u1) / 2, (v0 + v1) / 2
    ends = ((u0, v0), (u1, v1)), ((u0, v1), (u1, v0))
    for (a, b), (c, d) in ends if block.index % 3 else ends[:1]:
        steps = np.linspace(0, 1, 24)
        bow = np.sin(steps * np.pi) * block.size[1] * 0.18
        painter.curve(np.column_stack([a + (c - a) * steps, b + (d - b) * steps + bow]), 2.4, Surface.PATH)
    if block.index % 2 == 0:
        centre = (u + block.size[0] * 0.16, v)
        painter.ellipse(centre, (block.size[0] * 0.24, block.size[1] * 0.26), Surface.SHRUBS)
        painter.ellipse(centre, (block.size[0] * 0.21, block.size[1] * 0.22), Surface.WATER)


_USES: Final[dict[BlockKind, tuple[Surface, Callable[[Painter, Block], None] | None]]] = {
    BlockKind.TOWERS: (Surface.PLAZA, _paint_towers),
    BlockKind.PERIMETER: (Surface.LAWN, _paint_perimeter),
    BlockKind.HOUSES: (Surface.LAWN, _paint_houses),
    BlockKind.PARK: (Surface.GRASS, _paint_park),
    BlockKind.PLAZA: (Surface.PLAZA, _paint_plaza),
    BlockKind.PARKING: (Surface.ASPHALT, _paint_parking),
    BlockKind.INDUSTRY: (Surface.YARD, None),
    BlockKind.SITE: (Surface.EARTH, _paint_site),
    BlockKind.RIVERBANK: (Surface.GRASS, None),
    BlockKind.RAILSIDE: (Surface.GRASS, None),
    BlockKind.SPORT: (Surface.LAWN, _paint_sport),
    BlockKind.ALLOTMENTS: (Surface.GRASS, _paint_allotments),
}


def parking_stalls(block: Block) -> Points:
    """Return the centres (N, 2), in grid coordinates, of a parking block's stalls; cars stand along v."""
    us = np.arange(block.low[0] + 5, block.high[0] - 4, 2.6)
    vs = np.arange(block.low[1] + 5, block.high[1] - 4, 15.5)
    rows = np.concatenate([vs, vs + 5.4])
    rows = rows[rows < block.high[1] - 3]
    return np.stack(np.meshgrid(us, rows, indexing="ij"), axis=-1).reshape(-1, 2)
