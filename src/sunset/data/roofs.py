"""Roofs of buildings: pitched with dormers and chimneys, or flat with what stands on them."""

from typing import Final

import numpy as np

from sunset.data.meshes import Colour, Finish, Material, Mesh, box, gable, hip, shell

Size = tuple[float, float]
TILES: Final[tuple[Colour, ...]] = (
    (0.5, 0.3, 0.23),
    (0.44, 0.29, 0.24),
    (0.38, 0.3, 0.27),
    (0.54, 0.36, 0.28),
    (0.33, 0.33, 0.34),
    (0.29, 0.28, 0.29),
    (0.42, 0.38, 0.35),
)
SHEETS: Final = ((0.42, 0.44, 0.46), (0.36, 0.4, 0.38), (0.55, 0.56, 0.57))
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
    """Return what a part of a building looks like."""
    return Finish(colour, "building", material)


def _varied(rng: np.random.Generator, colour: Colour) -> Colour:
    red, green, blue = np.clip(np.asarray(colour) * rng.uniform(0.86, 1.1), 0, 1)
    return float(red), float(green), float(blue)


def pitched_roof(
    rng: np.random.Generator, size: Size, height: float, wall: Finish, *, steep: float
) -> list[Mesh]:
    """Return a gabled or hipped roof over the eaves' height: tiles or sheets, chimneys, windows, panels.

    Sizes are in metres, gables are made like the wall, `steep` is the rise over the run.
    """
    x, y = size[0] / 2, size[1] / 2
    over = (size[0] + 0.9, size[1] + 0.9)
    tiled = rng.random() < 0.85  # noqa: PLR2004  a share
    colours, material = (TILES, Material.TILES) if tiled else (SHEETS, Material.METAL)
    cover = plain(_varied(rng, colours[int(rng.integers(len(colours)))]), material)
    hipped = rng.random() < 0.35 and x > y  # noqa: PLR2004  a share
    reach = max(x - y, 1.0) if hipped else x * 0.8
    rise, drop = y * steep, 0.45 * steep
    parts = [
        hip(over, height - drop, rise + drop, cover)
        if hipped
        else gable(over, height - drop, rise + drop, cover, wall)
    ]
    for _ in range(int(rng.integers(1, 3))):
        at = rng.uniform(-reach, reach) * 0.9
        side = rng.uniform(-0.35, 0.35) * y
        low, high = (at - 0.4, side - 0.35, height), (at + 0.4, side + 0.35, height + rise + 0.7)
        parts.append(box(low, high, plain((0.42, 0.33, 0.29))))
    return [*parts, *_openings(rng, reach, (y, height, rise))]


def _openings(rng: np.random.Generator, reach: float, slope: tuple[float, float, float]) -> list[Mesh]:
    """Return solar panels on one side, or roof windows on both, or nothing."""
    y, height, rise = slope

    def on_slope(low: float, high: float, shares: Size, side: int, finish: Finish) -> Mesh:
        bottom, top = ((side * y * (1 - share), height + rise * share + 0.12) for share in shares)
        return _panel((low, high), bottom, top, finish)

    extra = rng.random()
    if extra < 0.22:  # noqa: PLR2004  a share
        side = 1 if rng.random() < 0.5 else -1  # noqa: PLR2004  a coin
        return [on_slope(-reach * 0.75, reach * 0.75, (0.3, 0.8), side, PANELS)]
    if extra < 0.62:  # noqa: PLR2004  a share
        glass = plain((0.2, 0.23, 0.26), Material.GLASS)
        places = np.arange(-reach, reach, rng.uniform(3, 5)).tolist()
        return [on_slope(at - 0.4, at + 0.4, (0.35, 0.6), side, glass) for at in places for side in (-1, 1)]
    return []


def _panel(along: Size, low: Size, high: Size, finish: Finish) -> Mesh:
    """Return a tilted rectangle: its extent along x, then (y, z) of its lower and upper edge."""
    corners = np.array(
        [(along[0], *low), (along[1], *low), (along[1], *high), (along[0], *high)], dtype=np.float32
    )
    return shell(corners[np.array([(0, 1, 2), (0, 2, 3)])], finish)


def flat_roof(
    rng: np.random.Generator, size: Size, height: float, wall: Finish, *, terrace: bool = False
) -> list[Mesh]:
    """Return a roof surface within a parapet; plant, a stair house, skylights or panels unless a terrace."""
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
    if not terrace and min(x, y) > 3:  # noqa: PLR2004  room for it
        parts += _plant(rng, (x, y), height, edge)
    return parts


def _plant(rng: np.random.Generator, half: Size, height: float, edge: Finish) -> list[Mesh]:
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
    if extra < 0.3:  # noqa: PLR2004  a share
        for row in np.arange(-y + 1.2, y - 2.2, 1.8).tolist():
            parts += [
                _panel((start, end), (row, height + 0.15), (row + 1.2, height + 0.6), PANELS)
                for start, end in ((-x + 1, at - 0.6), (at + 3.6, x - 1))
                if end - start > 2  # noqa: PLR2004  metres, room for a panel
            ]
    elif extra < 0.6:  # noqa: PLR2004  a share
        glass = plain((0.6, 0.66, 0.7), Material.GLASS)
        parts += [
            box((cx - 0.6, y * 0.5 - 0.6, height), (cx + 0.6, y * 0.5 + 0.6, height + 0.4), glass)
            for cx in np.arange(-x + 2, x - 2, 4.0).tolist()
        ]
    return parts
