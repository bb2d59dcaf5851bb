"""Triangle meshes: a few solids, and many placed copies of a mesh."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from enum import IntEnum
from functools import cache
from itertools import combinations
from typing import Final

import numpy as np

from sunset_town.frame import CARLA_IDS, Flags, Ids, Indices, Pair, Reals

Colour = tuple[float, float, float]
WHITE: Final[Colour] = (1.0, 1.0, 1.0)


Material = IntEnum(
    "Material",
    "PLAIN FACADE GLASS_FACADE ROOF TILES FOLIAGE PAINT BRICK RIBBON BRICK_FACADE "
    "TIMBER SHOP GRAVEL METAL PLANTED SOLAR NEEDLES GLASS",
    start=0,
)
"""The material of a surface, which decides its texture and gloss."""


@dataclass(frozen=True, slots=True)
class Mesh:
    """Triangles and their appearance."""

    triangles: Reals  # corners (T, 3, 3) in metres
    colours: Reals  # reflectance (T, 3) as display values red, green, blue in [0, 1]
    labels: Ids  # CARLA ids (T,)
    materials: Ids  # values of `Material` (T,)
    tinted: Flags  # whether the colour is multiplied by the placed copy's tint (T,)
    # The points (T, 3) in metres that textures start from: a building's origin, a crown's centre.
    anchors: Reals

    def __len__(self) -> int:
        return len(self.triangles)


@dataclass(frozen=True, slots=True)
class Finish:
    """The appearance of a solid: colour, class, material, and whether it takes the copy's tint."""

    colour: Colour
    label: str
    material: Material = Material.PLAIN
    tinted: bool = False


def shell(triangles: Reals, finish: Finish, anchor: Colour = (0.0, 0.0, 0.0)) -> Mesh:
    """Return a mesh of triangles (T, 3, 3) in metres that all look the same."""
    count = len(triangles)
    return Mesh(
        np.ascontiguousarray(triangles, dtype=np.float32),
        np.tile(np.asarray(finish.colour, dtype=np.float32), (count, 1)),
        np.full(count, CARLA_IDS[finish.label], dtype=np.uint8),
        np.full(count, finish.material, dtype=np.uint8),
        np.full(count, finish.tinted, dtype=np.bool_),
        np.tile(np.asarray(anchor, dtype=np.float32), (count, 1)),
    )


def join(*meshes: Mesh) -> Mesh:
    """Return a mesh with all triangles of `meshes`, in order."""
    if not meshes:
        return shell(np.zeros((0, 3, 3), np.float32), Finish(WHITE, "other"))
    return Mesh(*(np.concatenate([getattr(mesh, field.name) for mesh in meshes]) for field in fields(Mesh)))


def place(mesh: Mesh, positions: Reals, yaws: Reals, scales: Reals, tints: Reals) -> Mesh:
    """Return N copies of a mesh, each scaled along its own axes, turned about the vertical, moved and tinted.

    Positions (N, 3) are in metres, yaws (N,) anticlockwise in radians, scales (N, 3), and tints (N, 3) factors of the
    colour of tinted triangles.
    """
    count = len(positions)
    cos, sin = np.cos(yaws)[:, None], np.sin(yaws)[:, None]

    def move(points: Reals) -> Reals:
        local = points.reshape(1, -1, 3) * scales[:, None, :]
        turned = np.empty_like(local)
        turned[..., 0] = local[..., 0] * cos - local[..., 1] * sin + positions[:, None, 0]
        turned[..., 1] = local[..., 0] * sin + local[..., 1] * cos + positions[:, None, 1]
        turned[..., 2] = local[..., 2] + positions[:, None, 2]
        return turned

    factors = np.where(mesh.tinted[None, :, None], tints[:, None, :], np.float32(1))
    return Mesh(
        move(mesh.triangles).reshape(-1, 3, 3),
        (mesh.colours[None] * factors).reshape(-1, 3).astype(np.float32),
        np.tile(mesh.labels, count),
        np.tile(mesh.materials, count),
        np.tile(mesh.tinted, count),
        move(mesh.anchors).reshape(-1, 3),
    )


def box(low: Colour, high: Colour, finish: Finish, *, bottom: bool = False) -> Mesh:
    """Return the box between two corners, by default without its bottom."""
    return taper(low, high, (0.0, 0.0, 0.0), finish, bottom=bottom)


def taper(low: Colour, high: Colour, inset: Colour, finish: Finish, *, bottom: bool = False) -> Mesh:
    """Return a box whose top is smaller than its bottom by insets at the back, the front and either side."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    back, front, side = inset
    ring = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
    top = ((x0 + back, y0 + side), (x1 - front, y0 + side), (x1 - front, y1 - side), (x0 + back, y1 - side))
    corners = np.array([*((x, y, z0) for x, y in ring), *((x, y, z1) for x, y in top)], dtype=np.float32)
    quads = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)]
    if bottom:
        quads.append((3, 2, 1, 0))
    return shell(corners[_triangulate(quads)], finish)


def _triangulate(quads: Sequence[tuple[int, int, int, int]]) -> Indices:
    return np.array([tri for a, b, c, d in quads for tri in ((a, b, c), (a, c, d))])


def gable(size: Pair, base: float, rise: float, finish: Finish, ends: Finish) -> Mesh:
    """Return a pitched roof over a rectangle, its ridge along x; the ends are walls."""
    corners = _roof_corners(size, (size[0] / 2, 0.0), base, rise)
    slopes = corners[_triangulate([(0, 1, 5, 4), (2, 3, 4, 5)])]
    walls = corners[np.array([(1, 2, 5), (3, 0, 4)])]
    return join(shell(slopes, finish), shell(walls, ends))


def hip(size: Pair, base: float, rise: float, finish: Finish) -> Mesh:
    """Return a roof over a rectangle that slopes to all four sides alike, its ridge along the longer side."""
    x, y = size[0] / 2, size[1] / 2
    corners = _roof_corners(size, (max(x - y, 0.0), max(y - x, 0.0)), base, rise)
    faces = (
        [(0, 1, 5), (0, 5, 4), (2, 3, 4), (2, 4, 5), (1, 2, 5), (3, 0, 4)]
        if x >= y
        else [(1, 2, 5), (1, 5, 4), (3, 0, 4), (3, 4, 5), (2, 3, 5), (0, 1, 4)]
    )
    return shell(corners[np.array(faces)], finish)


def _roof_corners(size: Pair, ridge: Pair, base: float, rise: float) -> Reals:
    """Return the corners of the eaves and the ends of the ridge (6, 3); `ridge` is the (x, y) of the second end."""
    x, y = size[0] / 2, size[1] / 2
    eaves = [(-x, -y, base), (x, -y, base), (x, y, base), (-x, y, base)]
    ends = [(-ridge[0], -ridge[1], base + rise), (*ridge, base + rise)]
    return np.array([*eaves, *ends], dtype=np.float32)


def cylinder(radii: Pair, heights: Pair, finish: Finish, *, sides: int = 6) -> Mesh:
    """Return an upright frustum about the z axis with a lid; radii and heights are (bottom, top)."""
    angles = np.arange(sides) * (2 * np.pi / sides)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    low = np.column_stack([ring * radii[0], np.full(sides, heights[0])]).astype(np.float32)
    top = np.column_stack([ring * radii[1], np.full(sides, heights[1])]).astype(np.float32)
    following = np.roll(np.arange(sides), -1)
    lid = np.tile(np.array([0, 0, heights[1]], dtype=np.float32), (sides, 1))
    parts = [
        np.stack([low, low[following], top[following]], axis=1),
        np.stack([low, top[following], top], axis=1),
        np.stack([top, top[following], lid], axis=1),
    ]
    return shell(np.concatenate(parts), finish)


@cache
def _sphere(fine: bool) -> tuple[Reals, Indices]:
    """Return vertices and faces of an icosahedron, (12, 3) and (20, 3), or subdivided, (42, 3) and (80, 3)."""
    golden = (1 + 5**0.5) / 2
    signs = [(a, b) for a in (-1.0, 1.0) for b in (-golden, golden)]
    base = [point for a, b in signs for point in ((0.0, a, b), (a, b, 0.0), (b, 0.0, a))]
    vertices = [np.asarray(point) / np.hypot(1, golden) for point in base]
    edge = min(float(np.linalg.norm(vertices[0] - other)) for other in vertices[1:]) * 1.01
    close = [[float(np.linalg.norm(p - q)) < edge for q in vertices] for p in vertices]
    triples = combinations(range(12), 3)
    faces = [(a, b, c) for a, b, c in triples if close[a][b] and close[b][c] and close[a][c]]
    if not fine:
        return np.array(vertices, dtype=np.float32), np.array(faces)
    middles: dict[tuple[int, int], int] = {}

    def middle(a: int, b: int) -> int:
        key = (min(a, b), max(a, b))
        if key not in middles:
            point = vertices[a] + vertices[b]
            vertices.append(point / np.linalg.norm(point))
            middles[key] = len(vertices) - 1
        return middles[key]

    small = []
    for a, b, c in faces:
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        small += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return np.array(vertices, dtype=np.float32), np.array(small)


def blob(
    rng: np.random.Generator,
    centre: Colour,
    radii: Colour,
    finish: Finish,
    *,
    roughness: float = 0.2,
    fine: bool = True,
) -> Mesh:
    """Return a dented ellipsoid of 80 triangles, or of 20 if not `fine`, anchored at its centre."""
    vertices, faces = _sphere(fine)
    dents = 1 + roughness * rng.uniform(-1, 1, (len(vertices), 1))
    corners = (vertices * dents * np.asarray(radii) + np.asarray(centre)).astype(np.float32)
    return shell(corners[faces], finish, centre)
