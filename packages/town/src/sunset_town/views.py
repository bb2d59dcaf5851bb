"""Views for training: random poses, moments and light in a town."""

from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from sunset_town.camera import Pose
from sunset_town.errors import TownError
from sunset_town.frame import FRAME_SIZE, Frame
from sunset_town.light import TIMES, WEATHERS
from sunset_town.renderer import View, render
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
