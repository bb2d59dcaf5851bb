"""Buildings: meshes made to measure, with their origin at the middle of the ground floor."""

from typing import Final

import numpy as np

from sunset_town.frame import Pair
from sunset_town.meshes import Colour, Finish, Material, Mesh, box, gable, hip, join, place, shell

FOUNDATION_M: Final = 3.0
"""Depth of walls below the ground floor, for slopes."""
STOREY_M: Final = 3.2
SHOP_M: Final = 4.2

PLASTER: Final[tuple[Colour, ...]] = (
    (0.78, 0.74, 0.66),
    (0.82, 0.8, 0.75),
    (0.72, 0.68, 0.6),
    (0.76, 0.68, 0.54),
    (0.68, 0.68, 0.66),
    (0.74, 0.64, 0.56),
    (0.66, 0.69, 0.64),
    (0.84, 0.82, 0.8),
)
BRICKS: Final = ((0.5, 0.33, 0.27), (0.45, 0.32, 0.27), (0.58, 0.46, 0.38), (0.42, 0.36, 0.33))
CONCRETES: Final = ((0.6, 0.6, 0.58), (0.68, 0.66, 0.62), (0.55, 0.56, 0.57), (0.74, 0.73, 0.71))
TIMBERS: Final = ((0.46, 0.36, 0.27), (0.5, 0.45, 0.38), (0.36, 0.3, 0.27), (0.62, 0.6, 0.56))
GLAZING: Final = ((0.42, 0.46, 0.48), (0.5, 0.52, 0.53), (0.4, 0.4, 0.4), (0.62, 0.62, 0.6))
SHEETS: Final = ((0.64, 0.66, 0.68), (0.72, 0.71, 0.68), (0.46, 0.5, 0.53), (0.55, 0.52, 0.48))
AWNINGS: Final = ((0.5, 0.16, 0.14), (0.18, 0.32, 0.24), (0.72, 0.68, 0.58), (0.2, 0.26, 0.38))
TILES: Final[tuple[Colour, ...]] = (
    (0.5, 0.3, 0.23),
    (0.44, 0.29, 0.24),
    (0.38, 0.3, 0.27),
    (0.54, 0.36, 0.28),
    (0.33, 0.33, 0.34),
    (0.29, 0.28, 0.29),
    (0.42, 0.38, 0.35),
)
ROOF_SHEETS: Final = ((0.42, 0.44, 0.46), (0.36, 0.4, 0.38), (0.55, 0.56, 0.57))
COVERS: Final = (  # colour, material, share
    ((0.42, 0.41, 0.4), Material.ROOF, 0.3),
    ((0.58, 0.57, 0.55), Material.ROOF, 0.16),
    ((0.54, 0.51, 0.47), Material.GRAVEL, 0.3),
    ((0.36, 0.4, 0.26), Material.PLANTED, 0.16),
    ((0.74, 0.74, 0.73), Material.ROOF, 0.08),
)
DECKS: Final = ((0.55, 0.48, 0.4), (0.6, 0.59, 0.57))
PANELS: Final = Finish((0.12, 0.14, 0.2), "building", Material.SOLAR)


def plain(colour: Colour, material: Material = Material.PLAIN) -> Finish:
    """Return the finish of a part of a building."""
    return Finish(colour, "building", material)


def _varied(rng: np.random.Generator, colour: Colour) -> Colour:
    red, green, blue = np.clip(np.asarray(colour) * rng.uniform(0.86, 1.1), 0, 1)
    return float(red), float(green), float(blue)


def pitched_roof(
    rng: np.random.Generator, size: Pair, height: float, wall: Finish, *, steep: float
) -> list[Mesh]:
    """Return a gabled or hipped roof over the eaves' height: tiles or sheets, chimneys, windows, panels.

    Sizes are in metres, gables are made like the wall, `steep` is the rise over the run.
    """
    x, y = size[0] / 2, size[1] / 2
    over = (size[0] + 0.9, size[1] + 0.9)
    tiled = rng.random() < 0.85
    colours, material = (TILES, Material.TILES) if tiled else (ROOF_SHEETS, Material.METAL)
    cover = plain(_varied(rng, colours[int(rng.integers(len(colours)))]), material)
    hipped = rng.random() < 0.35 and x > y
    reach = max(x - y, 1.0) if hipped else x * 0.8
    rise, drop = y * steep, 0.45 * steep
    base = height - drop
    parts = [hip(over, base, rise + drop, cover) if hipped else gable(over, base, rise + drop, cover, wall)]
    for _ in range(int(rng.integers(1, 3))):
        at = rng.uniform(-reach, reach) * 0.9
        side = rng.uniform(-0.35, 0.35) * y
        low, high = (at - 0.4, side - 0.35, height), (at + 0.4, side + 0.35, height + rise + 0.7)
        parts.append(box(low, high, plain((0.42, 0.33, 0.29))))
    return [*parts, *_openings(rng, reach, (y, height, rise))]


def _openings(rng: np.random.Generator, reach: float, slope: tuple[float, float, float]) -> list[Mesh]:
    """Return solar panels on one side, or roof windows on both, or nothing."""
    y, height, rise = slope

    def on_slope(low: float, high: float, shares: Pair, side: int, finish: Finish) -> Mesh:
        bottom, top = ((side * y * (1 - share), height + rise * share + 0.12) for share in shares)
        return _panel((low, high), bottom, top, finish)

    extra = rng.random()
    if extra < 0.22:
        side = 1 if rng.random() < 0.5 else -1
        return [on_slope(-reach * 0.75, reach * 0.75, (0.3, 0.8), side, PANELS)]
    if extra < 0.62:
        glass = plain((0.2, 0.23, 0.26), Material.GLASS)
        places = np.arange(-reach, reach, rng.uniform(3, 5)).tolist()
        return [on_slope(at - 0.4, at + 0.4, (0.35, 0.6), side, glass) for at in places for side in (-1, 1)]
    return []


def _panel(along: Pair, low: Pair, high: Pair, finish: Finish) -> Mesh:
    """Return a tilted rectangle: its extent along x, then (y, z) of its lower and upper edge."""
    corners = [(along[0], *low), (along[1], *low), (along[1], *high), (along[0], *high)]
    return shell(np.array(corners, dtype=np.float32)[np.array([(0, 1, 2), (0, 2, 3)])], finish)


def flat_roof(
    rng: np.random.Generator, size: Pair, height: float, wall: Finish, *, terrace: bool = False
) -> list[Mesh]:
    """Return a roof surface within a parapet, with machines and a stair house unless it is a terrace."""
    x, y = size[0] / 2, size[1] / 2
    if terrace:
        cover = plain(_varied(rng, DECKS[int(rng.integers(len(DECKS)))]), Material.GRAVEL)
    else:
        kind = int(rng.choice(len(COVERS), p=[share for _, _, share in COVERS]))
        cover = plain(_varied(rng, COVERS[kind][0]), COVERS[kind][1])
    edge = plain(_varied(rng, wall.colour))
    top = height + (1.0 if terrace else 0.6)
    parts = [
        box((-x, -y, height), (x, -y + 0.3, top), edge),
        box((-x, y - 0.3, height), (x, y, top), edge),
        box((-x, -y, height), (-x + 0.3, y, top), edge),
        box((x - 0.3, -y, height), (x, y, top), edge),
        box((-x + 0.3, -y + 0.3, height - 0.3), (x - 0.3, y - 0.3, height + 0.05), cover),
    ]
    if not terrace and min(x, y) > 3:
        parts += _plant(rng, (x, y), height, edge)
    return parts


def _plant(rng: np.random.Generator, half: Pair, height: float, edge: Finish) -> list[Mesh]:
    """Return a stair house, machines with ducts, and skylights or rows of panels."""
    x, y = half
    unit, dark = plain(_varied(rng, (0.66, 0.67, 0.68))), plain((0.3, 0.31, 0.32))
    at = rng.uniform(-0.6, 0.2) * x
    parts = [
        box((at, -1.4, height), (at + 3, 1.4, height + 2.5), edge),
        box((at - 0.15, -1.55, height + 2.5), (at + 3.15, 1.55, height + 2.65), dark, bottom=True),
    ]
    for _ in range(int(rng.integers(2, 6))):
        cx, cy = rng.uniform(-x + 1.5, x - 1.5), rng.uniform(-y + 1.5, y - 1.5)
        a, b, c = (float(value) for value in rng.uniform((0.4, 0.4, 0.5), (1.3, 1.0, 1.3)))
        parts.append(box((cx - a, cy - b, height), (cx + a, cy + b, height + c), unit))
    extra = rng.random()
    if extra < 0.3:
        for row in np.arange(-y + 1.2, y - 2.2, 1.8).tolist():
            parts += [
                _panel((start, end), (row, height + 0.15), (row + 1.2, height + 0.6), PANELS)
                for start, end in ((-x + 1, at - 0.6), (at + 3.6, x - 1))
                if end - start > 2
            ]
    elif extra < 0.6:
        glass = plain((0.6, 0.66, 0.7), Material.GLASS)
        parts += [
            box((cx - 0.6, y * 0.5 - 0.6, height), (cx + 0.6, y * 0.5 + 0.6, height + 0.4), glass)
            for cx in np.arange(-x + 2, x - 2, 4.0).tolist()
        ]
    return parts


def pick(rng: np.random.Generator, colours: tuple[Colour, ...]) -> Colour:
    """Draw a colour, a little changed."""
    base = np.asarray(colours[int(rng.integers(len(colours)))]) * rng.uniform(0.88, 1.08)
    red, green, blue = np.clip(base + rng.uniform(-0.02, 0.02, 3), 0, 1)
    return float(red), float(green), float(blue)


def _facade(rng: np.random.Generator, shares: tuple[float, ...]) -> Finish:
    """Draw a wall: plaster, brick, ribbon windows in concrete, glass, timber, in given shares."""
    kinds = (
        (PLASTER, Material.FACADE),
        (BRICKS, Material.BRICK_FACADE),
        (CONCRETES, Material.RIBBON),
        (GLAZING, Material.GLASS_FACADE),
        (TIMBERS, Material.TIMBER),
    )
    colours, material = kinds[int(rng.choice(len(kinds), p=shares))]
    return Finish(pick(rng, colours), "building", material)


def _balconies(rng: np.random.Generator, size: Pair, low: float, high: float) -> list[Mesh]:
    """Return columns of balconies on both long sides, on every storey."""
    x, y = size[0] / 2, size[1] / 2
    rail = plain(pick(rng, ((0.75, 0.75, 0.74), (0.35, 0.36, 0.38), (0.6, 0.62, 0.6))))
    step = rng.uniform(4.5, 7)
    parts = []
    for at in np.arange(-x + 2.6, x - 2.5, step).tolist():
        for floor in np.arange(low, high - 2.5, STOREY_M).tolist():
            for side in (-1, 1):
                near, far = sorted((side * y, side * (y + 1.2)))
                corners = (at - 1.4, near, floor - 0.15), (at + 1.4, far, floor + 1.0)
                parts.append(box(*corners, rail, bottom=True))
    return parts


def _shops(rng: np.random.Generator, size: Pair) -> list[Mesh]:
    """Return a glazed ground floor, some awnings in front of it."""
    x, y = size[0] / 2, size[1] / 2
    front = plain(pick(rng, CONCRETES), Material.SHOP)
    parts = [box((-x - 0.1, -y - 0.1, -FOUNDATION_M), (x + 0.1, y + 0.1, SHOP_M), front)]
    for at in np.arange(-x + 2.5, x - 2, 5.0).tolist():
        if rng.random() < 0.45:
            cloth = plain(pick(rng, AWNINGS))
            for side in (-1, 1):
                near, far = sorted((side * y, side * (y + 1.5)))
                parts.append(box((at - 1.7, near, 2.75), (at + 1.7, far, 2.95), cloth, bottom=True))
    return parts


def _wing(rng: np.random.Generator, size: Pair, height: float, wall: Finish) -> list[Mesh]:
    """Return walls with a cornice, standing on a foundation."""
    x, y = size[0] / 2, size[1] / 2
    parts = [box((-x, -y, -FOUNDATION_M), (x, y, height), wall)]
    if rng.random() < 0.6:
        trim = plain(pick(rng, ((0.62, 0.6, 0.56), wall.colour)))
        parts.append(box((-x - 0.3, -y - 0.3, height - 0.45), (x + 0.3, y + 0.3, height), trim, bottom=True))
    return parts


def apartment(rng: np.random.Generator, size: Pair) -> Mesh:
    """Return a block of flats of a given footprint in metres, 3 to 6 floors, of many shapes and roofs."""
    height = STOREY_M * int(rng.integers(3, 7))
    wall = _facade(rng, (0.58, 0.16, 0.16, 0.06, 0.04))
    low = 0.0
    parts = _wing(rng, size, height, wall)
    if rng.random() < 0.4:
        parts += _shops(rng, size)
        low = SHOP_M
    if rng.random() < 0.5:
        parts += _balconies(rng, size, low + STOREY_M, height)
    roof = rng.random()
    if roof < 0.5:
        return join(*parts, *pitched_roof(rng, size, height, wall, steep=0.62))
    if roof < 0.65 and min(size) > 9:
        inner = (size[0] - 4.0, size[1] - 4.0)
        top = _facade(rng, (0.5, 0.0, 0.2, 0.2, 0.1))
        x, y = inner[0] / 2, inner[1] / 2
        parts += flat_roof(rng, size, height, wall, terrace=True)
        parts.append(box((-x, -y, height), (x, y, height + STOREY_M), top))
        return join(*parts, *flat_roof(rng, inner, height + STOREY_M, top))
    return join(*parts, *flat_roof(rng, size, height, wall))


def tower(rng: np.random.Generator, size: Pair) -> Mesh:
    """Return a high-rise of 20 to 38 m on a wider base, straight or set back."""
    x, y = size[0] / 2, size[1] / 2
    height = STOREY_M * int(rng.integers(6, 12))
    wall = _facade(rng, (0.3, 0.06, 0.26, 0.38, 0.0))
    wide = (size[0] + 5, size[1] + 5)
    base = plain(pick(rng, CONCRETES), Material.SHOP)
    parts = [box((-x - 2.5, -y - 2.5, -FOUNDATION_M), (x + 2.5, y + 2.5, 5), base)]
    parts += flat_roof(rng, wide, 5, base, terrace=True)
    if rng.random() < 0.4 and height > 24:
        step = height * rng.uniform(0.6, 0.8)
        inner = (size[0] - 4.5, size[1] - 4.5)
        parts.append(box((-x, -y, 0), (x, y, step), wall))
        parts += flat_roof(rng, size, step, wall, terrace=True)
        parts.append(box((-x + 2.25, -y + 2.25, step), (x - 2.25, y - 2.25, height), wall))
        return join(*parts, *flat_roof(rng, inner, height, wall))
    parts.append(box((-x, -y, 0), (x, y, height), wall))
    if wall.material is Material.FACADE and rng.random() < 0.6:
        parts += _balconies(rng, size, 5 + STOREY_M, height)
    return join(*parts, *flat_roof(rng, size, height, wall))


def house(rng: np.random.Generator, size: Pair) -> Mesh:
    """Return a house of one or two floors: pitched or flat roof, some with a wing, a terrace, a porch."""
    x, y = size[0] / 2, size[1] / 2
    height = float(rng.choice([3.2, 5.8]))
    wall = _facade(rng, (0.66, 0.18, 0.0, 0.0, 0.16))
    porch = plain((0.56, 0.53, 0.5))
    parts = [
        box((-x, -y, -FOUNDATION_M), (x, y, height), wall),
        box((-x * 0.6, y, -FOUNDATION_M), (x * 0.5, y + 2.4, 0.15), plain((0.6, 0.57, 0.52))),
    ]
    kind = rng.random()
    if kind < 0.14:
        return join(*parts, *flat_roof(rng, size, height, wall))
    parts += pitched_roof(rng, size, height, wall, steep=rng.uniform(0.6, 0.85))
    if kind < 0.5:
        parts.append(box((x * 0.1, y, -FOUNDATION_M), (x * 0.75, y + 1.7, 2.5), wall))
        parts.append(box((x * 0.1 - 0.2, y, 2.5), (x * 0.75 + 0.2, y + 1.9, 2.65), porch, bottom=True))
    elif kind < 0.8:
        parts += _cross_wing(size, height, wall, cover=parts[2])
    return join(*parts)


def _cross_wing(size: Pair, height: float, wall: Finish, cover: Mesh) -> list[Mesh]:
    """Return a gabled wing across the house, which makes it an L, with a roof like the main roof, `cover`."""
    wide, length = size[0] * 0.42, size[1] / 2 + 2.2
    half = length / 2
    red, green, blue = cover.colours[0].tolist()
    tiles = plain((red, green, blue), Material(int(cover.materials[0])))
    wing = join(
        box((-half, -wide / 2, -FOUNDATION_M), (half, wide / 2, height), wall),
        gable((length + 0.4, wide + 0.7), height - 0.2, wide * 0.4, tiles, wall),
    )
    ones = np.ones((1, 3), dtype=np.float32)
    at = np.array([(-size[0] * 0.24, half, 0)], dtype=np.float32)
    return [place(wing, at, np.array([np.pi / 2], dtype=np.float32), ones, ones)]


def hall(rng: np.random.Generator, size: Pair) -> Mesh:
    """Return an industrial hall: low, wide, sheet metal, with skylights, sheds or solar panels."""
    x, y = size[0] / 2, size[1] / 2
    height = rng.uniform(6, 10)
    wall = plain(pick(rng, SHEETS), Material.METAL)
    roof = plain(pick(rng, (*SHEETS, (0.5, 0.49, 0.47))), Material.METAL)
    light = plain((0.56, 0.6, 0.62), Material.GLASS)
    door = plain((0.36, 0.38, 0.4))
    parts = [
        box((-x, -y, -FOUNDATION_M), (x, y, height - 0.3), wall),
        box((-x - 0.15, -y - 0.15, height - 0.3), (x + 0.15, y + 0.15, height), roof, bottom=True),
    ]
    for at in np.arange(-x + 4, x - 3, 7.0).tolist():
        parts.append(box((at - 0.8, -y * 0.8, height), (at + 0.8, y * 0.8, height + 0.45), light))
        parts.append(box((at - 1.8, y, 0), (at + 1.8, y + 0.1, 4), door))
    unit = plain((0.66, 0.67, 0.68))
    for _ in range(int(rng.integers(2, 7))):
        cx, cy = rng.uniform(-x + 2, x - 2), rng.uniform(-y + 2, y - 2)
        parts.append(box((cx - 1, cy - 0.8, height), (cx + 1, cy + 0.8, height + 1.3), unit))
    return join(*parts)
