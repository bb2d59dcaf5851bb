"""Vehicles and people: meshes that face along x, with their origin on the ground."""

from functools import cache
from typing import Final

from sunset.data.meshes import WHITE, Colour, Finish, Material, Mesh, box, join, taper

GLASS: Final[Colour] = (0.15, 0.17, 0.19)


def _paint(label: str) -> Finish:
    return Finish(WHITE, label, Material.PAINT, tinted=True)


def _wheels(label: str, ends: tuple[float, ...], half: float, radius: float) -> list[Mesh]:
    """One dark block for each axle: between the wheels it is hidden under the body."""
    finish = Finish((0.1, 0.1, 0.11), label)
    return [
        taper((x - radius, -half - 0.12, 0), (x + radius, half + 0.12, radius * 2), (0.12, 0.12, 0), finish)
        for x in ends
    ]


def _saloon() -> Mesh:
    paint, glass = _paint("car"), Finish(GLASS, "car", Material.GLASS)
    return join(
        box((-2.25, -0.9, 0.32), (2.25, 0.9, 0.66), paint, bottom=True),
        taper((-2.25, -0.9, 0.66), (2.25, 0.9, 0.95), (0.18, 0.3, 0.08), paint),
        taper((-1.75, -0.8, 0.93), (0.95, 0.8, 1.38), (0.6, 0.75, 0.16), glass),
        taper((-1.12, -0.66, 1.36), (0.22, 0.66, 1.45), (0.12, 0.12, 0.08), paint),
        *_wheels("car", (-1.4, 1.4), 0.82, 0.33),
    )


def _hatchback() -> Mesh:
    paint, glass = _paint("car"), Finish(GLASS, "car", Material.GLASS)
    return join(
        box((-1.95, -0.87, 0.3), (1.95, 0.87, 0.68), paint, bottom=True),
        taper((-1.95, -0.87, 0.68), (1.95, 0.87, 1.0), (0.1, 0.28, 0.06), paint),
        taper((-1.82, -0.8, 0.98), (0.85, 0.8, 1.45), (0.28, 0.65, 0.14), glass),
        taper((-1.58, -0.68, 1.43), (0.24, 0.68, 1.54), (0.12, 0.14, 0.08), paint),
        *_wheels("car", (-1.25, 1.25), 0.79, 0.31),
    )


def _van() -> Mesh:
    paint, glass = _paint("car"), Finish(GLASS, "car", Material.GLASS)
    return join(
        box((-2.6, -0.98, 0.35), (1.55, 0.98, 1.8), paint, bottom=True),
        taper((-2.6, -0.98, 1.8), (1.55, 0.98, 2.15), (0.08, 0.12, 0.12), paint),
        taper((1.5, -0.96, 0.35), (2.6, 0.96, 1.2), (0, 0.15, 0.04), paint, bottom=True),
        taper((1.5, -0.9, 1.18), (2.4, 0.9, 2.0), (0, 0.75, 0.1), glass),
        *_wheels("car", (-1.6, 1.7), 0.88, 0.36),
    )


def _truck() -> Mesh:
    paint, cargo = _paint("truck"), Finish((0.82, 0.82, 0.8), "truck", Material.METAL)
    glass, frame = Finish(GLASS, "truck", Material.GLASS), Finish((0.2, 0.2, 0.22), "truck")
    return join(
        box((-4.6, -1.25, 1.1), (2.0, 1.25, 3.5), cargo, bottom=True),
        box((-4.5, -1.0, 0.6), (4.2, 1.0, 1.1), frame, bottom=True),
        box((2.3, -1.22, 0.7), (4.4, 1.22, 1.9), paint),
        taper((2.3, -1.2, 1.9), (4.4, 1.2, 2.6), (0, 0.25, 0.06), glass),
        taper((2.3, -1.18, 2.58), (4.2, 1.18, 3.1), (0, 0.7, 0.12), paint),
        *_wheels("truck", (-3.6, -2.4, 3.4), 1.1, 0.5),
    )


def _bus() -> Mesh:
    paint, glass = _paint("bus"), Finish(GLASS, "bus", Material.GLASS)
    unit, roof = Finish((0.62, 0.63, 0.65), "bus"), Finish((0.86, 0.86, 0.84), "bus", Material.PAINT)
    return join(
        box((-6, -1.27, 0.4), (6, 1.27, 1.35), paint, bottom=True),
        taper((-5.97, -1.26, 1.35), (5.97, 1.26, 2.5), (0.06, 0.14, 0.05), glass),
        box((-5.95, -1.24, 2.5), (5.87, 1.24, 2.78), paint),
        taper((-5.95, -1.24, 2.78), (5.87, 1.24, 3.0), (0.15, 0.2, 0.22), roof),
        taper((-3.5, -0.8, 3.0), (-0.5, 0.8, 3.25), (0.1, 0.1, 0.1), unit),
        box((2, -0.5, 3.0), (3.2, 0.5, 3.15), unit),
        *_wheels("bus", (-3.6, 3.9), 1.13, 0.5),
    )


def _figure(label: str, x: float, base: float) -> list[Mesh]:
    """A seated person's trunk, arms, legs and head."""
    cloth, trousers = Finish(WHITE, label, tinted=True), Finish((0.24, 0.26, 0.32), label)
    head = Finish((0.3, 0.26, 0.24), label)
    return [
        taper((x - 0.2, -0.26, base), (x + 0.14, 0.26, base + 0.62), (-0.12, -0.02, -0.02), cloth),
        box((x, -0.3, base + 0.3), (x + 0.52, 0.3, base + 0.42), cloth),
        taper((x - 0.05, -0.24, base - 0.45), (x + 0.4, 0.24, base + 0.08), (-0.02, 0.1, 0), trousers),
        taper((x - 0.06, -0.12, base + 0.62), (x + 0.2, 0.12, base + 0.9), (0.05, 0.05, 0.03), head),
    ]


def _motorcycle() -> Mesh:
    paint, dark = _paint("motorcycle"), Finish((0.16, 0.16, 0.17), "motorcycle", Material.PAINT)
    return join(
        taper((-1.05, -0.12, 0), (-0.4, 0.12, 0.64), (0.16, 0.16, 0), dark),
        taper((0.45, -0.1, 0), (1.1, 0.1, 0.64), (0.16, 0.16, 0), dark),
        taper((-0.95, -0.24, 0.42), (0.7, 0.24, 0.86), (0.1, 0.3, 0.08), paint, bottom=True),
        box((0.5, -0.42, 0.98), (0.66, 0.42, 1.06), dark),
        *_figure("rider", -0.25, 0.84),
    )


def _bicycle() -> Mesh:
    frame, dark = Finish(WHITE, "bicycle", tinted=True), Finish((0.18, 0.18, 0.19), "bicycle")
    return join(
        taper((-0.95, -0.06, 0), (-0.3, 0.06, 0.68), (0.16, 0.16, 0), dark),
        taper((0.4, -0.06, 0), (1.05, 0.06, 0.68), (0.16, 0.16, 0), dark),
        box((-0.65, -0.08, 0.5), (0.7, 0.08, 0.72), frame),
        box((0.55, -0.34, 0.98), (0.68, 0.34, 1.05), dark),
        *_figure("rider", -0.2, 0.9),
    )


def _person() -> Mesh:
    cloth, trousers = Finish(WHITE, "person", tinted=True), Finish((0.22, 0.24, 0.3), "person")
    skin, hair = Finish((0.6, 0.45, 0.36), "person"), Finish((0.24, 0.19, 0.16), "person")
    return join(
        taper((-0.32, -0.19, 0), (-0.06, -0.02, 0.85), (0.2, -0.16, 0), trousers),
        taper((0.1, 0.02, 0), (0.36, 0.19, 0.85), (-0.16, 0.2, 0), trousers),
        taper((-0.14, -0.24, 0.83), (0.14, 0.24, 1.46), (-0.02, -0.02, -0.06), cloth),
        box((-0.09, -0.1, 1.46), (0.13, 0.1, 1.64), skin),
        taper((-0.13, -0.11, 1.6), (0.11, 0.11, 1.78), (0.03, 0.03, 0.03), hair),
    )


def _carriage() -> Mesh:
    paint, glass = _paint("train"), Finish(GLASS, "train", Material.GLASS)
    roof, unit = Finish((0.5, 0.51, 0.53), "train"), Finish((0.4, 0.41, 0.43), "train")
    return join(
        box((-11, -1.35, 0.15), (11, 1.35, 0.6), Finish((0.2, 0.2, 0.21), "train"), bottom=True),
        box((-11, -1.4, 0.6), (11, 1.4, 1.9), paint, bottom=True),
        box((-10.9, -1.39, 1.9), (10.9, 1.39, 2.75), glass),
        box((-11, -1.4, 2.75), (11, 1.4, 3.05), paint),
        taper((-11, -1.4, 3.05), (11, 1.4, 3.5), (0.2, 0.2, 0.55), roof),
        taper((-6, -0.7, 3.5), (-2, 0.7, 3.75), (0.1, 0.1, 0.1), unit),
        taper((3, -0.7, 3.5), (6, 0.7, 3.75), (0.1, 0.1, 0.1), unit),
    )


MOVERS: Final = {
    "saloon": _saloon,
    "hatchback": _hatchback,
    "van": _van,
    "truck": _truck,
    "bus": _bus,
    "motorcycle": _motorcycle,
    "bicycle": _bicycle,
    "person": _person,
    "carriage": _carriage,
}
"""What moves, by name; the order is part of the town."""


@cache
def mover(name: str) -> Mesh:
    """Return the mesh of something that moves, one of `MOVERS`."""
    return MOVERS[name]()
