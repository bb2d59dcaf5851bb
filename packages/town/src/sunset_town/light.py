"""Light at a time of day in some weather, and the colours of surfaces in it."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from sunset_town.errors import TownError
from sunset_town.frame import Indices, Points, Reals
from sunset_town.vectors import dot, pick

NOON_LEVEL: Final = 1.13
"""Mean light on the ground at noon in clear weather, for which the exposure is set."""
ADAPTATION: Final = 0.75
"""The share of a lack of light for which the exposure compensates."""
GROUND_SHARE: Final = np.float32(0.2)
"""Brightness of the surroundings in a reflection, as a share of the haze."""
GLINT_POWER: Final = np.float32(200)

_SUNS: Final = {  # elevation and azimuth in degrees, colour
    "morning": (34.0, 20.0, (1.12, 0.95, 0.74)),
    "noon": (58.0, 250.0, (1.1, 1.04, 0.95)),
    "evening": (24.0, 160.0, (1.15, 0.82, 0.55)),
}
_AIR: Final = {  # share of direct sun, strength of sky light, sun's radius, haze distance, its brightness
    "clear": (1.0, 1.0, 0.012, 1700.0, 0.7),
    "hazy": (0.7, 1.25, 0.03, 480.0, 0.72),
    "overcast": (0.16, 1.8, 0.12, 1100.0, 0.55),
}
TIMES: Final = tuple(_SUNS)
"""The times of day."""
WEATHERS: Final = tuple(_AIR)
"""The kinds of weather."""


@dataclass(frozen=True, slots=True, eq=False)
class Light:
    """The light in a town; colours (3,) are linear red, green, blue."""

    sun_direction: Points  # unit vector (3,) towards the sun
    sun: Points  # colour and strength of the direct light
    sky: Points  # of the light from above
    bounce: Points  # of the light from below
    haze: Points  # colour of distant air
    haze_m: float  # distance in metres over which haze takes 63 %
    zenith: Points  # colour of the sky overhead
    sun_radius: float  # apparent radius of the source of the direct light, in radians
    exposure: float  # the camera's factor

    @property
    def shadow(self) -> float:
        """The length of the longest shadow on level ground, as a multiple of the height of its object."""
        x, y, z = self.sun_direction
        return float((np.hypot(x, y) + self.sun_radius) / (z - self.sun_radius))


def light(time: str, weather: str) -> Light:
    """Return the light at a time of day in some weather.

    Raises:
        TownError: the time is not in `TIMES` or the weather not in `WEATHERS`.
    """
    if time not in _SUNS:
        raise TownError(f"A time of day must be one of {', '.join(TIMES)}, got {time!r}.")
    if weather not in _AIR:
        raise TownError(f"A weather must be one of {', '.join(WEATHERS)}, got {weather!r}.")
    elevation, azimuth, colour = _SUNS[time]
    share, diffuse, radius, distance, brightness = _AIR[weather]
    e, a = np.radians(elevation), np.radians(azimuth)
    grey, clear = np.array([0.64, 0.67, 0.7]), np.array([0.42, 0.55, 0.76])
    tone = clear if weather == "clear" else grey
    sun = np.asarray(colour) * share * (0.75 + 0.25 * np.sin(e))
    sky = tone * 0.5 * diffuse * (0.8 + 0.2 * np.sin(e))
    glow = np.asarray(colour) / max(colour)
    haze = (0.4 * glow + 0.6 * np.array([0.78, 0.82, 0.87])) * brightness * (0.75 + 0.25 * np.sin(e))
    level = float((sun * np.sin(e) + sky).mean())
    return Light(
        sun_direction=np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)]),
        sun=sun,
        sky=sky,
        bounce=np.array([0.13, 0.12, 0.1]) * (share + 0.4),
        haze=haze,
        haze_m=distance,
        zenith=tone * 0.6 * brightness / 0.7,
        sun_radius=radius,
        exposure=1.62 * (NOON_LEVEL / level) ** ADAPTATION,
    )


@dataclass(frozen=True, slots=True)
class Seen:
    """The points that N rays met."""

    normals: Reals  # unit vectors (N, 3) towards the ray's side
    colours: Reals  # linear reflectance (N, 3)
    gloss: Reals  # share of light mirrored straight on, in [0, 1] (N,)
    lit: Reals  # visible share of the sun, in [0, 1] (N,)
    open: Reals  # visible share of the sky, in [0, 1] (N,)
    depth: Reals  # planar depth in metres (N,); infinite for sky


def shade(seen: Seen, directions: Reals, light: Light) -> Reals:
    """Return linear colours (N, 3) red, green, blue, of rays with given directions (N, 3)."""
    half, n = np.float32(0.5), seen.normals
    direct = seen.lit * np.maximum(dot(n, np.asarray(light.sun_direction, dtype=np.float32)), 0)
    upward = (half + half * n[:, 2]) * seen.open
    below = (half - half * n[:, 2]) * (np.float32(0.35) + np.float32(0.65) * seen.open)
    length: Reals = np.sqrt(dot(directions, directions))
    unit: Reals = directions / length[:, None]
    clear = np.exp(-seen.depth * length / np.float32(light.haze_m))
    sky_share = np.sqrt(np.clip(unit[:, 2], 0, 1))
    glossy = np.flatnonzero(seen.gloss)
    share, climb, bright, unhidden, glint = _mirrored(seen, unit, light, glossy)
    colours = np.empty_like(seen.colours)
    lights = (light.sun, light.sky, light.bounce, light.haze, light.zenith)
    for channel in range(3):
        sun, sky, bounce, haze, zenith = (np.float32(part[channel]) for part in lights)
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


def _mirrored(seen: Seen, directions: Reals, light: Light, rows: Indices) -> tuple[Reals, ...]:
    """Return the reflections in glossy points, `rows` (G,), on rays with given directions (N, 3).

    Returns:
        The mirrored share of the light; its origin, from 0 at the horizon to 1 in the zenith; its brightness, as the
        surroundings are darker than the sky; its visible share; and the strength of the sun's reflection; each (G,).
    """
    n, d = pick(seen.normals, rows), pick(directions, rows)
    facing = dot(n, d)
    mirrored = d - 2 * facing[:, None] * n
    gloss = seen.gloss.take(rows)
    climb = mirrored[:, 2]
    glint = np.maximum(dot(mirrored, np.asarray(light.sun_direction, np.float32)), 0) ** GLINT_POWER
    return (
        gloss + (np.float32(0.75) - gloss) * (1 - np.minimum(np.abs(facing), 1)) ** 4,
        np.sqrt(np.clip(climb, 0, 1)),
        GROUND_SHARE + (1 - GROUND_SHARE) * np.clip(climb * 4 + np.float32(0.6), 0, 1),
        seen.open.take(rows),
        glint * (seen.lit.take(rows) * np.float32(4)),
    )
