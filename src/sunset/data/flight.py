"""The flight: one smooth course over a town, and the frames seen on it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from sunset.data.camera import Pose
from sunset.data.frame import FRAME_SIZE, Frame, Points
from sunset.data.layout import Street, TownPlan, check_town
from sunset.data.light import light
from sunset.data.renderer import View, render
from sunset.data.town import build_town
from sunset.data.views import is_free
from sunset.errors import InvalidInputError
from sunset.flights import FlightSpec
from sunset.seeding import check_seed

SAMPLES: Final = 4001
ROOFS_M: Final = 45.0
"""From this height on, a flight is clear of every roof."""
LENGTH_M: Final = 1200.0
"""How long a flight may be; the hills around a town begin further out."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightPlan:
    """A flight along a winding course across a town, at constant speed and height.

    The course follows a straight line through the town's centre and swings to both sides of it. A flight below
    45 m follows a street instead: of those that run in the line's direction, the nearest one above which
    nothing is in the way.

    Attributes:
        town: its number, 1 to 8.
        frames: how many are taken, at least 1.
        rate_hz: frames a second.
        speed: in metres a second.
        height: in metres, in [20, 300], above the town's centre, or above the street that is followed.
        pitch_deg: of the camera below the horizon in degrees, in [0, 90].
        course_deg: direction of the course's straight line in degrees, anticlockwise from east.
        offset: of the line to the left of the town's centre in metres.
        swing: of the course to either side of the line in metres; a street has its own.
        wave: length of one swing in metres.
        time: time of day, one of `TIMES`.
        weather: one of `WEATHERS`.
        seed: of the sensor's noise.
        size: height H and width W of a frame in pixels.

    Raises:
        InvalidInputError: a value is out of its range.
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
        check_town(self.town)
        check_seed(self.seed)
        light(self.time, self.weather)
        for name, low, high in (
            ("frames", 1, 100_000),
            ("rate_hz", 0.1, 1000),
            ("speed", 0, 100),
            ("height", 20, 300),
            ("pitch_deg", 0, 90),
            ("wave", 50, 2000),
            ("swing", 0, 200),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise InvalidInputError(f"A flight's {name} must be from {low} to {high}, got {value!r}.")
        if self.length > LENGTH_M:
            raise InvalidInputError(
                f"A flight must be at most {LENGTH_M:g} m long, got {self.frames} frames over {self.length:g} m."
            )

    @classmethod
    def of(cls, spec: FlightSpec, frames: int) -> "FlightPlan":
        """Return the plan of a flight that is rendered, of so many frames; everything else is as in the default one.

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

    @property
    def length(self) -> float:
        """How far it flies, in metres."""
        return self.speed * self.frames / self.rate_hz

    def poses(self) -> list[Pose]:
        """Return the camera's pose at every frame.

        Raises:
            InvalidInputError: something is in the way above every street in the flight's direction.
        """
        if self.height < ROOFS_M:
            return self._above_a_street()
        along = np.linspace(-self.length, self.length, SAMPLES)
        across = self.offset + self.swing * np.sin(2 * np.pi * along / self.wave)
        angle = np.radians(self.course_deg)
        x = along * np.cos(angle) - across * np.sin(angle)
        y = along * np.sin(angle) + across * np.cos(angle)
        slope = np.arctan(self.swing * 2 * np.pi / self.wave * np.cos(2 * np.pi * along / self.wave))
        return self._evenly(x, y, np.full(SAMPLES, self.height), angle, slope)

    def _evenly(self, x: Points, y: Points, z: Points, angle: float, turn: Points) -> list[Pose]:
        """Return the poses of the frames, evenly spaced in the middle of a course.

        The course is given by as many points, all in metres, and directions `angle + turn` in radians.
        """
        travelled = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
        middle = travelled[-1] / 2
        at = middle + self.speed * (np.arange(self.frames) / self.rate_hz) - self.length / 2
        columns = (np.interp(at, travelled, values) for values in (x, y, z, turn))
        pitch = float(np.radians(self.pitch_deg))
        return [
            Pose(float(px), float(py), float(pz), float(angle + change), pitch)
            for px, py, pz, change in zip(*columns, strict=True)
        ]

    def _above_a_street(self) -> list[Pose]:
        town = build_town(self.town)
        plan = town.plan
        for street, middle, sign in self._streets(plan):
            along = middle + sign * np.linspace(-self.length, self.length, SAMPLES)
            grid = street.points(along)
            x, y = plan.warp.points(grid).T
            heading = np.unwrap(plan.warp.headings(grid, street.axis))
            poses = self._evenly(
                x, y, self.height + plan.relief.streets(grid), 0.0 if sign > 0 else np.pi, heading
            )
            if all(is_free(town, pose) for pose in poses):
                return poses
        raise InvalidInputError(
            f"No street of town {self.town} in the direction of {self.course_deg:g} degrees is free at "
            f"{self.height:g} m for {self.length:g} m: choose another height, direction or number of frames."
        )

    def _streets(self, plan: TownPlan) -> list[tuple[Street, float, int]]:
        """Return the streets in the course's direction, the nearest first.

        With each come the position along it that is nearest to the middle of the course, and whether the
        course follows it forwards (1) or backwards (-1).
        """
        angle = np.radians(self.course_deg)
        middle = self.offset * np.array([-np.sin(angle), np.cos(angle)])
        along = np.arange(-300.0, 300.0)
        found = []
        for street in filter(plan.through, plan.streets):
            grid = street.points(along)
            distance = np.hypot(*(plan.warp.points(grid) - middle).T)
            nearest = int(distance.argmin())
            same = np.cos(plan.warp.headings(grid[nearest], street.axis) - angle)
            if abs(same) > np.sqrt(0.5):
                found.append((float(distance[nearest]), street, float(along[nearest]), 1 if same > 0 else -1))
        return [entry[1:] for entry in sorted(found, key=lambda entry: entry[0])]

    def stamps_ns(self) -> list[int]:
        """Return the frames' times in nanoseconds, the first at one period."""
        return [round((index + 1) * 1e9 / self.rate_hz) for index in range(self.frames)]


DEFAULT_FLIGHT: Final = FlightPlan()
"""The flight that experiments use: 40 s at 10 Hz over town 1, 50 m high, looking 60° down."""


LONGEST: Final = int(LENGTH_M / DEFAULT_FLIGHT.speed * DEFAULT_FLIGHT.rate_hz)
"""So many frames a flight can have at the default flight's speed and rate."""
_STEP: Final = 100


def frames_for(needed: int) -> int:
    """Return how many frames are rendered where an experiment needs so many.

    They are as many as the default flight has, unless more are needed. Then there are at least 100 more than are
    needed, as far as the flight can be that long, so that every seed can begin at another frame.

    >>> frames_for(260), frames_for(410), frames_for(1260), frames_for(5000)
    (400, 600, 1333, 1333)
    """
    if needed <= DEFAULT_FLIGHT.frames:
        return DEFAULT_FLIGHT.frames
    return min(-(-(needed + _STEP) // _STEP) * _STEP, LONGEST)


def render_frames(plan: FlightPlan, indices: Sequence[int] | None = None) -> Iterator[Frame]:
    """Yield the frames of a flight, those of `indices` in [0, plan.frames) if given; the same plan, the same bytes."""
    town = build_town(plan.town)
    poses = plan.poses()
    for index in range(plan.frames) if indices is None else indices:
        seed = (plan.seed * 1_000_003 + index) % 2**32
        view = View(poses[index], index / plan.rate_hz, seed, plan.time, plan.weather)
        yield render(town, view, size=plan.size)
