import hashlib
import os
import subprocess
import sys

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from sunset_town import CARLA_IDS, Frame, render_views, renderer
from sunset_town.light import light
from sunset_town.renderer import Pose, View, rays, render
from sunset_town.town import Town, build_town

pytestmark = pytest.mark.xdist_group("towns")  # each is built once

SMALL = (72, 128)
GROUND = [CARLA_IDS[name] for name in ("road", "road line", "sidewalk", "water", "terrain", "ground")]
MOVING = ("car", "truck", "bus", "train", "motorcycle", "bicycle", "rider", "person")
PROBE = """
import hashlib
from sunset_town import render_views
digest = hashlib.sha256()
for frame in render_views(1, 3, 5, size=(72, 128)):
    for image in (frame.rgb, frame.depth, frame.labels):
        digest.update(image.tobytes())
print(digest.hexdigest())
"""


@pytest.fixture(scope="module")
def town() -> Town:
    return build_town(1)


def _view(pitch: float, *, height: float = 50.0, time_s: float = 0.0, **air: str) -> View:
    return View(Pose(20, -30, height, 0.4, np.radians(pitch)), time_s, 0, **air)


def _bytes(frame: Frame) -> bytes:
    return frame.rgb.tobytes() + frame.depth.tobytes() + frame.labels.tobytes()


def test_a_frame_has_the_documented_shapes_and_types(town: Town) -> None:
    frame = render(town, _view(60))
    assert frame.rgb.shape == (144, 256, 3)
    assert frame.depth.shape == frame.labels.shape == (144, 256)
    assert frame.rgb.dtype == frame.labels.dtype == np.uint8
    assert frame.depth.dtype == np.uint16
    assert frame.size == (144, 256)


def _heights_at(town: Town, x: float, y: float) -> npt.NDArray[np.float64]:
    """Return the heights of all of the terrain's triangles above or below a point."""
    corners = town.terrain.mesh.triangles.astype(np.float64)
    near = (np.abs(corners[:, 0, :2] - (x, y)) < 30).all(axis=1)
    a, b, c = (corners[near, corner] for corner in range(3))
    to_b, to_c, to_point = b - a, c - a, np.array((x, y)) - a[:, :2]
    area = to_b[:, 0] * to_c[:, 1] - to_b[:, 1] * to_c[:, 0]
    s = (to_point[:, 0] * to_c[:, 1] - to_point[:, 1] * to_c[:, 0]) / area
    t = (to_b[:, 0] * to_point[:, 1] - to_b[:, 1] * to_point[:, 0]) / area
    inside = (s >= -1e-3) & (t >= -1e-3) & (s + t <= 1 + 1e-3)
    heights: npt.NDArray[np.float64] = (a[:, 2] + s * to_b[:, 2] + t * to_c[:, 2])[inside]
    return heights


@pytest.mark.parametrize("pitch", [45, 90])
def test_depth_times_ray_lands_on_the_ground_where_it_is_seen(town: Town, pitch: int) -> None:
    view = _view(pitch)
    frame = render(town, view, size=SMALL)
    directions = rays(view.pose, SMALL)[: SMALL[0] * SMALL[1]].astype(np.float64)
    points = (20, -30, 50) + directions * (frame.depth.reshape(-1, 1) / 65.535)
    roads = np.flatnonzero(frame.labels.ravel() == CARLA_IDS["road"])
    assert len(roads) > 300
    for x, y, z in points[roads[::37]]:
        assert np.abs(_heights_at(town, x, y) - z).min() < 0.05


@pytest.mark.thorough
@pytest.mark.parametrize(("pitch", "height"), [(0, 3), (30, 20), (60, 50), (90, 80)])
@pytest.mark.parametrize("time", ["noon", "evening"])
def test_what_is_left_out_for_speed_would_not_be_seen(
    town: Town, monkeypatch: pytest.MonkeyPatch, pitch: int, height: float, time: str
) -> None:
    views = [_view(pitch, height=height, time_s=time_s, time=time) for time_s in (0.0, 20.0)]
    quick = [_bytes(render(town, view)) for view in views]
    monkeypatch.setattr(renderer, "SLACK", 1e6)
    assert [_bytes(render(town, view)) for view in views] == quick


def test_depth_goes_straight_down_below_the_camera(town: Town) -> None:
    frame = render(town, _view(90, height=62.5), size=(73, 129))
    ground = _heights_at(town, 20, -30).max()
    assert frame.labels[36, 64] in GROUND
    assert frame.depth[36, 64] == pytest.approx((62.5 - ground) / 1000 * 65535, abs=2)


def test_sky_is_above_the_horizon_and_out_of_range(town: Town) -> None:
    frame = render(town, _view(0), size=SMALL)
    sky = frame.labels == CARLA_IDS["sky"]
    assert sky[: SMALL[0] // 4].mean() > 0.8
    assert not sky[SMALL[0] // 2 + 5 :].any()
    assert (frame.depth[sky] == 65535).all()
    assert (frame.depth[~sky] < 65535).all()


def test_the_traffic_moves_and_the_town_does_not(town: Town) -> None:
    before, after = (render(town, _view(60, time_s=time), size=SMALL) for time in (0.0, 3.0))
    changed = before.labels != after.labels
    assert 0.005 < changed.mean() < 0.3
    moving = [CARLA_IDS[name] for name in MOVING]
    assert (np.isin(before.labels, moving) | np.isin(after.labels, moving))[changed].all()


def test_the_sun_casts_shadows_that_clouds_take_away(town: Town) -> None:
    ratios = []
    for weather in ("clear", "overcast"):
        view = _view(90, height=60.0, weather=weather)
        frame = render(town, view)
        directions = rays(view.pose, frame.size)[: frame.labels.size]
        points = directions * (frame.depth.reshape(-1, 1) / np.float32(65.535))
        points += np.array((20, -30, 60.1), dtype=np.float32)
        sun = np.tile(np.array(light("noon", weather).sun_direction, dtype=np.float32), (len(points), 1))
        hidden = town.solid.blocks(points.astype(np.float32), sun).reshape(frame.size)
        dark = cv2.erode(hidden.astype(np.uint8), np.ones((5, 5), np.uint8)).astype(bool)
        grass = frame.labels == CARLA_IDS["terrain"]
        assert (grass & dark).sum() > 100
        ratios.append(frame.rgb[grass & ~hidden].mean() / frame.rgb[grass & dark].mean())
    assert ratios[0] > 1.5
    assert 1.02 < ratios[1] < 1.25


def test_haze_hides_what_is_far(town: Town) -> None:
    spread = [
        render(town, _view(30, height=80.0, weather=weather), size=SMALL).rgb[8:20].std()
        for weather in ("clear", "hazy")
    ]
    assert spread[1] < 0.75 * spread[0]


def test_colours_come_blue_first(town: Town) -> None:
    frame = render(town, _view(60, time="evening"), size=SMALL)
    terrain = frame.rgb[frame.labels == CARLA_IDS["terrain"]].mean(axis=0)
    assert terrain[1] > terrain[0]
    assert terrain[2] > terrain[0]


def test_noise_depends_on_the_seed_alone(town: Town) -> None:
    one, same, other = (
        render(town, View(Pose(20, -30, 50, 0.4, 1.0), 0.0, seed), size=SMALL) for seed in (1, 1, 2)
    )
    assert _bytes(one) == _bytes(same)
    difference = one.rgb.astype(int) - other.rgb
    assert 1 < difference.std() < 4
    assert (one.labels == other.labels).all()
    assert (one.depth == other.depth).all()


@pytest.mark.thorough
def test_another_process_renders_the_same_bytes() -> None:
    digest = hashlib.sha256(b"".join(_bytes(frame) for frame in render_views(1, 3, 5, size=SMALL)))
    environment = {**os.environ, "PYTHONHASHSEED": "77"}
    answer = subprocess.run(
        [sys.executable, "-c", PROBE], capture_output=True, check=True, text=True, env=environment
    )
    assert answer.stdout.strip() == digest.hexdigest()
