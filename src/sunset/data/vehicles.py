"""Vehicles and people: meshes that face along x, with their origin on the ground."""

from functools import cache
from typing import Final

from sunset.data.meshes import Colour, Finish, Material, Mesh, box, cylinder, join

__all__ = ["MOVERS", "mover"]

WHITE: Final[Colour] = (1.0, 1.0, 1.0)
GLASS: Final[Colour] = (0.13, 0.16, 0.2)
TYRE: Final[Colour] = (0.1, 0.1, 0.11)


def _paint(label: str) -> Finish:
    return Finish(WHITE, label, Material.PAINT, tinted=True)


def _wheels(label: str, ends: tuple[float, ...], half: float, radius: float) -> list[Mesh]:
    finish = Finish(TYRE, label)
    return [
        box((x - radius, y - 0.14, 0), (x + radius, y + 0.14, radius * 2), finish)
        for x in ends
        for y in (-half, half)
    ]


def _saloon() -> Mesh:
    paint, glass = _paint("car"), Finish(GLASS, "car", Material.PAINT)
    return join(
        [
            box((-2.25, -0.92, 0.32), (2.25, 0.92, 0.92), paint, bottom=True),
            box((-1.55, -0.8, 0.92), (0.95, 0.8, 1.36), glass),
            box((-1.25, -0.76, 1.36), (0.5, 0.76, 1.46), paint),
            *_wheels("car", (-1.4, 1.4), 0.86, 0.33),
        ]
    )


def _hatchback() -> Mesh:
    paint, glass = _paint("car"), Finish(GLASS, "car", Material.PAINT)
    return join(
        [
            box((-1.95, -0.88, 0.3), (1.95, 0.88, 0.95), paint, bottom=True),
            box((-1.9, -0.78, 0.95), (0.75, 0.78, 1.42), glass),
            box((-1.8, -0.76, 1.42), (0.35, 0.76, 1.52), paint),
            *_wheels("car", (-1.25, 1.25), 0.82, 0.31),
        ]
    )


def _van() -> Mesh:
    paint, glass = _paint("car"), Finish(GLASS, "car", Material.PAINT)
    return join(
        [
            box((-2.6, -0.98, 0.35), (1.7, 0.98, 2.1), paint, bottom=True),
            box((1.7, -0.95, 0.35), (2.6, 0.95, 1.15), paint, bottom=True),
            box((1.7, -0.9, 1.15), (2.15, 0.9, 1.95), glass),
            *_wheels("car", (-1.6, 1.7), 0.92, 0.36),
        ]
    )


def _truck() -> Mesh:
    paint, cargo = _paint("truck"), Finish((0.88, 0.87, 0.84), "truck")
    glass, frame = Finish(GLASS, "truck", Material.PAINT), Finish((0.2, 0.2, 0.22), "truck")
    return join(
        [
            box((-4.6, -1.25, 1.1), (2.0, 1.25, 3.5), cargo, bottom=True),
            box((-4.5, -1.0, 0.6), (4.2, 1.0, 1.1), frame, bottom=True),
            box((2.3, -1.22, 0.7), (4.4, 1.22, 2.0), paint),
            box((2.3, -1.18, 2.0), (4.2, 1.18, 2.5), glass),
            box((2.3, -1.22, 2.5), (4.0, 1.22, 3.0), paint),
            *_wheels("truck", (-3.6, -2.4, 3.4), 1.1, 0.5),
        ]
    )


def _bus() -> Mesh:
    paint, glass = _paint("bus"), Finish(GLASS, "bus", Material.PAINT)
    unit = Finish((0.75, 0.76, 0.78), "bus")
    return join(
        [
            box((-6, -1.27, 0.4), (6, 1.27, 1.35), paint, bottom=True),
            box((-5.9, -1.24, 1.35), (5.95, 1.24, 2.45), glass),
            box((-6, -1.27, 2.45), (6, 1.27, 3.0), paint),
            box((-3.5, -0.8, 3.0), (-0.5, 0.8, 3.25), unit),
            box((2, -0.6, 3.0), (3.2, 0.6, 3.2), unit),
            *_wheels("bus", (-3.6, 3.9), 1.15, 0.5),
        ]
    )


def _figure(label: str, x: float, base: float) -> list[Mesh]:
    """A seated person's trunk, arms and head."""
    cloth, skin = Finish(WHITE, label, tinted=True), Finish((0.62, 0.45, 0.35), label)
    return [
        box((x - 0.22, -0.3, base), (x + 0.16, 0.3, base + 0.68), cloth),
        box((x, -0.36, base + 0.25), (x + 0.5, 0.36, base + 0.42), cloth),
        box((x - 0.12, -0.14, base + 0.68), (x + 0.16, 0.14, base + 0.98), skin),
    ]


def _motorcycle() -> Mesh:
    paint, dark = _paint("motorcycle"), Finish((0.16, 0.16, 0.17), "motorcycle", Material.PAINT)
    return join(
        [
            box((-1.05, -0.14, 0), (-0.4, 0.14, 0.66), dark),
            box((0.45, -0.14, 0), (1.1, 0.14, 0.66), dark),
            box((-0.9, -0.3, 0.45), (0.75, 0.3, 0.85), paint, bottom=True),
            box((0.5, -0.5, 0.95), (0.72, 0.5, 1.08), dark),
            *_figure("rider", -0.3, 0.8),
        ]
    )


def _bicycle() -> Mesh:
    frame, dark = Finish(WHITE, "bicycle", tinted=True), Finish((0.18, 0.18, 0.19), "bicycle")
    return join(
        [
            box((-1.0, -0.09, 0), (-0.35, 0.09, 0.68), dark),
            box((0.4, -0.09, 0), (1.05, 0.09, 0.68), dark),
            box((-0.7, -0.12, 0.5), (0.75, 0.12, 0.75), frame),
            box((0.6, -0.42, 0.95), (0.78, 0.42, 1.06), frame),
            *_figure("rider", -0.25, 0.85),
        ]
    )


def _person() -> Mesh:
    cloth, trousers = Finish(WHITE, "person", tinted=True), Finish((0.2, 0.22, 0.3), "person")
    skin = Finish((0.6, 0.43, 0.33), "person")
    return join(
        [
            box((-0.28, -0.2, 0), (0.0, -0.02, 0.85), trousers),
            box((0.02, 0.02, 0), (0.3, 0.2, 0.85), trousers),
            box((-0.2, -0.34, 0.85), (0.2, 0.34, 1.48), cloth),
            cylinder((0.14, 0.13), (1.48, 1.8), skin),
        ]
    )


def _carriage() -> Mesh:
    paint, glass = _paint("train"), Finish(GLASS, "train", Material.PAINT)
    roof = Finish((0.62, 0.64, 0.66), "train")
    return join(
        [
            box((-11, -1.4, 0.5), (11, 1.4, 1.9), paint, bottom=True),
            box((-10.9, -1.38, 1.9), (10.9, 1.38, 2.8), glass),
            box((-11, -1.4, 2.8), (11, 1.4, 3.5), roof),
            box((-6, -0.7, 3.5), (-2, 0.7, 3.8), roof),
            box((3, -0.7, 3.5), (6, 0.7, 3.8), roof),
        ]
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
