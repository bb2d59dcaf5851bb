"""Paints the ground of a town: fields, blocks, river, railway, streets and their markings."""

from collections.abc import Callable
from typing import Final

import numpy as np

from sunset_town.frame import Pair, Points
from sunset_town.ground import Ground, Painter, Sheet, Surface
from sunset_town.layout import EXTENT_M, PAVEMENT_M, Block, BlockKind, Street, TownPlan
from sunset_town.seeding import generator

NARROW_M: Final = 7.0
"""A narrower carriageway has no centre line."""
COUNTRY_M: Final = 1536.0
FIELD_M: Final = 120.0
FIELDS: Final = {
    Surface.FIELD: 0.2,
    Surface.CROPS: 0.24,
    Surface.STUBBLE: 0.16,
    Surface.FALLOW: 0.1,
    Surface.GRASS: 0.14,
    Surface.SHRUBS: 0.16,
}


def paint_ground(plan: TownPlan) -> Ground:
    """Return the ground of a town as its plan says."""
    town, country = Painter(plan, EXTENT_M, 4096), Painter(plan, COUNTRY_M, 2048)
    for painter in (town, country):
        _paint_fields(painter)
        for block in plan.blocks:
            if plan.is_built(block) and (painter is town or plan.is_edge(block)):
                paint_block(painter, block)
        along = np.arange(-COUNTRY_M, COUNTRY_M, 4.0)
        painter.curve(plan.river_points(along), plan.relief.river_width + 2.5, Surface.EARTH)
        painter.curve(plan.river_points(along), plan.relief.river_width, Surface.WATER)
        painter.curve(np.column_stack([np.full(len(along), plan.relief.rail), along]), 9.5, Surface.BALLAST)
    _paint_rails(town)
    bare = town.image.copy()
    for painter in (town, country):
        _paint_streets(painter)
    wet = (bare == Surface.WATER) | (bare == Surface.EARTH)
    town.image[wet & ((town.image == Surface.PAVING) | (town.image == Surface.KERB))] = Surface.DECK
    for street in plan.streets:
        _paint_markings(town, street)
    for image in (town.image, bare, country.image):
        image.flags.writeable = False
    return Ground(Sheet(town.image, EXTENT_M), Sheet(bare, EXTENT_M), Sheet(country.image, COUNTRY_M))


def _paint_fields(painter: Painter) -> None:
    """Paint fields of uneven shape, with hedges between some of them."""
    rng = generator(painter.plan.number, "town", "fields")
    count = int(1.45 * COUNTRY_M / FIELD_M)
    steps = np.arange(-count, count + 1) * FIELD_M
    corners = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1)
    corners += rng.uniform(-0.3, 0.3, corners.shape) * FIELD_M
    kinds = rng.choice(list(FIELDS), p=list(FIELDS.values()), size=(len(steps) - 1, len(steps) - 1))
    hedged = rng.random(kinds.shape) < 0.5
    for i, j in np.ndindex(*kinds.shape):
        ring = np.stack([corners[i, j], corners[i + 1, j], corners[i + 1, j + 1], corners[i, j + 1]])
        painter.polygon(ring, list(Surface)[int(kinds[i, j])])
    for i, j in np.argwhere(hedged):
        painter.curve(np.stack([corners[i, j], corners[i + 1, j]]), 5.0, Surface.SHRUBS)


def _paint_rails(painter: Painter) -> None:
    rail, along = painter.plan.relief.rail, np.arange(-432.0, 433.0, 4.0)
    for track in (-2.3, 2.3):
        for at in np.arange(-430.0, 430.0, 0.9):
            low, high = (rail + track - 1.15, float(at)), (rail + track + 1.15, float(at) + 0.35)
            painter.quad(low, high, Surface.SLEEPER)
        for side in (-0.72, 0.72):
            line = np.column_stack([np.full(len(along), rail + track + side), along])
            painter.curve(line, 0.26, Surface.RAIL)


def _paint_streets(painter: Painter) -> None:
    """Paint the streets of the town; avenues go on as country roads."""
    plan = painter.plan
    for street in plan.streets:
        if street.avenue:
            along = np.arange(-COUNTRY_M, COUNTRY_M, 8.0)
            painter.curve(street.points(along), 6.5, Surface.ASPHALT)
    for margin, surface in ((PAVEMENT_M, Surface.PAVING), (0.35, Surface.KERB), (0.0, Surface.ASPHALT)):
        for street in plan.streets:
            half = street.width / 2 + margin
            for before, after in plan.stretches(street):
                painter.strip(street, (before.at, after.at), (-half, half), surface)


def _paint_markings(painter: Painter, street: Street) -> None:
    """Paint a street's lines between its crossings, and zebra crossings at some."""
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
            right = -inward * street.right  # the side of approaching traffic
            across = sorted((right * 0.3, right * (half - 0.3)))
            painter.strip(street, (stop[0], stop[1]), (across[0], across[1]), Surface.MARKING)
            lines[side] = (start, end)[side] + inward * 6.2
        _paint_lanes(painter, street, (lines[0], lines[1]))


def has_zebra(street: Street, other: Street) -> bool:
    """Return whether a street has a zebra crossing and stop lines where it meets another."""
    return street.avenue or other.avenue or int(street.at * 7 + other.at * 11) % 3 == 0


def _paint_lanes(painter: Painter, street: Street, along: Pair) -> None:
    half = street.width / 2
    if street.avenue:
        for offset in (-half + 0.35, -0.25, 0.25, half - 0.35):
            _line(painter, street, along, offset)
        for offset in (-half / 2, half / 2):
            _dashes(painter, street, along, offset)
    elif street.width > NARROW_M:
        _dashes(painter, street, along, 0.0)


def _dashes(painter: Painter, street: Street, along: Pair, offset: float) -> None:
    for at in np.arange(along[0], along[1] - 3, 7.5):
        _line(painter, street, (float(at), float(at) + 3.0), offset)


def _line(painter: Painter, street: Street, along: Pair, offset: float) -> None:
    at = np.linspace(along[0], along[1], 2 + int((along[1] - along[0]) / 6))
    painter.line(street.points(at, offset), Surface.MARKING)


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
