"""Flights that SUNSET renders: their plans, and frames of the town with errors of SUNSET."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Final, ParamSpec

import sunset_town as town
from sunset.errors import InvalidInputError, MissingExtraError
from sunset.flights import FlightSpec
from sunset_town import LENGTH_M, Flight, Frame, MissingEmbreeError, TownError

P = ParamSpec("P")


@contextmanager
def _town_errors() -> Iterator[None]:
    """Turn the town's errors into SUNSET's."""
    try:
        yield
    except MissingEmbreeError as error:
        raise MissingExtraError(
            "Rendering a flight needs embreex, which is not installed and has no wheels for some platforms: fly a bag "
            "(--bag, 'sunset data import'), or copy the cache folder (~/.cache/sunset, or SUNSET_CACHE_DIR) of a "
            "computer that has rendered the flight."
        ) from error
    except TownError as error:
        raise InvalidInputError(str(error)) from error


def _translated(render: Callable[P, Iterator[Frame]]) -> Callable[P, Iterator[Frame]]:
    @wraps(render)
    def frames(*args: P.args, **kwargs: P.kwargs) -> Iterator[Frame]:
        with _town_errors():
            yield from render(*args, **kwargs)

    return frames


render_frames = _translated(town.render_frames)
render_views = _translated(town.render_views)


class FlightPlan(Flight):
    """The plan of a flight that SUNSET renders, with the arguments of `sunset_town.Flight`.

    Raises:
        InvalidInputError: a value is out of its range.
    """

    __slots__ = ()

    def __post_init__(self) -> None:
        with _town_errors():
            super().__post_init__()

    @classmethod
    def of(cls, spec: FlightSpec, frames: int) -> "FlightPlan":
        """Return the plan of a rendered flight of so many frames; everything else is as in the default flight.

        Raises:
            InvalidInputError: the flight would be too long.
        """
        return cls(
            town=spec.town,
            frames=frames,
            height=spec.height,
            pitch_deg=spec.angle,
            time=spec.time,
            weather=spec.weather,
            seed=spec.seed,
        )


DEFAULT_FLIGHT: Final = FlightPlan()
"""The flight that experiments use: 40 s at 10 Hz over town 1, 50 m high, looking 60° down."""

LONGEST: Final = int(LENGTH_M / DEFAULT_FLIGHT.speed * DEFAULT_FLIGHT.rate_hz)
"""The greatest number of frames of a flight at the default flight's speed and rate."""
_STEP: Final = 100


def frames_for(needed: int) -> int:
    """Return the number of frames to render for an experiment that needs so many.

    It is the default flight's number, unless more frames are needed. Then there are at least 100 more than
    needed, as far as the flight can be that long, so that every seed can begin at another frame.

    >>> frames_for(260), frames_for(410), frames_for(1260), frames_for(5000)
    (400, 600, 1333, 1333)
    """
    if needed <= DEFAULT_FLIGHT.frames:
        return DEFAULT_FLIGHT.frames
    return min(-(-(needed + _STEP) // _STEP) * _STEP, LONGEST)
