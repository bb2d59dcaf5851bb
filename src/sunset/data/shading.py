"""From what a ray met to a colour: textures, sun, sky, haze."""

from dataclasses import dataclass
from functools import cache
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from sunset.data.frame import Ids, Reals
from sunset.data.ground import Surface
from sunset.data.light import Light
from sunset.data.meshes import Material
from sunset.seeding import generator

__all__ = ["Seen", "ground_colours", "shade", "solid_colours"]

NOISE_SIZE: Final = 1024
NOISE_MASK: Final = NOISE_SIZE - 1

_GROUND: Final = {  # display colour; strength of broad patches; strength of grain
    Surface.FIELD: ((0.46, 0.47, 0.26), 0.5, 0.12),
    Surface.LAWN: ((0.36, 0.47, 0.22), 0.3, 0.12),
    Surface.GRASS: ((0.4, 0.5, 0.24), 0.45, 0.14),
    Surface.ASPHALT: ((0.36, 0.36, 0.37), 0.22, 0.07),
    Surface.MARKING: ((0.86, 0.86, 0.84), 0.2, 0.06),
    Surface.PAVING: ((0.64, 0.61, 0.57), 0.18, 0.07),
    Surface.KERB: ((0.72, 0.71, 0.68), 0.1, 0.05),
    Surface.PLAZA: ((0.7, 0.6, 0.5), 0.2, 0.06),
    Surface.EARTH: ((0.55, 0.44, 0.33), 0.45, 0.14),
    Surface.PATH: ((0.72, 0.62, 0.48), 0.2, 0.1),
    Surface.WATER: ((0.16, 0.27, 0.3), 0.15, 0.02),
    Surface.DECK: ((0.6, 0.57, 0.6), 0.15, 0.05),
    Surface.BALLAST: ((0.44, 0.38, 0.36), 0.2, 0.22),
    Surface.SLEEPER: ((0.33, 0.27, 0.24), 0.1, 0.1),
    Surface.RAIL: ((0.6, 0.55, 0.52), 0.1, 0.05),
    Surface.SHRUBS: ((0.25, 0.36, 0.17), 0.4, 0.3),
    Surface.CROPS: ((0.5, 0.48, 0.27), 0.5, 0.14),
    Surface.YARD: ((0.56, 0.52, 0.47), 0.3, 0.08),
}
_COLOURS: Final = np.array([np.square(_GROUND[surface][0]) for surface in Surface], dtype=np.float32)
_PATCHES: Final = np.array([_GROUND[surface][1] for surface in Surface], dtype=np.float32)
_GRAINS: Final = np.array([_GROUND[surface][2] for surface in Surface], dtype=np.float32)


@dataclass(frozen=True, slots=True)
class Seen:
    """What N rays met.

    Attributes:
        points: world points (N, 3) in metres.
        normals: unit vectors (N, 3) towards the ray's side.
        colours: linear reflectance (N, 3).
        gloss: share of mirrored sky in [0, 1] (N,).
        lit: whether the sun reaches the point (N,).
        depth: planar depth in metres (N,); infinite for sky.
    """

    points: Reals
    normals: Reals
    colours: Reals
    gloss: Reals
    lit: npt.NDArray[np.bool_]
    depth: Reals


@cache
def _noise() -> tuple[Reals, Reals]:
    """Return (broad patches, grain), each (1024, 1024) in about [-1, 1], repeating without a seam."""
    rng = generator(0, "texture")
    white = rng.uniform(-1, 1, (NOISE_SIZE, NOISE_SIZE)).astype(np.float32)
    broad = np.zeros_like(white)
    for cells, weight in ((8, 0.5), (32, 0.35), (128, 0.3), (512, 0.2)):
        coarse = rng.uniform(-1, 1, (cells, cells)).astype(np.float32)
        wrapped = np.pad(coarse, 2, mode="wrap")
        factor = NOISE_SIZE // cells
        large = cv2.resize(wrapped, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC)
        broad += weight * large[2 * factor : -2 * factor, 2 * factor : -2 * factor]
    return np.clip(broad, -1.2, 1.2), white


def _lookup(table: Reals, a: Reals, b: Reals, cells_per_m: float) -> Reals:
    i = np.floor(a * np.float32(cells_per_m)).astype(np.int32) & NOISE_MASK
    j = np.floor(b * np.float32(cells_per_m)).astype(np.int32) & NOISE_MASK
    found: Reals = table[i, j]
    return found


def ground_colours(surfaces: Ids, points: Reals) -> Reals:
    """Return the linear reflectance (N, 3) of ground surfaces (N,) at world points (N, 3)."""
    broad, grain = _noise()
    x, y = points[:, 0], points[:, 1]
    factor = (
        1 + _PATCHES[surfaces] * _lookup(broad, x, y, 4.0) + _GRAINS[surfaces] * _lookup(grain, x, y, 3.0)
    )
    colours = _COLOURS[surfaces] * factor[:, None]
    tiles = np.flatnonzero((surfaces == Surface.PLAZA) | (surfaces == Surface.PAVING))
    checks = (np.floor(x[tiles] / 2).astype(np.int32) + np.floor(y[tiles] / 2).astype(np.int32)) & 1
    colours[tiles] *= np.where(surfaces[tiles] == Surface.PLAZA, 0.86 + 0.2 * checks, 0.95 + 0.08 * checks)[
        :, None
    ]
    furrows = np.flatnonzero((surfaces == Surface.FIELD) | (surfaces == Surface.CROPS))
    patch = _lookup(broad, x[furrows], y[furrows], 0.25)
    tone = np.stack([1 + 0.4 * patch, 1 + 0.15 * patch, 1 - 0.1 * patch], axis=1)
    colours[furrows] *= tone
    return colours


@dataclass(frozen=True, slots=True)
class _Windows:
    """A grid of windows on a wall: sizes in metres, extents as shares of a grid cell."""

    material: Material
    width: float
    floor: float
    sill: float
    lintel: float
    wide: float

    def draw(self, along: Reals, height: Reals, near: Reals) -> tuple[Reals, Reals]:
        """Return what share of each wall point (N,) is window and the window's colour (N, 3).

        Where `near` is 0, windows are smaller than a pixel and the share is their mean.
        """
        across, up = along / self.width, height / self.floor
        inside = across - np.floor(across) < self.wide
        inside &= (up - np.floor(up) > self.sill) & (up - np.floor(up) < self.lintel)
        mean = np.float32(self.wide * (self.lintel - self.sill))
        share = (inside * near + mean * (1 - near)).astype(np.float32)[:, None]
        panes = np.floor(across).astype(np.int32) * 7 + np.floor(up).astype(np.int32) * 13
        brightness = np.float32(0.03) + np.float32(0.05) * ((panes & 7) == 0)
        return share, np.stack([brightness, brightness * 1.15, brightness * 1.35], axis=1)


_WINDOWS: Final = (
    _Windows(Material.FACADE, 2.6, 3.2, 0.32, 0.78, 0.5),
    _Windows(Material.GLASS_FACADE, 1.8, 3.6, 0.1, 0.9, 0.84),
)


def solid_colours(
    materials: Ids, colours: Reals, points: Reals, normals: Reals, depth: Reals
) -> tuple[Reals, Reals]:
    """Return reflectance (N, 3) and gloss (N,) of solids, with windows, tiles, leaves and bricks drawn in."""
    broad, grain = _noise()
    result = colours.copy()
    gloss = np.zeros(len(materials), dtype=np.float32)
    along = points[:, 1] * normals[:, 0] - points[:, 0] * normals[:, 1]
    upright = np.abs(normals[:, 2]) < 0.5  # noqa: PLR2004  walls, not roofs
    near = np.clip(2.2 - depth / 130, 0, 1).astype(np.float32)
    for pattern in _WINDOWS:
        walls = np.flatnonzero((materials == pattern.material) & upright)
        share, pane = pattern.draw(along[walls], points[walls, 2], near[walls])
        result[walls] = result[walls] * (1 - share) + pane * share
        gloss[walls] = share[:, 0] * np.float32(0.45)
    height = points[:, 2]
    leafy = np.flatnonzero(materials == Material.FOLIAGE)
    speckle = _lookup(grain, points[leafy, 0] + height[leafy], points[leafy, 1] - height[leafy], 1.8)
    result[leafy] *= (1 + 0.45 * speckle)[:, None]
    roofs = np.flatnonzero((materials == Material.ROOF) | (materials == Material.TILES))
    stains = _lookup(broad, points[roofs, 0], points[roofs, 1], 8.0)
    result[roofs] *= (1 + 0.22 * stains)[:, None]
    tiles = np.flatnonzero(materials == Material.TILES)
    courses = (np.floor(height[tiles] * 2.2).astype(np.int32) & 1) * np.float32(0.16) + np.float32(0.92)
    result[tiles] *= courses[:, None]
    bricks = np.flatnonzero(materials == Material.BRICK)
    result[bricks] *= (1 + 0.2 * _lookup(grain, along[bricks], height[bricks], 2.0))[:, None]
    gloss[materials == Material.PAINT] = 0.2
    return result, gloss


def shade(seen: Seen, directions: Reals, light: Light) -> Reals:
    """Return linear colours (N, 3) red, green, blue, of rays with given directions (N, 3)."""
    towards = np.asarray(light.sun_direction, dtype=np.float32)
    n = seen.normals
    facing = n[:, 0] * towards[0] + n[:, 1] * towards[1] + n[:, 2] * towards[2]
    direct = np.where(seen.lit, np.maximum(facing, 0), np.float32(0))
    upward = 0.5 + 0.5 * n[:, 2]
    length = np.sqrt(directions[:, 0] ** 2 + directions[:, 1] ** 2 + directions[:, 2] ** 2)
    climb = directions[:, 2] / length
    mirrored = np.clip(np.abs(climb - 2 * n[:, 2] * (climb * n[:, 2])), 0, 1)
    clear = np.exp(-seen.depth * length / np.float32(light.haze_m))
    sky_share = np.clip(climb * 3, 0, 1)
    result = np.empty((len(n), 3), dtype=np.float32)
    for channel in range(3):
        lit = direct * np.float32(light.sun[channel]) + upward * np.float32(light.sky[channel])
        lit += (1 - upward) * np.float32(light.bounce[channel])
        haze, zenith = np.float32(light.haze[channel]), np.float32(light.zenith[channel])
        reflection = haze + (zenith - haze) * mirrored
        colour = seen.colours[:, channel] * lit * (1 - seen.gloss) + reflection * seen.gloss
        far = haze + (zenith - haze) * sky_share
        result[:, channel] = colour * clear + far * (1 - clear)
    return result
