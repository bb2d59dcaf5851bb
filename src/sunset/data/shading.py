"""From what a ray met to a colour: sun, sky, reflections, haze."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.data.frame import Reals
from sunset.data.light import Light
from sunset.data.vectors import dot, pick

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


def shade(seen: Seen, directions: Reals, light: Light) -> Reals:
    """Return linear colours (N, 3) red, green, blue, of rays with given directions (N, 3)."""
    n = seen.normals
    direct = seen.lit * np.maximum(dot(n, np.asarray(light.sun_direction, dtype=F)), 0)
    upward = (F(0.5) + F(0.5) * n[:, 2]) * seen.open
    below = (F(0.5) - F(0.5) * n[:, 2]) * (F(0.35) + F(0.65) * seen.open)
    length: Reals = np.sqrt(dot(directions, directions))
    unit: Reals = directions / length[:, None]
    clear = np.exp(-seen.depth * length / F(light.haze_m))
    sky_share = np.sqrt(np.clip(unit[:, 2], 0, 1))
    glossy = np.flatnonzero(seen.gloss)
    share, climb, bright, unhidden, glint = _mirrored(seen, unit, light, glossy)
    colours = np.empty_like(seen.colours)
    for channel in range(3):
        sun, sky, bounce, haze, zenith = (
            F(part[channel]) for part in (light.sun, light.sky, light.bounce, light.haze, light.zenith)
        )
        colour = direct * sun
        colour += upward * sky
        colour += below * bounce
        colour *= seen.colours[:, channel]
        bare = colour.take(glossy)
        above = (haze + (zenith - haze) * climb) * bright
        colour[glossy] = bare + (above * unhidden + glint * sun - bare) * share
        far = haze + (zenith - haze) * sky_share
        colours[:, channel] = (colour - far) * clear + far
    return colours


def _mirrored(seen: Seen, directions: Reals, light: Light, rows: npt.NDArray[np.int64]) -> tuple[Reals, ...]:
    """Return what the glossy ones of the points, `rows` (G,), mirror to rays with given directions (N, 3).

    Returns:
        The share of the light that is mirrored; where between the colours of the horizon, 0, and the zenith, 1, that
        comes from; how bright it is, the surroundings being darker than the sky; the share of it that is not hidden;
        and the strength of the sun's reflection; each (G,).
    """
    n, d = pick(seen.normals, rows), pick(directions, rows)
    facing = dot(n, d)
    mirrored = d - 2 * facing[:, None] * n
    gloss = seen.gloss.take(rows)
    climb = mirrored[:, 2]
    glint = np.maximum(dot(mirrored, np.asarray(light.sun_direction, F)), 0) ** GLINT_POWER
    return (
        gloss + (F(0.75) - gloss) * (1 - np.minimum(np.abs(facing), 1)) ** 4,
        np.sqrt(np.clip(climb, 0, 1)),
        GROUND_SHARE + (1 - GROUND_SHARE) * np.clip(climb * 4 + F(0.6), 0, 1),
        seen.open.take(rows),
        glint * (seen.lit.take(rows) * F(4)),
    )
