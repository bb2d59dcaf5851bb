"""Noise in space, and the look of surfaces: the ground, walls with windows, roofs, leaves."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Final

import cv2
import numpy as np

from sunset_town.frame import Ids, Indices, Pair, Reals
from sunset_town.ground import Surface
from sunset_town.meshes import Material
from sunset_town.seeding import generator
from sunset_town.vectors import dot, pick, scaled

NOISE_SIZE: Final = 1024
NOISE_MASK: Final = NOISE_SIZE - 1
F: Final = np.float32

_COLOURS: Final = np.array([np.square(surface.colour) for surface in Surface], dtype=F)
_PATCHES: Final = np.array([surface.patches for surface in Surface], dtype=F)
_GRAINS: Final = np.array([surface.grain for surface in Surface], dtype=F)
_WORN: Final = np.square(np.array((0.5, 0.46, 0.34), dtype=F))


@cache
def broad() -> Reals:
    """Return smooth patches (1024, 1024) in [-1.2, 1.2], repeating without a seam."""
    rng = generator(0, "texture")
    patches = np.zeros((NOISE_SIZE, NOISE_SIZE), dtype=F)
    for cells, weight in ((8, 0.5), (32, 0.35), (128, 0.3), (512, 0.2)):
        coarse = rng.uniform(-1, 1, (cells, cells)).astype(F)
        wrapped = np.pad(coarse, 2, mode="wrap")
        factor = NOISE_SIZE // cells
        large = cv2.resize(wrapped, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC)
        patches += weight * large[2 * factor : -2 * factor, 2 * factor : -2 * factor]
    return np.clip(patches, -1.2, 1.2)


@cache
def grain() -> Reals:
    """Return independent values (1024, 1024) in [-1, 1]."""
    return generator(0, "texture", "grain").uniform(-1, 1, (NOISE_SIZE, NOISE_SIZE)).astype(F)


@cache
def tangle() -> Reals:
    """Return random directions (1024, 1024, 3), each component in [-1, 1], alike over some cells."""
    rng = generator(0, "texture", "tangle")
    coarse = rng.uniform(-1, 1, (NOISE_SIZE // 4, NOISE_SIZE // 4, 3)).astype(F)
    fine = rng.uniform(-1, 1, (NOISE_SIZE, NOISE_SIZE, 3)).astype(F)
    return F(0.6) * np.repeat(np.repeat(coarse, 4, axis=0), 4, axis=1) + F(0.4) * fine


def look_up(table: Reals, a: Reals, b: Reals, cells_per_m: float) -> Reals:
    """Return a table's values (N, ...) at coordinates (N,) in metres."""
    i = np.floor(a * F(cells_per_m)).astype(np.int32) & NOISE_MASK
    j = np.floor(b * F(cells_per_m)).astype(np.int32) & NOISE_MASK
    values: Reals = table.reshape(-1, *table.shape[2:]).take(i * NOISE_SIZE + j, axis=0)
    return values


def hashed(a: Reals, b: Reals, salt: int = 0) -> Reals:
    """Return a value in [0, 1) for each cell (N,) given by two whole numbers."""
    mixed = np.floor(a).astype(np.int32).astype(np.uint32) * np.uint32(0x9E3779B1)
    mixed += np.floor(b).astype(np.int32).astype(np.uint32) * np.uint32(0x85EBCA77)
    mixed += np.uint32(salt * 0x27D4EB2F & 0xFFFFFFFF)
    mixed ^= mixed >> np.uint32(15)
    mixed *= np.uint32(0x2C1B3C6D)
    mixed ^= mixed >> np.uint32(13)
    mixed *= np.uint32(0x297A2D39)
    return (mixed >> np.uint32(8)).astype(F) * F(2.0**-24)


def ground_look(surfaces: Ids, points: Reals, normals: Reals) -> tuple[Reals, Reals]:
    """Return the linear reflectance (N, 3) and gloss (N,) of surfaces (N,) at world points (N, 3).

    The normals (N, 3) of water become normals of ripples, in place.
    """
    x, y = points[:, 0], points[:, 1]
    patches = look_up(broad(), x, y, 4.0)
    factor = 1 + _PATCHES.take(surfaces) * patches + _GRAINS.take(surfaces) * look_up(grain(), x, y, 5.0)
    colours = pick(_COLOURS, surfaces) * factor[:, None]
    _wear_roads(surfaces, points, colours)
    _lay_slabs(surfaces, points, colours)
    _mottle_green(surfaces, points, colours)
    gloss = np.zeros(len(surfaces), dtype=F)
    water = np.flatnonzero(surfaces == Surface.WATER)
    gloss[water] = 0.04
    wind = look_up(broad(), x[water], y[water], 1.5)
    ripple = look_up(tangle(), x[water] + y[water] * F(0.4), y[water], 1.6)
    normals[water] = (0, 0, 1)
    normals[water, :2] += ripple[:, :2] * (F(0.035) + F(0.02) * wind)[:, None]
    return colours, gloss


def _wear_roads(surfaces: Ids, points: Reals, colours: Reals) -> None:
    """Repairs and oil on asphalt; markings rubbed off here and there."""
    road = np.flatnonzero((surfaces == Surface.ASPHALT) | (surfaces == Surface.YARD))
    x, y, _ = pick(points, road).T
    skewed = x * F(0.94) + y * F(0.34), y * F(0.94) - x * F(0.34)
    repaired = hashed(skewed[0] / F(5.3), skewed[1] / F(3.1), 1)
    tone = np.where(repaired < F(0.045), F(0.84), F(1))
    tone += np.where(repaired > F(0.97), F(0.1), F(0))
    aged = look_up(broad(), x, y, 0.35)
    spots = look_up(broad(), x + F(71), y, 14.0)
    tone *= 1 + F(0.16) * aged - F(0.35) * np.clip(spots - F(0.45), 0, F(0.5))
    colours[road] *= tone[:, None]
    lines = np.flatnonzero(surfaces == Surface.MARKING)
    x, y, _ = pick(points, lines).T
    worn = np.clip(look_up(broad(), x, y, 9.0) + look_up(broad(), x, y, 0.5) * F(0.6), 0, 1)
    share = (F(0.12) + F(0.6) * worn)[:, None]
    paint = pick(colours, lines)
    colours[lines] = paint + (_COLOURS[Surface.ASPHALT] - paint) * share


def _lay_slabs(surfaces: Ids, points: Reals, colours: Reals) -> None:
    """Slabs of slightly differing tone on pavements and squares, bands of another stone across squares."""
    slabs = np.flatnonzero(np.isin(surfaces, (Surface.PLAZA, Surface.PAVING, Surface.DECK)))
    x, y, _ = pick(points, slabs).T
    square = surfaces[slabs] == Surface.PLAZA
    size = np.where(square, F(1.6), F(0.9))
    tone = F(0.92) + F(0.16) * hashed(x / size, y / size, 2)
    band = (np.abs(x / 9 - np.round(x / 9)) < 0.05) | (np.abs(y / 9 - np.round(y / 9)) < 0.05)
    tone = np.where(square & band, tone * F(0.76), tone)
    dirt = np.clip(look_up(broad(), x, y, 1.3), 0, 1)
    colours[slabs] *= (tone * (1 - F(0.2) * dirt))[:, None]


def _mottle_green(surfaces: Ids, points: Reals, colours: Reals) -> None:
    """Lush, dry and worn spots in grass; furrows and varying growth in fields; stripes where it is mown."""
    green = np.flatnonzero(np.isin(surfaces, (Surface.LAWN, Surface.GRASS, Surface.FIELD, Surface.CROPS)))
    kinds = surfaces[green]
    x, y, _ = pick(points, green).T
    dryness = look_up(broad(), x, y, 0.6) * F(0.5) + look_up(broad(), y, x, 0.15) * F(0.5)
    tone = 1 + scaled(np.array((1.35, 1.16, 1.0), dtype=F) - 1, dryness * F(1.1))
    field = (kinds == Surface.FIELD) | (kinds == Surface.CROPS)
    plot = hashed(x / F(97) + y / F(310), y / F(71) - x / F(420), 3)
    rows = np.sin((x + y * F(0.6)) * F(1.7))
    tone *= np.where(field, F(0.72) + F(0.5) * plot + F(0.06) * rows, F(1))[:, None]
    mown = np.where(np.sin(x * F(0.9) - y * F(1.2)) > 0, F(1.05), F(0.95))
    tone *= np.where(kinds == Surface.LAWN, mown, F(1))[:, None]
    base = pick(colours, green) * tone
    bare = look_up(broad(), x + F(33), y, 2.2) + F(0.5) * look_up(broad(), x, y, 7.0)
    worn = np.where(field, F(0), np.clip(bare * F(1.6) - F(0.9), 0, F(0.75)))
    colours[green] = base + (_WORN - base) * worn[:, None]


@dataclass(frozen=True, slots=True)
class Surfaces:
    """The points that N rays met on solid things."""

    materials: Ids  # values of `Material` (N,)
    points: Reals  # world points (N, 3) in metres
    anchors: Reals  # origins of the textures (N, 3)
    depth: Reals  # in metres (N,)
    normals: Reals  # unit vectors (N, 3) towards the ray's side
    colours: Reals  # linear reflectance (N, 3)
    gloss: Reals  # share of light mirrored straight on, in [0, 1] (N,)


@dataclass(frozen=True, slots=True)
class _Windows:
    """A grid of windows on a wall: sizes in metres, extents as shares of a grid cell."""

    width: Pair
    floor: float
    sill: float
    lintel: float
    wide: Pair
    gloss: float


_WINDOWS: Final = {
    Material.FACADE: _Windows((2.2, 3.6), 3.2, 0.3, 0.76, (0.36, 0.56), 0.08),
    Material.BRICK_FACADE: _Windows((2.4, 3.4), 3.2, 0.28, 0.78, (0.34, 0.46), 0.08),
    Material.TIMBER: _Windows((2.8, 3.8), 3.2, 0.32, 0.74, (0.3, 0.42), 0.08),
    Material.RIBBON: _Windows((1.4, 2.4), 3.2, 0.36, 0.8, (0.9, 0.95), 0.1),
    Material.GLASS_FACADE: _Windows((1.4, 2.2), 3.6, 0.08, 0.93, (0.9, 0.94), 0.3),
    Material.SHOP: _Windows((2.6, 4.2), 4.2, 0.08, 0.66, (0.84, 0.92), 0.1),
}
_SIGNS: Final = np.square(
    np.array(
        [(0.25, 0.3, 0.42), (0.5, 0.22, 0.2), (0.24, 0.36, 0.3), (0.75, 0.72, 0.66), (0.22, 0.22, 0.24)], F
    )
)


def finish_solids(seen: Surfaces) -> None:
    """Draw windows, tiles, leaves and the like into the colours, gloss and normals, in place."""
    upright = np.abs(seen.normals[:, 2]) < F(0.5)
    counts = np.bincount(seen.materials, minlength=len(Material))
    made_of = np.split(np.argsort(seen.materials, kind="stable"), np.cumsum(counts)[:-1])
    for material, windows in _WINDOWS.items():
        rows = made_of[material]
        _draw_windows(seen, rows[upright.take(rows)], windows, shop=material is Material.SHOP)
    for material, draw in _DRAWN.items():
        rows = made_of[material]
        if len(rows):
            draw(seen, rows)
    seen.gloss[made_of[Material.PAINT]] = F(0.05)
    seen.gloss[made_of[Material.GLASS]] = F(0.12)


def _draw_windows(seen: Surfaces, rows: Indices, windows: _Windows, *, shop: bool) -> None:
    """Draw a grid of windows, or their mean where they are smaller than a pixel."""
    if not len(rows):
        return
    normals, anchors = pick(seen.normals, rows), pick(seen.anchors, rows)
    local = pick(seen.points, rows) - anchors
    along = local[:, 1] * normals[:, 0] - local[:, 0] * normals[:, 1]
    house = anchors[:, 0] * F(3), anchors[:, 1] * F(3)
    varied = hashed(*house)
    width = F(windows.width[0]) + F(windows.width[1] - windows.width[0]) * varied
    wide = F(windows.wide[0]) + F(windows.wide[1] - windows.wide[0]) * hashed(*house, 1)
    across, up = along / width + wide / 2, local[:, 2] / F(windows.floor)
    column, storey = np.floor(across), np.floor(up)
    x, z = across - column, up - storey
    inside = (x < wide) & (z > F(windows.sill)) & (z < F(windows.lintel)) & (local[:, 2] > 0)
    near = np.clip(F(2.0) - seen.depth[rows] / 110, 0, 1)
    mean = wide * F(windows.lintel - windows.sill)
    share = (inside * near + mean * (1 - near))[:, None]
    drawn = hashed(column + house[0], storey + house[1], 2)
    pane = F(0.018 + 0.25 * windows.gloss) + F(0.03) * drawn + F(0.22) * (drawn > F(0.86)) + F(0.04) * (1 - z)
    glass = scaled(np.array((0.94, 1.0, 1.08), F), pane)
    wall = pick(seen.colours, rows) * _weathered(local, along)[:, None]
    if shop:
        band = (z > F(0.72)) & (z < F(0.9)) & (local[:, 2] > 0)
        name = (hashed(np.floor(along / 7) + house[0], house[1], 3) * len(_SIGNS)).astype(np.int64)
        wall = np.where(band[:, None], _SIGNS[name], wall)
    sill = inside & (z < F(windows.sill + 0.045))
    wall = np.where(sill[:, None], np.minimum(wall * F(1.3), F(0.7)), wall)
    share = np.where(sill[:, None], F(0), share)
    seen.colours[rows] = wall + (glass - wall) * share
    seen.gloss[rows] = share[:, 0] * F(windows.gloss)


def _weathered(local: Reals, along: Reals) -> Reals:
    """Return the brightness (N,) of wall: dirty near the ground, streaked and patchy."""
    height = local[:, 2]
    streaks = look_up(broad(), along, height * F(0.15), 5.0)
    splash = np.clip(F(1.2) - height, 0, 1)
    tone: Reals = 1 + F(0.08) * streaks - F(0.18) * splash
    return tone


def _draw_bricks(seen: Surfaces, rows: Indices) -> None:
    local, normals = pick(seen.points, rows) - pick(seen.anchors, rows), pick(seen.normals, rows)
    along = local[:, 1] * normals[:, 0] - local[:, 0] * normals[:, 1]
    tone = 1 + F(0.12) * look_up(grain(), along, local[:, 2], 3.0)
    seen.colours[rows] *= (tone + F(0.14) * look_up(broad(), along, local[:, 2], 6.0))[:, None]


def _draw_stains(seen: Surfaces, rows: Indices) -> None:
    """Stains, puddle marks and the seams of sheets on a flat roof."""
    points = pick(seen.points, rows)
    local = points - pick(seen.anchors, rows)
    x, y, _ = points.T
    sheet = hashed(local[:, 0] / F(1.1), local[:, 1] / F(9), 4)
    stains = look_up(broad(), x, y, 8.0)
    pools = np.clip(look_up(broad(), y, x, 3.0) - F(0.3), 0, F(0.6))
    seen.colours[rows] *= (F(0.96) + F(0.08) * sheet + F(0.14) * stains - F(0.4) * pools)[:, None]


def _draw_gravel(seen: Surfaces, rows: Indices) -> None:
    x, y, _ = pick(seen.points, rows).T
    tone = 1 + F(0.16) * look_up(grain(), x, y, 5.0) + F(0.16) * look_up(broad(), x, y, 5.0)
    seen.colours[rows] *= tone[:, None]


def _draw_tiles(seen: Surfaces, rows: Indices) -> None:
    """Each tile a little different, lichen and weathered patches, darker towards the eaves of each course."""
    x, y, z = pick(seen.points, rows).T
    aged = look_up(broad(), x, y, 9.0)
    single = look_up(grain(), x + y, z * F(2), 3.2)
    moss = np.clip(look_up(broad(), y + F(17), x, 4.0) - F(0.35), 0, F(0.5))[:, None]
    near = np.clip(F(1.6) - seen.depth[rows] / 60, 0, 1)
    course = np.abs(z * F(2.6) - np.floor(z * F(2.6)) - F(0.5)) * near
    tone = 1 + F(0.12) * aged + F(0.1) * single + F(0.14) * (course - F(0.25) * near)
    base = pick(seen.colours, rows) * tone[:, None]
    seen.colours[rows] = base + (np.array((0.1, 0.1, 0.075), F) - base) * moss


def _draw_ribs(seen: Surfaces, rows: Indices) -> None:
    """Standing seams of sheet metal, and rust."""
    points, normals = pick(seen.points, rows), pick(seen.normals, rows)
    local = points - pick(seen.anchors, rows)
    flat = np.abs(normals[:, 2]) > F(0.5)
    along = np.where(flat, local[:, 0], local[:, 1] * normals[:, 0] - local[:, 0] * normals[:, 1])
    rib = np.sin(along * F(2 * np.pi / 0.9)) * np.clip(F(1.4) - seen.depth[rows] / 60, 0, 1)
    x, y, _ = points.T
    rust = np.clip(look_up(broad(), x, y, 4.0), 0, 1)
    base = pick(seen.colours, rows) * (1 + F(0.1) * rib)[:, None]
    seen.colours[rows] = base * (1 - scaled(np.array((0.1, 0.2, 0.28), F), rust))
    seen.gloss[rows] = F(0.05)


def _draw_sedum(seen: Surfaces, rows: Indices) -> None:
    x, y, _ = pick(seen.points, rows).T
    share = np.clip(F(0.4) + F(0.6) * look_up(broad(), x, y, 6.0), 0, 1)[:, None]
    base = pick(seen.colours, rows) * (1 + F(0.2) * look_up(grain(), x, y, 3.0))[:, None]
    seen.colours[rows] = base + (np.square(np.array((0.46, 0.4, 0.28), F)) - base) * share


def _draw_panels(seen: Surfaces, rows: Indices) -> None:
    local = pick(seen.points, rows) - pick(seen.anchors, rows)
    near = np.clip(F(1.5) - seen.depth[rows] / 60, 0, 1)
    frame = (local[:, 0] - np.floor(local[:, 0]) < F(0.07)) | (local[:, 1] / F(1.7) % 1 < F(0.05))
    seen.colours[rows] = pick(seen.colours, rows) + (F(0.2) * frame * near)[:, None]
    seen.gloss[rows] = F(0.12)


def _draw_leaves(seen: Surfaces, rows: Indices) -> None:
    """Leaf clumps: normals of the crown's ellipsoid disturbed, gaps into the dark, lighter above and outside."""
    points, anchors = pick(seen.points, rows), pick(seen.anchors, rows)
    outward = points - anchors
    outward /= np.maximum(np.sqrt(dot(outward, outward))[:, None], F(1e-6))
    x, y, z = points[:, 0], points[:, 1], points[:, 2]
    a, b = x + z * F(0.7), y - z * F(0.6)
    layer = np.floor(z * F(4))
    leaf = x + layer * F(13.7), y + layer * F(7.3)
    normals = outward + F(0.7) * look_up(tangle(), *leaf, 5.0)
    normals[:, 2] += F(0.25)
    normals /= np.maximum(np.sqrt(dot(normals, normals))[:, None], F(1e-6))
    seen.normals[rows] = normals
    speckle, clump = look_up(grain(), *leaf, 4.0), look_up(broad(), a, b, 14.0)
    tone = 1 + F(0.22) * speckle + F(0.32) * clump
    tone *= F(0.72) + F(0.28) * outward[:, 2]
    tone[clump + F(0.4) * speckle < F(-0.55)] *= F(0.5)
    hue = hashed(anchors[:, 0] * 2, anchors[:, 1] * 2, 5) - F(0.5)
    tint = 1 + scaled(np.array((0.3, 0.08, -0.1), F), hue)
    seen.colours[rows] = _muted(pick(seen.colours, rows)) * np.maximum(tone, F(0.2))[:, None] * tint


def _draw_needles(seen: Surfaces, rows: Indices) -> None:
    """Dark branches of a conifer around its axis."""
    points = pick(seen.points, rows)
    layer = np.floor(points[:, 2] * F(4))
    leaf = points[:, 0] + layer * F(13.7), points[:, 1] + layer * F(7.3)
    normals = pick(seen.normals, rows) + F(0.6) * look_up(tangle(), *leaf, 5.0)
    normals[:, 2] = np.abs(normals[:, 2]) + F(0.1)
    seen.normals[rows] = normals / np.sqrt(dot(normals, normals))[:, None]
    speckle = look_up(grain(), *leaf, 4.0)
    seen.colours[rows] = _muted(pick(seen.colours, rows)) * (F(0.9) + F(0.35) * speckle)[:, None]


def _muted(leaves: Reals) -> Reals:
    """Return colours of leaves (N, 3) as seen through air and gaps: less saturated."""
    grey = dot(leaves, np.array((0.3, 0.6, 0.1), F))[:, None]
    return grey + (leaves - grey) * F(0.72)


_DRAWN: Final[Mapping[Material, Callable[[Surfaces, Indices], None]]] = {
    Material.BRICK: _draw_bricks,
    Material.BRICK_FACADE: _draw_bricks,
    Material.ROOF: _draw_stains,
    Material.GRAVEL: _draw_gravel,
    Material.TILES: _draw_tiles,
    Material.METAL: _draw_ribs,
    Material.PLANTED: _draw_sedum,
    Material.SOLAR: _draw_panels,
    Material.FOLIAGE: _draw_leaves,
    Material.NEEDLES: _draw_needles,
}
