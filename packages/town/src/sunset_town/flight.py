"""Cameras in the air: flights over a town at constant speed and height, and random views for training."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from sunset_town.errors import TownError
from sunset_town.frame import FRAME_SIZE, Frame, Points
from sunset_town.layout import Street, TownPlan, check_town
from sunset_town.light import TIMES, WEATHERS, light
from sunset_town.renderer import Pose, View, render
from sunset_town.seeding import check_seed, generator
from sunset_town.town import Town, build_town

HEIGHTS_M: Final = (20.0, 50.0, 80.0)
"""SynDrone's flight heights in metres."""
PITCHES_DEG: Final = (30.0, 60.0, 90.0)
"""SynDrone's camera angles below the horizon in degrees."""

REACH_M: Final = 200.0
CLEARANCE_M: Final = 8.0


def training_views(
    town: int,
    count: int,
    seed: int,
    *,
    heights: Sequence[float] = HEIGHTS_M,
    pitches: Sequence[float] = PITCHES_DEG,
    times: Sequence[str] = TIMES,
    weathers: Sequence[str] = WEATHERS,
    start: int = 0,
) -> Iterator[View]:
    """Yield views of a town at random places, in random directions, moments and light.

    Height and pitch are drawn from the given values and jittered, by up to 10 % and 3°. The view of an index
    depends only on the town, the seed, the index and the choices, so that processes can share a range.

    Args:
        town: its number, 1 to 8.
        count: number of views.
        seed: a whole number in [0, 2**32 - 1].
        heights: above the ground in metres, in [5, 300].
        pitches: below the horizon in degrees, in [0, 90].
        times: times of day, of `TIMES`.
        weathers: of `WEATHERS`.
        start: index of the first view.

    Raises:
        TownError: an argument is out of its range.
    """
    check_seed(seed)
    _check_choices(count, start, heights, pitches)
    if not times or not weathers:
        raise TownError("Views need at least one time of day and one weather, got none.")
    built = build_town(town)
    for index in range(start, start + count):
        rng = generator(seed, "view", town, index)
        pose = _pose(built, rng, float(rng.choice(heights)), float(rng.choice(pitches)))
        moment, noise = rng.uniform(0, 300), int(rng.integers(2**32))
        yield View(pose, moment, noise, str(rng.choice(list(times))), str(rng.choice(list(weathers))))


def _check_choices(count: int, start: int, heights: Sequence[float], pitches: Sequence[float]) -> None:
    if count < 0 or start < 0:
        raise TownError(f"Views are counted from 0, got a count of {count} and a start of {start}.")
    for name, values, low, high in (("heights", heights, 5, 300), ("pitches", pitches, 0, 90)):
        if not values or not all(low <= value <= high for value in values):
            raise TownError(f"The {name} must be some values from {low} to {high}, got {tuple(values)}.")


def _pose(town: Town, rng: np.random.Generator, height: float, pitch: float) -> Pose:
    """Draw poses until a pose has free air around it and below it."""
    for _ in range(200):
        x, y = rng.uniform(-REACH_M, REACH_M, 2)
        tilt = float(np.radians(np.clip(pitch + rng.uniform(-3, 3), 0, 90)))
        z, heading, roll = height * rng.uniform(0.9, 1.1), rng.uniform(0, 2 * np.pi), rng.normal(0, 0.015)
        pose = Pose(float(x), float(y), z, heading, tilt, roll)
        if is_free(town, pose):
            return pose
    raise TownError(f"No free air was found at a height of {height} m: choose a greater one.")


def is_free(town: Town, pose: Pose) -> bool:
    """Return whether nothing that stands still is near a camera, around it or in its view."""
    grid = np.linspace(-1, 1, 5)
    axes = pose.axes()
    ahead = axes[2] + grid[:, None, None] * axes[0] + 0.57 * grid[None, :, None] * axes[1]
    around = np.array([(0, 0, -1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)])
    directions = np.concatenate([ahead.reshape(-1, 3), around]).astype(np.float32)
    origins = np.tile(np.array([pose.x, pose.y, pose.z], dtype=np.float32), (len(directions), 1))
    distances, _ = town.solid.meet(origins, directions)
    return bool((distances > CLEARANCE_M).all())


def render_views(
    town: int, count: int, seed: int, *, size: tuple[int, int] = FRAME_SIZE, **choices: Any
) -> Iterator[Frame]:
    """Yield the frames of `training_views`, in pixels of `size`; the same arguments give the same bytes.

    The other arguments are the keyword arguments of `training_views`.
    """
    for view in training_views(town, count, seed, **choices):
        yield render(build_town(town), view, size=size)


SAMPLES: Final = 4001
ROOFS_M: Final = 45.0
"""From this height on, a flight is clear of every roof."""
LENGTH_M: Final = 1200.0
"""The greatest length of a flight; the hills around a town begin further out."""
_RANGES: Final = {
    "frames": (1, 100_000),
    "rate_hz": (0.1, 1000),
    "speed": (0, 100),
    "height": (20, 300),
    "pitch_deg": (0, 90),
    "wave": (50, 2000),
    "swing": (0, 200),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """A flight along a winding course across a town, at constant speed and height.

    The course follows a straight line through the town's centre and swings to both sides of it. A flight below
    45 m follows a street instead: the nearest street in the line's direction above which nothing is in the way.

    Raises:
        TownError: a value is out of its range.
    """

    town: int = 1  #: its number, 1 to 8
    frames: int = 400  #: number of frames, at least 1
    rate_hz: float = 10.0  #: frames a second
    speed: float = 9.0  #: in metres a second
    height: float = 50.0  #: in metres, in [20, 300], above the town's centre or the street that is followed
    pitch_deg: float = 60.0  #: of the camera below the horizon in degrees, in [0, 90]
    course_deg: float = 50.0  #: direction of the course's straight line in degrees, anticlockwise from east
    offset: float = 40.0  #: of the line to the left of the town's centre in metres
    swing: float = 30.0  #: of the course to either side of the line in metres; a street has its own
    wave: float = 210.0  #: length of a swing in metres
    time: str = "noon"  #: time of day, one of `TIMES`
    weather: str = "clear"  #: one of `WEATHERS`
    seed: int = 0  #: of the sensor's noise
    size: tuple[int, int] = FRAME_SIZE  #: height H and width W of a frame in pixels

    def __post_init__(self) -> None:
        check_town(self.town)
        check_seed(self.seed)
        light(self.time, self.weather)
        for name, (low, high) in _RANGES.items():
            if not low <= (value := getattr(self, name)) <= high:
                raise TownError(f"A flight's {name} must be from {low} to {high}, got {value!r}.")
        if self.length > LENGTH_M:
            raise TownError(
                f"A flight must be at most {LENGTH_M:g} m long, got {self.frames} frames over {self.length:g} m."
            )

    @property
    def length(self) -> float:
        """The length of the course in metres."""
        return self.speed * self.frames / self.rate_hz

    def stamps_ns(self) -> list[int]:
        """Return the frames' times in nanoseconds, the first at a period."""
        return [round((index + 1) * 1e9 / self.rate_hz) for index in range(self.frames)]

    def poses(self) -> list[Pose]:
        """Return the camera's pose at every frame.

        Raises:
            TownError: something is in the way above every street in the flight's direction.
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
        """Return poses evenly spaced in the middle of a course of points in metres and headings `angle + turn`."""
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
            height = self.height + plan.relief.streets(grid)
            poses = self._evenly(x, y, height, 0.0 if sign > 0 else np.pi, heading)
            if all(is_free(town, pose) for pose in poses):
                return poses
        raise TownError(
            f"No street of town {self.town} in the direction of {self.course_deg:g} degrees is free at "
            f"{self.height:g} m for {self.length:g} m: choose another height, direction or number of frames."
        )

    def _streets(self, plan: TownPlan) -> list[tuple[Street, float, int]]:
        """Return the streets in the course's direction, the nearest first.

        With each come the position along it nearest to the middle of the course, and 1 if the course follows it
        forwards, -1 if backwards.
        """
        angle = np.radians(self.course_deg)
        middle = self.offset * np.array([-np.sin(angle), np.cos(angle)])
        along = np.arange(-300.0, 300.0)
        streets = []
        for street in filter(plan.through, plan.streets):
            grid = street.points(along)
            distance = np.hypot(*(plan.warp.points(grid) - middle).T)
            nearest = int(distance.argmin())
            same = np.cos(plan.warp.headings(grid[nearest], street.axis) - angle)
            if abs(same) > np.sqrt(0.5):
                streets.append(
                    (float(distance[nearest]), street, float(along[nearest]), 1 if same > 0 else -1)
                )
        return [entry[1:] for entry in sorted(streets, key=lambda entry: entry[0])]


def render_frames(flight: Flight, indices: Sequence[int] | None = None) -> Iterator[Frame]:
    """Yield a flight's frames, or those of `indices` in [0, flight.frames); the same flight gives the same bytes.

    Raises:
        TownError: a flight below the roofs has no free street.
        MissingEmbreeError: embreex is not installed.
    """
    town = build_town(flight.town)
    poses = flight.poses()
    for index in range(flight.frames) if indices is None else indices:
        seed = (flight.seed * 1_000_003 + index) % 2**32
        view = View(poses[index], index / flight.rate_hz, seed, flight.time, flight.weather)
        yield render(town, view, size=flight.size)
