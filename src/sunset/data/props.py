"""Trees and street furniture: meshes with their origin on the ground."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Final

import numpy as np

from sunset.data.meshes import WHITE, Colour, Finish, Material, Mesh, blob, box, cylinder, gable, join
from sunset.seeding import generator

TREES: Final = 8
"""How many different trees there are: 0 to 3 broad-leaved, 4 a poplar, 5 and 6 conifers (alike), 7 a bush."""

STEEL: Final[Colour] = (0.42, 0.44, 0.46)
POPLAR: Final = 4
CONIFERS: Final = (5, 6)
BUSH: Final = 7


@cache
def tree(kind: int) -> Mesh:
    """Return a tree about 1 m high, to be scaled; its crown takes the tint."""
    rng = generator(kind, "tree")
    leaves = Finish(WHITE, "vegetation", Material.FOLIAGE, tinted=True)
    if kind == BUSH:
        clumps = [(0.0, 0.0, 0.3), (0.28, 0.1, 0.22), (-0.2, 0.22, 0.24)]
        return join(*(blob(rng, at, (0.4, 0.38, 0.36), leaves, fine=False) for at in clumps))
    trunk = Finish((0.3, 0.25, 0.2), "vegetation")
    if kind in CONIFERS:
        needles = Finish((0.72, 0.82, 0.8), "vegetation", Material.NEEDLES, tinted=True)
        tiers = [
            (0.23, 0.1, 0.42),
            (0.2, 0.26, 0.58),
            (0.165, 0.42, 0.74),
            (0.12, 0.58, 0.88),
            (0.07, 0.76, 1.0),
        ]
        cones = [cylinder((radius, 0.01), (low, high), needles, sides=8) for radius, low, high in tiers]
        return join(cylinder((0.03, 0.03), (0, 0.2), trunk, sides=4), *cones)
    if kind == POPLAR:
        column = [
            blob(rng, (0, 0, z), (r, r, 0.24), leaves) for z, r in ((0.32, 0.12), (0.55, 0.13), (0.8, 0.09))
        ]
        return join(cylinder((0.035, 0.03), (0, 0.2), trunk, sides=4), *column)
    return join(cylinder((0.04, 0.025), (0, 0.5), trunk, sides=5), *_crown(rng, kind, leaves))


def _crown(rng: np.random.Generator, kind: int, leaves: Finish) -> list[Mesh]:
    """A round, broad, tall or loose crown: a core with clumps of leaves around it."""
    wide, high, middle, loose = (
        (0.3, 0.3, 0.64, 0.3),
        (0.38, 0.25, 0.66, 0.34),
        (0.25, 0.34, 0.62, 0.28),
        (0.3, 0.26, 0.66, 0.42),
    )[kind]
    parts = [blob(rng, (0, 0, middle), (wide, wide, high), leaves, roughness=0.14)]
    for index in range(5):
        angle = index * 2.4 + rng.uniform(-0.4, 0.4)
        rise = rng.uniform(-0.45, 0.75)
        out = wide * (1 - 0.4 * rise * rise) * rng.uniform(0.6, 0.95)
        size = wide * loose / 0.3 * rng.uniform(0.45, 0.66)
        at = (out * float(np.cos(angle)), out * float(np.sin(angle)), middle + rise * high)
        parts.append(blob(rng, at, (size, size, size * 0.85), leaves, roughness=0.15, fine=False))
    return parts


def _lamp() -> Mesh:
    steel = Finish(STEEL, "pole")
    return join(
        cylinder((0.2, 0.14), (0, 8.5), steel),
        box((-0.1, -0.1, 8.4), (2.4, 0.1, 8.6), steel, bottom=True),
        box((1.5, -0.3, 8.35), (2.7, 0.3, 8.62), Finish((0.55, 0.56, 0.56), "pole"), bottom=True),
    )


def _mast() -> Mesh:
    wood = Finish((0.36, 0.29, 0.23), "pole")
    return join(
        cylinder((0.22, 0.16), (0, 10), wood),
        box((-0.12, -1.5, 8.8), (0.12, 1.5, 9.05), wood, bottom=True),
        box((-0.12, -1.1, 8.0), (0.12, 1.1, 8.25), wood, bottom=True),
    )


def _traffic_light() -> Mesh:
    steel, case = Finish((0.3, 0.31, 0.33), "pole"), Finish((0.12, 0.12, 0.12), "traffic light")
    yellow = Finish((0.24, 0.24, 0.22), "traffic light")
    heads = [
        part
        for y in (3.2, 4.9)
        for part in (
            box((-0.45, y - 0.45, 5.0), (0.3, y + 0.45, 6.5), yellow, bottom=True),
            box((-0.52, y - 0.25, 5.1), (-0.45, y + 0.25, 6.4), case, bottom=True),
        )
    ]
    near = box((-0.35, -0.4, 2.5), (0.35, 0.4, 3.9), yellow, bottom=True)
    arm = box((-0.12, 0, 5.9), (0.12, 5.0, 6.15), steel, bottom=True)
    return join(cylinder((0.18, 0.15), (0, 6.2), steel), arm, near, *heads)


def _sign() -> Mesh:
    face, back = Finish(WHITE, "traffic sign", tinted=True), Finish((0.62, 0.63, 0.64), "traffic sign")
    return join(
        cylinder((0.1, 0.1), (0, 2.2), Finish(STEEL, "pole")),
        box((-0.12, -0.75, 2.1), (0.0, 0.75, 3.6), face, bottom=True),
        box((0.0, -0.75, 2.1), (0.1, 0.75, 3.6), back, bottom=True),
    )


def _gantry() -> Mesh:
    steel, face = Finish(STEEL, "pole"), Finish((0.08, 0.25, 0.55), "traffic sign")
    border = Finish((0.9, 0.9, 0.9), "traffic sign")
    return join(
        cylinder((0.22, 0.2), (0, 7.6), steel),
        box((-0.14, 0, 6.6), (0.14, 6.4, 6.9), steel, bottom=True),
        box((-0.5, 1.4, 5.3), (-0.14, 6.2, 7.8), face, bottom=True),
        box((-0.52, 1.9, 6.3), (-0.5, 5.7, 6.7), border, bottom=True),
    )


def _bus_stop() -> Mesh:
    frame, roof = Finish((0.3, 0.33, 0.36), "static"), Finish((0.16, 0.36, 0.42), "static")
    seat = Finish((0.5, 0.36, 0.2), "static")
    return join(
        box((-4.0, -1.1, 2.5), (4.0, 1.1, 2.75), roof, bottom=True),
        box((-3.9, 0.9, 0), (3.9, 1.05, 2.5), frame),
        box((-3.9, -0.8, 0), (-3.7, 1.0, 2.5), frame),
        box((-3.0, 0.2, 0), (3.0, 0.75, 0.5), seat),
    )


def _skip() -> Mesh:
    body, lid = Finish(WHITE, "dynamic", tinted=True), Finish((0.16, 0.17, 0.18), "dynamic")
    return join(box((-1.7, -1.0, 0), (1.7, 1.0, 1.4), body), box((-1.75, -1.05, 1.4), (1.75, 0.2, 1.55), lid))


def _container() -> Mesh:
    body = Finish(WHITE, "dynamic", tinted=True)
    ribs = Finish((0.75, 0.75, 0.75), "dynamic", tinted=True)
    lines = [box((x, -1.24, 2.6), (x + 0.35, 1.24, 2.68), ribs) for x in (-2.6, -1.5, -0.4, 0.7, 1.8)]
    return join(box((-3, -1.25, 0), (3, 1.25, 2.6), body), *lines)


def _planter() -> Mesh:
    rim, leaves = (
        Finish((0.45, 0.42, 0.38), "vegetation"),
        Finish((0.3, 0.42, 0.2), "vegetation", Material.FOLIAGE),
    )
    shrub = blob(generator(1, "planter"), (0, 0, 0.9), (1.2, 1.2, 0.7), leaves)
    return join(cylinder((1.5, 1.6), (0, 0.7), rim, sides=8), shrub)


def _kiosk() -> Mesh:
    wall, roof = Finish((0.75, 0.3, 0.22), "other"), Finish((0.9, 0.84, 0.7), "other")
    return join(box((-1.7, -1.4, 0), (1.7, 1.4, 2.4), wall), gable((4.4, 3.8), 2.4, 1.1, roof, wall))


def _monument() -> Mesh:
    stone = Finish((0.68, 0.64, 0.57), "other")
    return join(
        cylinder((3.2, 3.2), (0, 0.4), stone, sides=10),
        cylinder((2.2, 2.2), (0.4, 0.8), stone, sides=10),
        cylinder((0.8, 0.4), (0.8, 8.5), stone, sides=4),
    )


PROPS: Final[Mapping[str, Callable[[], Mesh]]] = {
    "lamp": _lamp,
    "mast": _mast,
    "traffic light": _traffic_light,
    "sign": _sign,
    "gantry": _gantry,
    "bus stop": _bus_stop,
    "skip": _skip,
    "container": _container,
    "planter": _planter,
    "kiosk": _kiosk,
    "monument": _monument,
    "fence": lambda: box((-0.5, -0.07, 0), (0.5, 0.07, 1), Finish(WHITE, "fence", tinted=True)),
    "wall": lambda: box((-0.5, -0.22, 0), (0.5, 0.22, 1), Finish(WHITE, "wall", Material.BRICK, tinted=True)),
    "hedge": lambda: box(
        (-0.5, -0.5, 0), (0.5, 0.5, 1), Finish((0.26, 0.34, 0.2), "vegetation", Material.NEEDLES)
    ),
    "rail guard": lambda: box(
        (-0.5, -0.15, 0), (0.5, 0.15, 1), Finish((0.74, 0.76, 0.78), "guard rail", Material.PAINT)
    ),
    "pier": lambda: box((-0.5, -0.5, 0), (0.5, 0.5, 1), Finish((0.6, 0.58, 0.55), "bridge")),
}
"""Street furniture by name. Fence to pier are unit pieces, to be stretched."""


@cache
def prop(name: str) -> Mesh:
    """Return the mesh of a piece of street furniture, one of `PROPS`."""
    return PROPS[name]()
