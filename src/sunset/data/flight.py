"""The flight: one smooth course over a town, and the frames seen on it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from sunset.data.camera import Pose
from sunset.data.frame import FRAME_SIZE, Frame
from sunset.data.layout import check_town
from sunset.data.light import light
from sunset.data.renderer import View, render
from sunset.data.town import build_town
from sunset.errors import InvalidInputError
from sunset.seeding import check_seed

__all__ = ["DEFAULT_FLIGHT", "FlightPlan", "render_frames"]

SAMPLES: Final = 4001


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightPlan:
    """A flight along a winding course across a town, at constant speed and height.

    The course follows a straight line through the town's centre and swings to both sides of it.

    Attributes:
        town: its number, 1 to 8.
        frames: how many are taken, at least 1.
        rate_hz: frames a second.
        speed: in metres a second.
        height: above the ground in metres, in [45, 300], clear of every roof.
        pitch_deg: of the camera below the horizon in degrees, in [0, 90].
        course_deg: direction of the course's straight line in degrees, anticlockwise from east.
        offset: of the line to the left of the town's centre in metres.
        swing: of the course to either side of the line in metres.
        wave: length of one swing in metres.
        time: time of day, one of `TIMES`.
        weather: one of `WEATHERS`.
        seed: of the sensor's noise.
        size: height H and width W of a frame in pixels.
    """

    town: int = 1
    frames: int = 400
    rate_hz: float = 10.0
    speed: float = 9.0
    height: float = 50.0
    pitch_deg: float = 60.0
    course_deg: float = 50.0
    offset: float = 40.0
    swing: float = 30.0
    wave: float = 210.0
    time: str = "noon"
    weather: str = "clear"
    seed: int = 0
    size: tuple[int, int] = FRAME_SIZE

    def __post_init__(self) -> None:
        """Check every value.

        Raises:
            InvalidInputError: one is out of its range.
        """
        check_town(self.town)
        check_seed(self.seed)
        light(self.time, self.weather)
        for name, low, high in (
            ("frames", 1, 100_000),
            ("rate_hz", 0.1, 1000),
            ("speed", 0, 100),
            ("height", 45, 300),
            ("pitch_deg", 0, 90),
            ("wave", 50, 2000),
            ("swing", 0, 200),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise InvalidInputError(f"A flight's {name} must be from {low} to {high}, got {value!r}.")

    def poses(self) -> list[Pose]:
        """Return the camera's pose at every frame."""
        length = self.speed * self.frames / self.rate_hz
        along = np.linspace(-length, length, SAMPLES)
        across = self.offset + self.swing * np.sin(2 * np.pi * along / self.wave)
        angle = np.radians(self.course_deg)
        x = along * np.cos(angle) - across * np.sin(angle)
        y = along * np.sin(angle) + across * np.cos(angle)
        travelled = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
        slope = np.arctan(self.swing * 2 * np.pi / self.wave * np.cos(2 * np.pi * along / self.wave))
        middle = travelled[-1] / 2
        at = middle + self.speed * (np.arange(self.frames) / self.rate_hz) - length / 2
        columns = (np.interp(at, travelled, values) for values in (x, y, slope))
        return [
            Pose(float(px), float(py), self.height, float(angle + turn), float(np.radians(self.pitch_deg)))
            for px, py, turn in zip(*columns, strict=True)
        ]

    def stamps_ns(self) -> list[int]:
        """Return the frames' times in nanoseconds, the first at one period."""
        return [round((index + 1) * 1e9 / self.rate_hz) for index in range(self.frames)]


DEFAULT_FLIGHT: Final = FlightPlan()
"""The flight that experiments use: 40 s at 10 Hz over town 1, 50 m high, looking 60° down."""


def render_frames(plan: FlightPlan, indices: Sequence[int] | None = None) -> Iterator[Frame]:
    """Yield the frames of a flight; the same plan gives the same bytes.

    Args:
        plan: of the flight.
        indices: which frames, all of them if not given; each in [0, plan.frames).
    """
    town = build_town(plan.town)
    poses = plan.poses()
    for index in range(plan.frames) if indices is None else indices:
        seed = (plan.seed * 1_000_003 + index) % 2**32
        view = View(poses[index], index / plan.rate_hz, seed, plan.time, plan.weather)
        yield render(town, view, size=plan.size)
