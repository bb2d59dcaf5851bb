"""Sun, sky and air at a time of day in some weather."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from sunset.data.frame import Points
from sunset.errors import InvalidInputError
from sunset.flights import TIMES, WEATHERS

NOON_LEVEL: Final = 1.13
"""Mean light on the ground at noon in clear weather, which the exposure is set for."""
ADAPTATION: Final = 0.75
"""How far the camera makes up for less light: 0 not, 1 entirely."""


@dataclass(frozen=True, slots=True, eq=False)
class Light:
    """What lights a town; colours (3,) are linear red, green, blue.

    Attributes:
        sun_direction: unit vector (3,) towards the sun.
        sun: colour and strength of the direct light.
        sky: of the light from above.
        bounce: of the light from below.
        haze: colour of distant air.
        haze_m: distance in metres over which haze takes 63 %.
        zenith: colour of the sky overhead.
        sun_radius: apparent radius of what the direct light comes from, in radians.
        exposure: by which the camera multiplies what it sees.
    """

    sun_direction: Points
    sun: Points
    sky: Points
    bounce: Points
    haze: Points
    haze_m: float
    zenith: Points
    sun_radius: float
    exposure: float

    @property
    def shadow(self) -> float:
        """How long the longest shadow on level ground is, as a multiple of the height of what casts it."""
        x, y, z = self.sun_direction
        return float((np.hypot(x, y) + self.sun_radius) / (z - self.sun_radius))


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


def light(time: str, weather: str) -> Light:
    """Return the light at a time of day in some weather.

    Raises:
        InvalidInputError: the time is not in `TIMES` or the weather not in `WEATHERS`.
    """
    if time not in _SUNS:
        raise InvalidInputError(f"A time of day must be one of {', '.join(TIMES)}, got {time!r}.")
    if weather not in _AIR:
        raise InvalidInputError(f"A weather must be one of {', '.join(WEATHERS)}, got {weather!r}.")
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
