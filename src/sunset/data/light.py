"""Sun, sky and air at a time of day in some weather."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from sunset.errors import InvalidInputError

__all__ = ["TIMES", "WEATHERS", "Light", "light"]

TIMES: Final = ("morning", "noon", "evening")
"""The times of day."""
WEATHERS: Final = ("clear", "hazy", "overcast")
"""The kinds of weather."""

Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Light:
    """What lights a town; colours are linear red, green, blue.

    Attributes:
        sun_direction: unit vector towards the sun.
        sun: colour and strength of the direct light.
        sky: of the light from above.
        bounce: of the light from below.
        haze: colour of distant air.
        haze_m: distance in metres over which haze takes 63 %.
        zenith: colour of the sky overhead.
        sun_radius: apparent radius of what the direct light comes from, in radians.
    """

    sun_direction: Triple
    sun: Triple
    sky: Triple
    bounce: Triple
    haze: Triple
    haze_m: float
    zenith: Triple
    sun_radius: float


_SUNS: Final = {  # elevation and azimuth in degrees, colour
    "morning": (34.0, 20.0, (1.12, 0.95, 0.74)),
    "noon": (58.0, 250.0, (1.1, 1.04, 0.95)),
    "evening": (24.0, 160.0, (1.15, 0.82, 0.55)),
}
_AIR: Final = {  # share of direct sun, strength of sky light, haze distance, sun's radius
    "clear": (1.0, 1.0, 1400.0, 0.012),
    "hazy": (0.75, 1.15, 420.0, 0.03),
    "overcast": (0.18, 1.75, 900.0, 0.12),
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
    share, diffuse, distance, radius = _AIR[weather]
    e, a = np.radians(elevation), np.radians(azimuth)
    grey = np.array([0.62, 0.66, 0.7])
    clear = np.array([0.42, 0.55, 0.76])
    tone = clear if weather == "clear" else grey
    sky = tone * 0.46 * diffuse * (0.8 + 0.2 * np.sin(e))
    haze = (0.55 * np.asarray(colour) * 0.7 + 0.45 * tone) * (0.62 + 0.25 * np.sin(e))
    return Light(
        sun_direction=(float(np.cos(e) * np.cos(a)), float(np.cos(e) * np.sin(a)), float(np.sin(e))),
        sun=_triple(np.asarray(colour) * share * (0.75 + 0.25 * np.sin(e))),
        sky=_triple(sky),
        bounce=_triple(np.array([0.11, 0.1, 0.08]) * (share + 0.4)),
        haze=_triple(haze),
        haze_m=distance,
        zenith=_triple(tone * 0.6),
        sun_radius=radius,
    )


def _triple(values: np.ndarray) -> Triple:
    red, green, blue = (float(value) for value in values)
    return red, green, blue
