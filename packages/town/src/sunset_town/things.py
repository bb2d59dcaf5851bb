"""Vehicles, people, trees and street furniture: meshes with their origin on the ground; what moves faces along x."""

from typing import Final

import numpy as np

from sunset_town.meshes import WHITE, Finish, Material, Mesh, blob, box, cylinder, gable, join, taper
from sunset_town.seeding import generator

STEEL: Final = Finish((0.42, 0.44, 0.46), "pole")
DARK_STEEL: Final = Finish((0.3, 0.31, 0.33), "pole")
WOOD: Final = Finish((0.36, 0.29, 0.23), "pole")
STONE: Final = Finish((0.68, 0.64, 0.57), "other")
KIOSK: Final = Finish((0.75, 0.3, 0.22), "other")
RIBS: Final = Finish((0.75, 0.75, 0.75), "dynamic", tinted=True)
BLACK: Final = Finish((0.16, 0.16, 0.17), "motorcycle", Material.PAINT)
RUBBER: Final = Finish((0.18, 0.18, 0.19), "bicycle")
TROUSERS: Final = Finish((0.22, 0.24, 0.3), "person")
HAIR: Final = Finish((0.24, 0.19, 0.16), "person")
TRUCK_BODY: Final = Finish((0.82, 0.82, 0.8), "truck", Material.METAL)
BUS_ROOF: Final = Finish((0.86, 0.86, 0.84), "bus", Material.PAINT)
SHRUB: Final = Finish((0.3, 0.42, 0.2), "vegetation", Material.FOLIAGE)
RAIL: Final = Finish((0.74, 0.76, 0.78), "guard rail", Material.PAINT)


def _paint(label: str) -> Finish:
    return Finish(WHITE, label, Material.PAINT, tinted=True)


def _glass(label: str) -> Finish:
    return Finish((0.15, 0.17, 0.19), label, Material.GLASS)


def _tinted(label: str) -> Finish:
    return Finish(WHITE, label, tinted=True)


def _wheels(label: str, ends: tuple[float, ...], half: float, radius: float) -> list[Mesh]:
    """Return a dark block for each axle: between the wheels it is hidden under the body."""
    finish = Finish((0.1, 0.1, 0.11), label)
    return [
        taper((x - radius, -half - 0.12, 0), (x + radius, half + 0.12, radius * 2), (0.12, 0.12, 0), finish)
        for x in ends
    ]


def _rider(x: float, base: float) -> list[Mesh]:
    """Return a seated person's trunk, arms, legs and head."""
    cloth, trousers = _tinted("rider"), Finish((0.24, 0.26, 0.32), "rider")
    head = Finish((0.3, 0.26, 0.24), "rider")
    return [
        taper((x - 0.2, -0.26, base), (x + 0.14, 0.26, base + 0.62), (-0.12, -0.02, -0.02), cloth),
        box((x, -0.3, base + 0.3), (x + 0.52, 0.3, base + 0.42), cloth),
        taper((x - 0.05, -0.24, base - 0.45), (x + 0.4, 0.24, base + 0.08), (-0.02, 0.1, 0), trousers),
        taper((x - 0.06, -0.12, base + 0.62), (x + 0.2, 0.12, base + 0.9), (0.05, 0.05, 0.03), head),
    ]


def _lights(y: float) -> list[Mesh]:
    """Return a traffic light's head above a lane."""
    case, front = Finish((0.24, 0.24, 0.22), "traffic light"), Finish((0.12, 0.12, 0.12), "traffic light")
    return [
        box((-0.45, y - 0.45, 5.0), (0.3, y + 0.45, 6.5), case, bottom=True),
        box((-0.52, y - 0.25, 5.1), (-0.45, y + 0.25, 6.4), front, bottom=True),
    ]


MOVERS: Final = {
    "saloon": join(
        box((-2.25, -0.9, 0.32), (2.25, 0.9, 0.66), _paint("car"), bottom=True),
        taper((-2.25, -0.9, 0.66), (2.25, 0.9, 0.95), (0.18, 0.3, 0.08), _paint("car")),
        taper((-1.75, -0.8, 0.93), (0.95, 0.8, 1.38), (0.6, 0.75, 0.16), _glass("car")),
        taper((-1.12, -0.66, 1.36), (0.22, 0.66, 1.45), (0.12, 0.12, 0.08), _paint("car")),
        *_wheels("car", (-1.4, 1.4), 0.82, 0.33),
    ),
    "hatchback": join(
        box((-1.95, -0.87, 0.3), (1.95, 0.87, 0.68), _paint("car"), bottom=True),
        taper((-1.95, -0.87, 0.68), (1.95, 0.87, 1.0), (0.1, 0.28, 0.06), _paint("car")),
        taper((-1.82, -0.8, 0.98), (0.85, 0.8, 1.45), (0.28, 0.65, 0.14), _glass("car")),
        taper((-1.58, -0.68, 1.43), (0.24, 0.68, 1.54), (0.12, 0.14, 0.08), _paint("car")),
        *_wheels("car", (-1.25, 1.25), 0.79, 0.31),
    ),
    "van": join(
        box((-2.6, -0.98, 0.35), (1.55, 0.98, 1.8), _paint("car"), bottom=True),
        taper((-2.6, -0.98, 1.8), (1.55, 0.98, 2.15), (0.08, 0.12, 0.12), _paint("car")),
        taper((1.5, -0.96, 0.35), (2.6, 0.96, 1.2), (0, 0.15, 0.04), _paint("car"), bottom=True),
        taper((1.5, -0.9, 1.18), (2.4, 0.9, 2.0), (0, 0.75, 0.1), _glass("car")),
        *_wheels("car", (-1.6, 1.7), 0.88, 0.36),
    ),
    "truck": join(
        box((-4.6, -1.25, 1.1), (2.0, 1.25, 3.5), TRUCK_BODY, bottom=True),
        box((-4.5, -1.0, 0.6), (4.2, 1.0, 1.1), Finish((0.2, 0.2, 0.22), "truck"), bottom=True),
        box((2.3, -1.22, 0.7), (4.4, 1.22, 1.9), _paint("truck")),
        taper((2.3, -1.2, 1.9), (4.4, 1.2, 2.6), (0, 0.25, 0.06), _glass("truck")),
        taper((2.3, -1.18, 2.58), (4.2, 1.18, 3.1), (0, 0.7, 0.12), _paint("truck")),
        *_wheels("truck", (-3.6, -2.4, 3.4), 1.1, 0.5),
    ),
    "bus": join(
        box((-6, -1.27, 0.4), (6, 1.27, 1.35), _paint("bus"), bottom=True),
        taper((-5.97, -1.26, 1.35), (5.97, 1.26, 2.5), (0.06, 0.14, 0.05), _glass("bus")),
        box((-5.95, -1.24, 2.5), (5.87, 1.24, 2.78), _paint("bus")),
        taper((-5.95, -1.24, 2.78), (5.87, 1.24, 3.0), (0.15, 0.2, 0.22), BUS_ROOF),
        taper((-3.5, -0.8, 3.0), (-0.5, 0.8, 3.25), (0.1, 0.1, 0.1), Finish((0.62, 0.63, 0.65), "bus")),
        box((2, -0.5, 3.0), (3.2, 0.5, 3.15), Finish((0.62, 0.63, 0.65), "bus")),
        *_wheels("bus", (-3.6, 3.9), 1.13, 0.5),
    ),
    "motorcycle": join(
        taper((-1.05, -0.12, 0), (-0.4, 0.12, 0.64), (0.16, 0.16, 0), BLACK),
        taper((0.45, -0.1, 0), (1.1, 0.1, 0.64), (0.16, 0.16, 0), BLACK),
        taper((-0.95, -0.24, 0.42), (0.7, 0.24, 0.86), (0.1, 0.3, 0.08), _paint("motorcycle"), bottom=True),
        box((0.5, -0.42, 0.98), (0.66, 0.42, 1.06), BLACK),
        *_rider(-0.25, 0.84),
    ),
    "bicycle": join(
        taper((-0.95, -0.06, 0), (-0.3, 0.06, 0.68), (0.16, 0.16, 0), RUBBER),
        taper((0.4, -0.06, 0), (1.05, 0.06, 0.68), (0.16, 0.16, 0), RUBBER),
        box((-0.65, -0.08, 0.5), (0.7, 0.08, 0.72), _tinted("bicycle")),
        box((0.55, -0.34, 0.98), (0.68, 0.34, 1.05), RUBBER),
        *_rider(-0.2, 0.9),
    ),
    "person": join(
        taper((-0.32, -0.19, 0), (-0.06, -0.02, 0.85), (0.2, -0.16, 0), TROUSERS),
        taper((0.1, 0.02, 0), (0.36, 0.19, 0.85), (-0.16, 0.2, 0), TROUSERS),
        taper((-0.14, -0.24, 0.83), (0.14, 0.24, 1.46), (-0.02, -0.02, -0.06), _tinted("person")),
        box((-0.09, -0.1, 1.46), (0.13, 0.1, 1.64), Finish((0.6, 0.45, 0.36), "person")),
        taper((-0.13, -0.11, 1.6), (0.11, 0.11, 1.78), (0.03, 0.03, 0.03), HAIR),
    ),
    "carriage": join(
        box((-11, -1.35, 0.15), (11, 1.35, 0.6), Finish((0.2, 0.2, 0.21), "train"), bottom=True),
        box((-11, -1.4, 0.6), (11, 1.4, 1.9), _paint("train"), bottom=True),
        box((-10.9, -1.39, 1.9), (10.9, 1.39, 2.75), _glass("train")),
        box((-11, -1.4, 2.75), (11, 1.4, 3.05), _paint("train")),
        taper((-11, -1.4, 3.05), (11, 1.4, 3.5), (0.2, 0.2, 0.55), Finish((0.5, 0.51, 0.53), "train")),
        taper((-6, -0.7, 3.5), (-2, 0.7, 3.75), (0.1, 0.1, 0.1), Finish((0.4, 0.41, 0.43), "train")),
        taper((3, -0.7, 3.5), (6, 0.7, 3.75), (0.1, 0.1, 0.1), Finish((0.4, 0.41, 0.43), "train")),
    ),
}
"""Meshes of everything that moves, by name; the order is part of the town."""

PROPS: Final = {
    "lamp": join(
        cylinder((0.2, 0.14), (0, 8.5), STEEL),
        box((-0.1, -0.1, 8.4), (2.4, 0.1, 8.6), STEEL, bottom=True),
        box((1.5, -0.3, 8.35), (2.7, 0.3, 8.62), Finish((0.55, 0.56, 0.56), "pole"), bottom=True),
    ),
    "mast": join(
        cylinder((0.22, 0.16), (0, 10), WOOD),
        box((-0.12, -1.5, 8.8), (0.12, 1.5, 9.05), WOOD, bottom=True),
        box((-0.12, -1.1, 8.0), (0.12, 1.1, 8.25), WOOD, bottom=True),
    ),
    "traffic light": join(
        cylinder((0.18, 0.15), (0, 6.2), DARK_STEEL),
        box((-0.12, 0, 5.9), (0.12, 5.0, 6.15), DARK_STEEL, bottom=True),
        box((-0.35, -0.4, 2.5), (0.35, 0.4, 3.9), Finish((0.24, 0.24, 0.22), "traffic light"), bottom=True),
        *(mesh for y in (3.2, 4.9) for mesh in _lights(y)),
    ),
    "sign": join(
        cylinder((0.1, 0.1), (0, 2.2), STEEL),
        box((-0.12, -0.75, 2.1), (0.0, 0.75, 3.6), _tinted("traffic sign"), bottom=True),
        box((0.0, -0.75, 2.1), (0.1, 0.75, 3.6), Finish((0.62, 0.63, 0.64), "traffic sign"), bottom=True),
    ),
    "gantry": join(
        cylinder((0.22, 0.2), (0, 7.6), STEEL),
        box((-0.14, 0, 6.6), (0.14, 6.4, 6.9), STEEL, bottom=True),
        box((-0.5, 1.4, 5.3), (-0.14, 6.2, 7.8), Finish((0.08, 0.25, 0.55), "traffic sign"), bottom=True),
        box((-0.52, 1.9, 6.3), (-0.5, 5.7, 6.7), Finish((0.9, 0.9, 0.9), "traffic sign"), bottom=True),
    ),
    "bus stop": join(
        box((-4.0, -1.1, 2.5), (4.0, 1.1, 2.75), Finish((0.16, 0.36, 0.42), "static"), bottom=True),
        box((-3.9, 0.9, 0), (3.9, 1.05, 2.5), Finish((0.3, 0.33, 0.36), "static")),
        box((-3.9, -0.8, 0), (-3.7, 1.0, 2.5), Finish((0.3, 0.33, 0.36), "static")),
        box((-3.0, 0.2, 0), (3.0, 0.75, 0.5), Finish((0.5, 0.36, 0.2), "static")),
    ),
    "skip": join(
        box((-1.7, -1.0, 0), (1.7, 1.0, 1.4), _tinted("dynamic")),
        box((-1.75, -1.05, 1.4), (1.75, 0.2, 1.55), Finish((0.16, 0.17, 0.18), "dynamic")),
    ),
    "container": join(
        box((-3, -1.25, 0), (3, 1.25, 2.6), _tinted("dynamic")),
        *(box((x, -1.24, 2.6), (x + 0.35, 1.24, 2.68), RIBS) for x in (-2.6, -1.5, -0.4, 0.7, 1.8)),
    ),
    "planter": join(
        cylinder((1.5, 1.6), (0, 0.7), Finish((0.45, 0.42, 0.38), "vegetation"), sides=8),
        blob(generator(1, "planter"), (0, 0, 0.9), (1.2, 1.2, 0.7), SHRUB),
    ),
    "kiosk": join(
        box((-1.7, -1.4, 0), (1.7, 1.4, 2.4), KIOSK),
        gable((4.4, 3.8), 2.4, 1.1, Finish((0.9, 0.84, 0.7), "other"), KIOSK),
    ),
    "monument": join(
        cylinder((3.2, 3.2), (0, 0.4), STONE, sides=10),
        cylinder((2.2, 2.2), (0.4, 0.8), STONE, sides=10),
        cylinder((0.8, 0.4), (0.8, 8.5), STONE, sides=4),
    ),
    "fence": box((-0.5, -0.07, 0), (0.5, 0.07, 1), _tinted("fence")),
    "wall": box((-0.5, -0.22, 0), (0.5, 0.22, 1), Finish(WHITE, "wall", Material.BRICK, tinted=True)),
    "hedge": box((-0.5, -0.5, 0), (0.5, 0.5, 1), Finish((0.26, 0.34, 0.2), "vegetation", Material.NEEDLES)),
    "rail guard": box((-0.5, -0.15, 0), (0.5, 0.15, 1), RAIL),
    "pier": box((-0.5, -0.5, 0), (0.5, 0.5, 1), Finish((0.6, 0.58, 0.55), "bridge")),
}
"""Meshes of street furniture, by name. Fence to pier are unit pieces, to be stretched."""

TREES: Final = 8
"""The number of different trees: 0 to 3 broad-leaved, 4 a poplar, 5 and 6 conifers (alike), 7 a bush."""
POPLAR: Final = 4
LEAFY_TREES: Final = 5
"""The number of broad-leaved kinds and the poplar, which come first."""
CONIFERS: Final = (5, 6)
BUSH: Final = 7


def _tree(kind: int) -> Mesh:
    """Return a tree about 1 m high, to be scaled; its crown takes the tint."""
    rng = generator(kind, "tree")
    leaves = Finish(WHITE, "vegetation", Material.FOLIAGE, tinted=True)
    if kind == BUSH:
        clumps = [(0.0, 0.0, 0.3), (0.28, 0.1, 0.22), (-0.2, 0.22, 0.24)]
        return join(*(blob(rng, at, (0.4, 0.38, 0.36), leaves, fine=False) for at in clumps))
    trunk = Finish((0.3, 0.25, 0.2), "vegetation")
    if kind in CONIFERS:
        needles = Finish((0.72, 0.82, 0.8), "vegetation", Material.NEEDLES, tinted=True)
        radii, lows = (0.23, 0.2, 0.165, 0.12, 0.07), (0.1, 0.26, 0.42, 0.58, 0.76)
        tiers = zip(radii, lows, (0.42, 0.58, 0.74, 0.88, 1.0), strict=True)
        cones = [cylinder((radius, 0.01), (low, high), needles, sides=8) for radius, low, high in tiers]
        return join(cylinder((0.03, 0.03), (0, 0.2), trunk, sides=4), *cones)
    if kind == POPLAR:
        parts = (0.32, 0.12), (0.55, 0.13), (0.8, 0.09)
        column = [blob(rng, (0, 0, z), (r, r, 0.24), leaves) for z, r in parts]
        return join(cylinder((0.035, 0.03), (0, 0.2), trunk, sides=4), *column)
    return join(cylinder((0.04, 0.025), (0, 0.5), trunk, sides=5), *_crown(rng, kind, leaves))


def _crown(rng: np.random.Generator, kind: int, leaves: Finish) -> list[Mesh]:
    """Return a round, broad, tall or loose crown: a core with clumps of leaves around it."""
    wide, high = ((0.3, 0.3), (0.38, 0.25), (0.25, 0.34), (0.3, 0.26))[kind]
    middle, loose = ((0.64, 0.3), (0.66, 0.34), (0.62, 0.28), (0.66, 0.42))[kind]
    parts = [blob(rng, (0, 0, middle), (wide, wide, high), leaves, roughness=0.14)]
    for index in range(5):
        angle = index * 2.4 + rng.uniform(-0.4, 0.4)
        rise = rng.uniform(-0.45, 0.75)
        out = wide * (1 - 0.4 * rise * rise) * rng.uniform(0.6, 0.95)
        size = wide * loose / 0.3 * rng.uniform(0.45, 0.66)
        at = (out * float(np.cos(angle)), out * float(np.sin(angle)), middle + rise * high)
        parts.append(blob(rng, at, (size, size, size * 0.85), leaves, roughness=0.15, fine=False))
    return parts


THINGS: Final = MOVERS | PROPS | {f"tree {kind}": _tree(kind) for kind in range(TREES)}
"""All meshes by name."""
