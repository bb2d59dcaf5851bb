"""The contents of a town: buildings, trees, parked cars, people and furniture of its blocks and streets."""

from itertools import cycle
from typing import Final

import numpy as np

from sunset_town.buildings import apartment, hall, house, tower
from sunset_town.frame import Pair
from sunset_town.furnish import CAR_TINTS, COUNTRY_M, EDGE_M, Builder
from sunset_town.ground import Surface
from sunset_town.layout import PAVEMENT_M, Block, BlockKind, Street
from sunset_town.paving import NARROW_M, parking_stalls
from sunset_town.relief import CROWN_M
from sunset_town.things import TREES


def _scatter(builder: Builder, block: Block, per_100_m2: float, heights: Pair) -> None:
    """Plant trees, most of them in groups of a kind, some alone."""
    low, high = np.asarray(block.low) + 2, np.asarray(block.high) - 2
    left = int(block.size[0] * block.size[1] / 100 * per_100_m2)
    while left > 0:
        group = min(left, int(builder.rng.integers(2, 9)) if builder.chance(0.45) else 1)
        centre, height = builder.rng.uniform(low, high), float(builder.rng.uniform(*heights))
        kind = builder.kind()
        for _ in range(group):
            spot = np.clip(centre + builder.rng.normal(0, 2.2 + group * 0.45, 2) * (group > 1), low, high)
            builder.tree(spot, height * builder.rng.uniform(0.7, 1.2), kind)
        left -= group


def _perimeter(builder: Builder, block: Block) -> None:
    """Flats along the two long edges and part of the short ones, a planted yard between."""
    rng, depth = builder.rng, 12.0
    (u0, v0), (u1, v1) = block.low, block.high
    for v in (v0 + depth / 2 + 0.8, v1 - depth / 2 - 0.8):
        u = u0 + 0.8
        while u < u1 - 10:
            length = min(rng.uniform(13, 24), u1 - 0.8 - u)
            builder.build(apartment, (u + length / 2, v), (length - 0.4, depth))
            u += length
    inner = v1 - v0 - 2 * depth - 6
    if inner > 12:
        for u in (u0 + depth / 2 + 0.8, u1 - depth / 2 - 0.8):
            if builder.chance(0.6):
                builder.build(apartment, (u, (v0 + v1) / 2), (inner, depth), turned=True)
    _scatter(builder, block, 1.1, (5, 10))
    builder.skip(((u0 + u1) / 2, (v0 + v1) / 2 + 4), "container")


def _towers(builder: Builder, block: Block) -> None:
    (u0, v0), (u1, v1) = block.low, block.high
    count = 2 if block.size[0] > 52 else 1
    for index in range(count):
        u = u0 + (u1 - u0) * (index + 0.5) / count
        size = (builder.rng.uniform(15, 19), builder.rng.uniform(16, 24))
        builder.build(tower, (u, (v0 + v1) / 2 + builder.rng.uniform(-4, 4)), size)
    _scatter(builder, block, 0.9, (4, 8))
    for u in np.arange(u0 + 14, u1 - 12, 8.0).tolist():
        builder.put("planter", (u, v0 + 3.5))
    builder.put("kiosk", ((u0 + u1) / 2, v1 - 4), turn=builder.rng.uniform(0, 3))
    builder.crowd(((u0 + u1) / 2, v1 - 6), 4, 2.0)


def _houses(builder: Builder, block: Block) -> None:
    """Two rows of gardens, each with a house, a hedge or fence, trees and a car."""
    (u0, v0), (u1, v1) = block.low, block.high
    middle, count = (v0 + v1) / 2, max(1, int((u1 - u0) / 16))
    plot = (u1 - u0) / count
    for row, front in ((-1, v0), (1, v1)):
        for index in range(count):
            u = u0 + plot * (index + 0.5)
            size = (builder.rng.uniform(8.5, 10.5), builder.rng.uniform(7.5, 9.5))
            builder.build(house, (u - 1.5, front - row * (size[1] / 2 + 4)), size, turned=builder.chance(0.3))
            if builder.chance(0.75):
                builder.car((u + plot / 2 - 2.2, front - row * 4), 1)
            edge = "hedge" if builder.chance(0.4) else "fence"
            tint = (0.9, 0.88, 0.84) if builder.chance(0.5) else (0.45, 0.32, 0.22)
            builder.line(edge, (u + plot / 2, front - row * 7), (u + plot / 2, middle), 1.7, tint=tint)
            builder.line(
                edge, (u - plot / 2, front - row * 0.4), (u + plot / 2 - 4, front - row * 0.4), 1.1, tint=tint
            )
    builder.line("fence", (u0, middle), (u1, middle), 1.8, tint=(0.5, 0.36, 0.25))
    _scatter(builder, block, 1.2, (3.5, 8))


def _park(builder: Builder, block: Block) -> None:
    (u0, v0), (u1, v1) = block.low, block.high
    builder.put("kiosk", (u0 + 7, v0 + 6), turn=builder.rng.uniform(0, 3))
    builder.crowd((u0 + 8, v0 + 9), 3, 1.2)
    _scatter(builder, block, 1.6, (5, 13))
    for _ in range(25):
        builder.tree(
            (builder.rng.uniform(u0, u1), builder.rng.uniform(v0, v1)), builder.rng.uniform(1, 2.2), TREES - 1
        )
    for _ in range(4):
        builder.crowd(builder.rng.uniform(block.low, block.high), int(builder.rng.integers(1, 5)), 1.0)
    if block.index % 2:
        for v in (v0, v1):
            builder.line("hedge", (u0 + 4, v), (u1 - 4, v), 1.2)


def _plaza(builder: Builder, block: Block) -> None:
    (u0, v0), (u1, v1) = block.low, block.high
    centre = ((u0 + u1) / 2, (v0 + v1) / 2)
    builder.put("monument", centre)
    for _ in range(6):
        spot = builder.rng.uniform(np.asarray(block.low) + 4, np.asarray(block.high) - 4)
        builder.crowd(spot, int(builder.rng.integers(1, 6)), 0.9)
    for u in np.arange(u0 + 5, u1 - 4, 9.0).tolist():
        builder.tree((u, v0 + 4), 6.5, 1)
        builder.tree((u, v1 - 4), 6.5, 2)
    for u, v in ((u0 + 8, centre[1] + 8), (u1 - 8, centre[1] - 8), (u0 + 10, centre[1] - 9)):
        builder.put("kiosk", (u, v), turn=builder.rng.uniform(0, 3))
        builder.crowd((u + 1, v - 3), 5, 1.6)
        builder.put("planter", (u + 5, v))


def _parking(builder: Builder, block: Block) -> None:
    """Cars stand close together at one end and ever fewer towards the other; some rows are empty."""
    stalls = parking_stalls(block)
    nearness = np.abs(stalls - np.asarray(block.low if builder.chance(0.5) else block.high)).sum(axis=1)
    share = builder.rng.uniform(0.4, 0.9) * (1 - 0.85 * nearness / nearness.max())
    for stall, filled in zip(stalls, share, strict=True):
        if builder.chance(float(filled)):
            builder.car(stall, 1)
    (u0, v0), (u1, v1) = block.low, block.high
    for u in (u0 + 0.6, u1 - 0.6):
        builder.line("rail guard", (u, v0 + 2), (u, v1 - 2), 0.8)


def _industry(builder: Builder, block: Block) -> None:
    (u0, v0), (u1, v1) = block.low, block.high
    depth = (v1 - v0) * 0.5
    halls = 2 if u1 - u0 > 75 else 1
    width = (u1 - u0) / halls
    for index in range(halls):
        for share in (1.0, 0.85, 0.7, 0.5):  # the largest that fits between bent streets
            middle = (u0 + width * (index + 0.5), v0 + depth / 2 + 4)
            if builder.build(hall, middle, ((width - 9) * share, depth * share)):
                break
    for _ in range(int(block.size[0] * block.size[1] / 500)):
        spot = builder.rng.uniform(u0 + 6, u1 - 6), v0 + depth + builder.rng.uniform(6, max(7, depth - 15))
        builder.skip(spot, "container", int(builder.rng.integers(2)))
    for u in np.arange(u0 + 6, u1 - 5, 4.2).tolist():
        chance = builder.rng.random()
        if chance < 0.4:
            builder.put(
                "truck", (u, v1 - 9), axis=1, tint=CAR_TINTS[int(builder.rng.integers(len(CAR_TINTS)))]
            )
        elif chance < 0.8:
            builder.skip((u, v1 - 8), "container", 1)
    near, far, *ends = block.sides
    for start, end in ((far[0], (u1 - 9, v1)), near, *ends):
        builder.line("wall", start, end, 2.4, tint=(0.62, 0.5, 0.42))


def _site(builder: Builder, block: Block) -> None:
    (u0, v0), (u1, v1) = block.low, block.high
    for start, end in block.sides:
        builder.line("fence", start, end, 2.0, tint=(0.75, 0.77, 0.8))
    shell = (min(24.0, u1 - u0 - 24), min(13.0, (v1 - v0) / 2 - 9))
    builder.build(apartment, ((u0 + u1) / 2, (v0 + v1) / 2 + 12.5), shell)
    for _ in range(int(block.size[0] * block.size[1] / 350)):
        spot = builder.rng.uniform(u0 + 6, u1 - 6), builder.rng.uniform(v0 + 5, v1 - 5)
        builder.skip(spot, "container", int(builder.rng.integers(2)))
    builder.build(hall, (u0 + 14, v0 + 12), (14, 10))
    for _ in range(2):
        builder.put("truck", (builder.rng.uniform(u0 + 8, u1 - 8), v1 - 7), tint=(0.85, 0.6, 0.1))


def _riverbank(builder: Builder, block: Block) -> None:
    _scatter(builder, block, 1.0, (5, 12))
    (u0, v0), (u1, v1) = block.low, block.high
    for v in (v0 + 0.3, v1 - 0.3):
        builder.line("rail guard", (u0 + 3, v), (u1 - 3, v), 1.0)


def _sport(builder: Builder, block: Block) -> None:
    """A pitch in play within a fence, trees around it."""
    (u0, v0), (u1, v1) = block.low, block.high
    centre = ((u0 + u1) / 2, (v0 + v1) / 2)
    builder.crowd(centre, 14, min(block.size) / 5)
    for start, end in block.sides[:3]:
        builder.line("fence", start, end, 2.2, tint=(0.3, 0.42, 0.34))
    builder.build(hall, (u1 - 5, v0 + 6), (7, 9))
    for u in np.arange(u0 + 3, u1 - 2, 9.0).tolist():
        for v in (v0 + 2, v1 - 2):
            if builder.chance(0.7):
                builder.tree((u, v), builder.rng.uniform(5, 10))


def _allotments(builder: Builder, block: Block) -> None:
    """Small gardens with huts, bushes, fruit trees and fences."""
    (u0, v0), (u1, v1) = block.low, block.high
    for u in np.arange(u0 + 8, u1 - 4, 13.0).tolist():
        for v in np.arange(v0 + 4, v1 - 3, 11.0).tolist():
            if builder.chance(0.5):
                builder.build(house, (u, v), (builder.rng.uniform(3, 4.2), builder.rng.uniform(3, 4.5)))
            builder.tree((u + 4, v + 3), builder.rng.uniform(1, 2), TREES - 1)
            builder.crowd((u + 3, v), int(builder.chance(0.25)), 1.0)
        builder.line("fence", (u + 5, v0), (u + 5, v1), 1.2, tint=(0.5, 0.4, 0.3))
    for v in (v0 + 0.5, v1 - 0.5):
        builder.line("hedge", (u0, v), (u1, v), 1.5)
    _scatter(builder, block, 0.8, (2.5, 5))


def _railside(builder: Builder, block: Block) -> None:
    (u0, v0), (u1, v1) = block.low, block.high
    rail = builder.plan.relief.rail
    for u in (u0 + 0.5, u1 - 0.5):
        builder.line("wall", (u, v0), (u, v1), 1.8, tint=(0.66, 0.62, 0.56))
    for side in (-1, 1):
        builder.line("rail guard", (rail + side * 5.1, v0 + 1.5), (rail + side * 5.1, v1 - 1.5), 0.9)
    for v in np.arange(v0 + 6, v1 - 4, 24.0).tolist():
        builder.put("mast", (rail - 4.9, v))
    _scatter(builder, block, 1.0, (2.0, 5))


_FILLERS: Final = {
    BlockKind.PERIMETER: _perimeter,
    BlockKind.TOWERS: _towers,
    BlockKind.HOUSES: _houses,
    BlockKind.PARK: _park,
    BlockKind.PLAZA: _plaza,
    BlockKind.PARKING: _parking,
    BlockKind.INDUSTRY: _industry,
    BlockKind.SITE: _site,
    BlockKind.RIVERBANK: _riverbank,
    BlockKind.RAILSIDE: _railside,
    BlockKind.SPORT: _sport,
    BlockKind.ALLOTMENTS: _allotments,
}


def plant_country(builder: Builder) -> None:
    """Let 1800 bushes stand for woods and hedges around the town."""
    rng, warp = builder.rng, builder.plan.warp
    grid = rng.uniform(-1.2 * COUNTRY_M, 1.2 * COUNTRY_M, (20_000, 2))
    world = warp.points(grid)
    away = np.abs(world).max(axis=1)
    wooded = builder.ground.at(world[:, 0], world[:, 1]) == Surface.SHRUBS
    for u, v in grid[wooded & (away > EDGE_M)][:1800].tolist():
        height = rng.uniform(5, 12)
        tint = rng.uniform(0.2, 0.34), rng.uniform(0.3, 0.4), rng.uniform(0.12, 0.2)
        scale = (height * 0.75, height * 0.75, height)
        builder.put(f"tree {TREES - 1}", (u, v), turn=u, scale=scale, tint=tint)


def fill_blocks(builder: Builder) -> None:
    """Fill every block of the plan that lies at least partly in the town."""
    for block in builder.plan.blocks:
        if builder.plan.is_built(block):
            _FILLERS[block.kind](builder, block)


BRIDGE_M: Final = 12.0
"""Least distance of bus stops from the river's water."""


def furnish_streets(builder: Builder) -> None:
    """Furnish every street between its crossings, and the crossings themselves."""
    for street in builder.plan.streets:
        for before, after in builder.plan.stretches(street):
            stretch = (before.at + before.width / 2, after.at - after.width / 2)
            _lamps(builder, street, stretch)
            _planting(builder, street, stretch)
            _crossing_signs(builder, street, after, stretch[1], 1)
            _crossing_signs(builder, street, before, stretch[0], -1)
            if street.width > NARROW_M and builder.chance(0.75 if street.avenue else 0.25):
                _stop(builder, street, stretch)
        if street.axis == 1:
            _bridge(builder, street)


def furnish_railway(builder: Builder) -> None:
    """Girders and rails on both edges of the railway's bridges."""
    relief = builder.plan.relief
    for start, end in relief.rail_spans:
        for side in (-1, 1):
            u = relief.rail + side * (CROWN_M - 0.2)
            ends = (u, start), (u, end)
            builder.line("pier", *ends, 1.7, level=lambda uv: float(relief.railway(uv[1])) - 1.1)
            builder.line("rail guard", *ends, 0.6, level=lambda uv: float(relief.railway(uv[1])) + 0.6)


def _lamps(builder: Builder, street: Street, stretch: Pair) -> None:
    places = np.arange(stretch[0] + 8, stretch[1] - 6, 15.0).tolist()
    for at, side in zip(places, cycle((1, -1)), strict=False):
        uv = street.points(at, side * (street.width / 2 + 0.5))
        turn = np.pi if side > 0 else 0.0  # to face the carriageway
        builder.put("lamp", uv, axis=1 - street.axis, turn=turn)


def _planting(builder: Builder, street: Street, stretch: Pair) -> None:
    """Trees on an avenue's pavements; parked cars, some skips, half on a side street's pavement."""
    rng = builder.rng
    for side in (-1, 1):
        edge = street.width / 2
        if street.avenue:
            for at in np.arange(stretch[0] + 11, stretch[1] - 9, 11.0).tolist():
                uv = street.points(at, side * (edge + PAVEMENT_M + 0.4))
                builder.tree(uv, rng.uniform(6, 9), int(rng.integers(4)))
            continue
        if builder.chance(0.35):
            continue
        for at in np.arange(stretch[0] + 11, stretch[1] - 10, 6.2).tolist():
            chance = rng.random()
            uv = street.points(at, side * (edge + 0.95))
            if chance < 0.55:
                builder.car(uv, street.axis)
            elif chance < 0.6:
                builder.skip(uv, axis=street.axis)


def _crossing_signs(builder: Builder, street: Street, other: Street, at: float, direction: int) -> None:
    """Traffic lights where an avenue takes part, else a sign, to the right of approaching traffic."""
    rng = builder.rng
    side = direction * street.right
    uv = street.points(at - direction * 0.6, side * (street.width / 2 + 0.7))
    turn = 0.0 if direction > 0 else np.pi
    if street.avenue or other.avenue:
        builder.put("traffic light", uv, axis=street.axis, turn=turn)
    elif builder.chance(0.6):
        tint = ((0.8, 0.12, 0.1), (0.1, 0.25, 0.7), (0.9, 0.75, 0.1))[int(rng.integers(3))]
        builder.put("sign", uv, axis=street.axis, turn=turn, tint=tint)
    if street.avenue and builder.chance(0.35):
        back = street.points(at - direction * 14, side * (street.width / 2 + 0.8))
        builder.put("gantry", back, axis=street.axis, turn=turn)


def _stop(builder: Builder, street: Street, stretch: Pair) -> None:
    """A bus stop in the middle of a stretch, facing the carriageway, unless it is a bridge."""
    middle = (stretch[0] + stretch[1]) / 2 + 3
    side = 1 if builder.chance(0.5) else -1
    uv = street.points(middle, side * (street.width / 2 + 1.9))
    if builder.plan.relief.off_water(uv) < BRIDGE_M:
        return
    facing = 0.0 if (side > 0) == (street.axis == 0) else np.pi
    builder.put("bus stop", uv, axis=street.axis, turn=facing)


def _bridge(builder: Builder, street: Street) -> None:
    """Rails on both edges of the bridge that carries a street over the river."""
    relief = builder.plan.relief
    river, half = float(relief.river_v(street.at)), relief.river_width / 2 + 7
    for side in (-1, 1):
        u = street.at + side * (street.width / 2 + PAVEMENT_M - 0.2)
        ends = (u, river - half), (u, river + half)
        builder.line("pier", *ends, 1.25, level=lambda uv: float(relief.streets(uv)) - 1.2)
        builder.line("rail guard", *ends, 1.1)
        for uv in ends:
            builder.put("pier", uv, scale=(1.2, 1.2, 1.8))
