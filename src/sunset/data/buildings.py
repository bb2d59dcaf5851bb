"""Buildings: meshes made to measure, with their origin at the middle of the ground floor."""

from typing import Final

import numpy as np

from sunset.data.meshes import Colour, Finish, Material, Mesh, box, gable, join

__all__ = ["apartment", "hall", "house", "tower"]

WALLS: Final[tuple[Colour, ...]] = (
    (0.78, 0.7, 0.58),
    (0.7, 0.62, 0.55),
    (0.62, 0.36, 0.28),
    (0.83, 0.8, 0.74),
    (0.74, 0.55, 0.4),
    (0.6, 0.62, 0.6),
    (0.8, 0.66, 0.6),
    (0.72, 0.74, 0.66),
)
TILES: Final[tuple[Colour, ...]] = (
    (0.52, 0.24, 0.17),
    (0.43, 0.22, 0.18),
    (0.34, 0.25, 0.22),
    (0.58, 0.33, 0.22),
    (0.28, 0.27, 0.29),
)
FLATS: Final[tuple[Colour, ...]] = (
    (0.48, 0.47, 0.46),
    (0.58, 0.56, 0.52),
    (0.4, 0.38, 0.38),
    (0.66, 0.64, 0.6),
)
GLAZING: Final[tuple[Colour, ...]] = (
    (0.3, 0.42, 0.52),
    (0.34, 0.4, 0.42),
    (0.42, 0.36, 0.32),
    (0.28, 0.34, 0.42),
)


def _pick(rng: np.random.Generator, colours: tuple[Colour, ...]) -> Colour:
    base = np.asarray(colours[int(rng.integers(len(colours)))]) * rng.uniform(0.88, 1.1)
    red, green, blue = np.clip(base + rng.uniform(-0.025, 0.025, 3), 0, 1)
    return float(red), float(green), float(blue)


def _flat_roof(
    rng: np.random.Generator, size: tuple[float, float], height: float, wall: Finish
) -> list[Mesh]:
    """A roof surface within a parapet, with machines and a stair house on it."""
    x, y = size[0] / 2, size[1] / 2
    roof = Finish(_pick(rng, FLATS), "building", Material.ROOF)
    edge = Finish(wall.colour, "building")
    unit = Finish((0.7, 0.71, 0.72), "building")
    parts = [
        box((-x, -y, height), (x, -y + 0.4, height + 0.7), edge),
        box((-x, y - 0.4, height), (x, y, height + 0.7), edge),
        box((-x, -y, height), (-x + 0.4, y, height + 0.7), edge),
        box((x - 0.4, -y, height), (x, y, height + 0.7), edge),
        box((-x + 0.4, -y + 0.4, height - 0.3), (x - 0.4, y - 0.4, height + 0.05), roof),
    ]
    for _ in range(int(rng.integers(2, 5))):
        cx, cy = float(rng.uniform(-x + 2, x - 2)), float(rng.uniform(-y + 2, y - 2))
        half = float(rng.uniform(0.6, 1.5))
        parts.append(box((cx - half, cy - half, height), (cx + half, cy + half, height + half * 1.2), unit))
    parts.append(box((-x * 0.5, -1.4, height), (-x * 0.5 + 3, 1.4, height + 2.6), edge))
    return parts


def apartment(rng: np.random.Generator, size: tuple[float, float]) -> Mesh:
    """Return a block of flats of a given footprint in metres, 3 to 6 floors, pitched or flat roof."""
    x, y = size[0] / 2, size[1] / 2
    height = 3.2 * int(rng.integers(3, 7))
    wall = Finish(_pick(rng, WALLS), "building", Material.FACADE)
    body = box((-x, -y, 0), (x, y, height), wall)
    if rng.random() < 0.55:  # noqa: PLR2004  a share
        tiles = Finish(_pick(rng, TILES), "building", Material.TILES)
        chimney = Finish((0.45, 0.3, 0.25), "building")
        ridge = float(rng.uniform(-x * 0.6, x * 0.6))
        return join(
            [
                body,
                gable((size[0], size[1] + 0.8), height, y * 0.62, tiles, wall),
                box((ridge - 0.6, 0.6, height), (ridge + 0.6, 1.6, height + y * 0.62 + 0.8), chimney),
            ]
        )
    return join([body, *_flat_roof(rng, size, height, wall)])


def tower(rng: np.random.Generator, size: tuple[float, float]) -> Mesh:
    """Return a high-rise of 20 to 38 m, glazed or with a facade, on a wider base."""
    x, y = size[0] / 2, size[1] / 2
    height = float(rng.uniform(20, 38))
    glazed = rng.random() < 0.5  # noqa: PLR2004  a share
    wall = Finish(
        _pick(rng, GLAZING if glazed else WALLS),
        "building",
        Material.GLASS_FACADE if glazed else Material.FACADE,
    )
    base = Finish(_pick(rng, WALLS), "building", Material.FACADE)
    parts = [
        box((-x - 2.5, -y - 2.5, 0), (x + 2.5, y + 2.5, 5), base),
        box((-x, -y, 5), (x, y, height), wall),
    ]
    return join([*parts, *_flat_roof(rng, size, height, wall)])


def house(rng: np.random.Generator, size: tuple[float, float]) -> Mesh:
    """Return a house of one or two floors under a pitched roof, with a chimney and a porch."""
    x, y = size[0] / 2, size[1] / 2
    height = float(rng.choice([3.2, 5.8]))
    wall = Finish(_pick(rng, WALLS), "building", Material.FACADE)
    tiles = Finish(_pick(rng, TILES), "building", Material.TILES)
    rise = float(rng.uniform(0.5, 0.8)) * y
    return join(
        [
            box((-x, -y, 0), (x, y, height), wall),
            gable((size[0] + 0.9, size[1] + 1.0), height, rise, tiles, wall),
            box(
                (x * 0.4, 0.4, height),
                (x * 0.4 + 0.8, 1.2, height + rise + 0.7),
                Finish((0.45, 0.3, 0.25), "building"),
            ),
            box((-x * 0.6, y, 0), (x * 0.2, y + 1.8, 2.5), wall),
        ]
    )


def hall(rng: np.random.Generator, size: tuple[float, float]) -> Mesh:
    """Return an industrial hall: low, wide, ribbed roof with skylights."""
    x, y = size[0] / 2, size[1] / 2
    height = float(rng.uniform(6, 10))
    wall = Finish(_pick(rng, ((0.62, 0.66, 0.7), (0.72, 0.7, 0.66), (0.45, 0.52, 0.58))), "building")
    roof = Finish(
        _pick(rng, ((0.6, 0.62, 0.64), (0.5, 0.5, 0.5), (0.66, 0.5, 0.42))), "building", Material.ROOF
    )
    light = Finish((0.82, 0.88, 0.9), "building")
    strips = [
        box((at - 0.8, -y * 0.8, height), (at + 0.8, y * 0.8, height + 0.45), light)
        for at in np.arange(-x + 4, x - 3, 7.0).tolist()
    ]
    return join(
        [
            box((-x, -y, 0), (x, y, height - 0.3), wall),
            box((-x, -y, height - 0.3), (x, y, height), roof),
            *strips,
        ]
    )
