"""Paints the ground of a town: fields, blocks, river, railway, streets and their markings."""

from typing import Final

import numpy as np

from sunset_town.ground import Ground, Painter, Sheet, Surface
from sunset_town.layout import EXTENT_M, PAVEMENT_M, Street, TownPlan
from sunset_town.lots import paint_block
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


def _paint_lanes(painter: Painter, street: Street, along: tuple[float, float]) -> None:
    half = street.width / 2
    if street.avenue:
        for offset in (-half + 0.35, -0.25, 0.25, half - 0.35):
            _line(painter, street, along, offset)
        for offset in (-half / 2, half / 2):
            _dashes(painter, street, along, offset)
    elif street.width > NARROW_M:
        _dashes(painter, street, along, 0.0)


def _dashes(painter: Painter, street: Street, along: tuple[float, float], offset: float) -> None:
    for at in np.arange(along[0], along[1] - 3, 7.5):
        _line(painter, street, (float(at), float(at) + 3.0), offset)


def _line(painter: Painter, street: Street, along: tuple[float, float], offset: float) -> None:
    at = np.linspace(along[0], along[1], 2 + int((along[1] - along[0]) / 6))
    painter.line(street.points(at, offset), Surface.MARKING)
