"""From what a ray met to a colour: sun, sky, reflections, haze."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from sunset.data.frame import Reals
from sunset.data.light import Light

__all__ = ["Seen", "dot", "shade"]

F: Final = np.float32
GROUND_SHARE: Final = F(0.2)
"""How bright the surroundings are that a wall mirrors, as a share of the haze."""
GLINT_POWER: Final = F(200)


@dataclass(frozen=True, slots=True)
class Seen:
    """What N rays met.

    Attributes:
        normals: unit vectors (N, 3) towards the ray's side.
        colours: linear reflectance (N, 3).
        gloss: share of light mirrored straight on, in [0, 1] (N,).
        lit: share of the sun that the point sees, in [0, 1] (N,).
        open: share of the sky that is not hidden, in [0, 1] (N,).
        depth: planar depth in metres (N,); infinite for sky.
    """

    normals: Reals
    colours: Reals
    gloss: Reals
    lit: Reals
    open: Reals
    depth: Reals


def dot(vectors: Reals, axis: Reals) -> Reals:
    """Return the products (N,) of vectors (N, 3) with vectors (N, 3) or one (3,), added in a fixed order."""
    result: Reals = vectors[:, 0] * axis[..., 0] + vectors[:, 1] * axis[..., 1] + vectors[:, 2] * axis[..., 2]
    return result


def shade(seen: Seen, directions: Reals, light: Light) -> Reals:
    """Return linear colours (N, 3) red, green, blue, of rays with given directions (N, 3)."""
    sun = np.asarray(light.sun_direction, dtype=F)
    n = seen.normals
    direct = seen.lit * np.maximum(dot(n, sun), 0)
    upward = (F(0.5) + F(0.5) * n[:, 2]) * seen.open
    below = (F(0.5) - F(0.5) * n[:, 2]) * (F(0.35) + F(0.65) * seen.open)
    length: Reals = np.sqrt(dot(directions, directions))
    unit: Reals = directions / length[:, None]
    clear = np.exp(-seen.depth * length / F(light.haze_m))
    sky_share = np.sqrt(np.clip(unit[:, 2], 0, 1))
    colours = direct[:, None] * np.asarray(light.sun, F)
    colours += upward[:, None] * np.asarray(light.sky, F)
    colours += below[:, None] * np.asarray(light.bounce, F)
    colours *= seen.colours
    _mirror(seen, unit, light, colours)
    haze, zenith = np.asarray(light.haze, F), np.asarray(light.zenith, F)
    far = haze + (zenith - haze) * sky_share[:, None]
    colours -= far
    colours *= clear[:, None]
    colours += far
    return colours


def _mirror(seen: Seen, directions: Reals, light: Light, colours: Reals) -> None:
    """Add to the colours (N, 3), in place, what glossy surfaces mirror: sky, surroundings, the sun's glint."""
    rows = np.flatnonzero(seen.gloss)
    n, d = seen.normals[rows], directions[rows]
    facing = dot(n, d)
    mirrored = d - 2 * facing[:, None] * n
    gloss = seen.gloss[rows]
    share = gloss + (F(0.75) - gloss) * (1 - np.minimum(np.abs(facing), 1)) ** 4
    haze, zenith = np.asarray(light.haze, F), np.asarray(light.zenith, F)
    climb = mirrored[:, 2]
    sky = haze + (zenith - haze) * np.sqrt(np.clip(climb, 0, 1))[:, None]
    sky *= (GROUND_SHARE + (1 - GROUND_SHARE) * np.clip(climb * 4 + F(0.6), 0, 1))[:, None]
    glint = np.maximum(dot(mirrored, np.asarray(light.sun_direction, F)), 0) ** GLINT_POWER
    glint *= seen.lit[rows] * F(4)
    reflection = sky * seen.open[rows, None] + glint[:, None] * np.asarray(light.sun, F)
    colours[rows] += (reflection - colours[rows]) * share[:, None]
