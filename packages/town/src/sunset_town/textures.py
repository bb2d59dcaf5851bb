"""Noise in space, and the look of the ground: colour, gloss and ripples at each point."""

from functools import cache
from typing import Final

import cv2
import numpy as np

from sunset_town.frame import Ids, Reals
from sunset_town.ground import Surface
from sunset_town.seeding import generator
from sunset_town.vectors import pick, put, scale, scaled

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
    scale(colours, road, tone)
    lines = np.flatnonzero(surfaces == Surface.MARKING)
    x, y, _ = pick(points, lines).T
    worn = np.clip(look_up(broad(), x, y, 9.0) + look_up(broad(), x, y, 0.5) * F(0.6), 0, 1)
    share = (F(0.12) + F(0.6) * worn)[:, None]
    paint = pick(colours, lines)
    put(colours, lines, paint + (_COLOURS[Surface.ASPHALT] - paint) * share)


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
    scale(colours, slabs, tone * (1 - F(0.2) * dirt))


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
    put(colours, green, base + (_WORN - base) * worn[:, None])
