import numpy as np
import pytest

from sunset_town import CARLA_IDS, Flight, TownError, render_frames
from sunset_town.flight import is_free
from sunset_town.town import build_town

pytestmark = pytest.mark.xdist_group("towns")  # each is built once

DEFAULT = Flight()


def test_the_default_flight_is_forty_seconds_at_ten_hertz() -> None:
    stamps = DEFAULT.stamps_ns()
    assert len(stamps) == 400
    assert set(np.diff(stamps).tolist()) == {100_000_000}
    assert DEFAULT.size == (144, 256)
    assert DEFAULT.town == 1


def test_the_flight_is_smooth_and_keeps_its_speed() -> None:
    poses = DEFAULT.poses()
    points = np.array([(pose.x, pose.y) for pose in poses])
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=0), axis=1), 0.9, rtol=0.01)
    turns = np.degrees(np.diff([pose.heading for pose in poses])) * 10
    assert np.abs(turns).max() < 20
    assert np.abs(points).max() < 230


def test_the_camera_looks_where_it_flies() -> None:
    poses = DEFAULT.poses()
    points = np.array([(pose.x, pose.y) for pose in poses])
    course = np.arctan2(*np.diff(points, axis=0).T[::-1])
    np.testing.assert_allclose(course, [pose.heading for pose in poses][:-1], atol=0.03)


def test_no_building_is_in_the_way() -> None:
    town = build_town(1)
    assert all(is_free(town, pose) for pose in DEFAULT.poses()[::10])


def test_the_poses_of_the_default_flight_do_not_change() -> None:
    first, last = DEFAULT.poses()[0], DEFAULT.poses()[-1]
    assert (first.x, first.y, first.z) == pytest.approx((-150.982736, -71.674365, 50.0), abs=1e-5)
    assert (last.x, last.y, last.heading) == pytest.approx((89.019036, 122.507996, 0.702621), abs=1e-5)


@pytest.mark.parametrize("course", [0.0, 120.0, 210.0])
def test_a_low_flight_follows_a_street_in_its_direction(course: float) -> None:
    plan = Flight(height=20, course_deg=course, frames=200)
    town, poses = build_town(1), plan.poses()
    assert all(is_free(town, pose) for pose in poses)
    points = np.array([(pose.x, pose.y, pose.z) for pose in poses])
    distances, _ = town.solid.meet(
        points.astype(np.float32), np.tile([[0, 0, -1]], (200, 1)).astype(np.float32)
    )
    # the street, but for a bridge, a lamp or a tree here and there
    assert np.median(distances) == pytest.approx(20, abs=0.1)
    np.testing.assert_allclose(np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1), 0.9, rtol=0.01)
    way = points[-1] - points[0]
    assert np.cos(np.arctan2(way[1], way[0]) - np.radians(course)) > 0.6
    along = np.arctan2(*np.diff(points[:, :2], axis=0).T[::-1])
    headings = np.array([pose.heading for pose in poses][:-1])
    np.testing.assert_allclose(np.cos(along - headings), 1, atol=1e-3)


def test_a_street_is_what_a_low_flight_sees() -> None:
    plan = Flight(height=20, pitch_deg=90, frames=50, size=(36, 64))
    streets = [CARLA_IDS[name] for name in ("road", "road line", "sidewalk", "car", "truck", "bus")]
    middles = [frame.labels[15:21, 28:36] for frame in render_frames(plan, [0, 20, 40])]
    assert np.isin(middles, streets).mean() > 0.8


def test_every_frame_has_noise_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sunset_town.flight.render", lambda _, view, **__: view.seed)
    seeds = {number for seed in (0, 1) for number in render_frames(Flight(seed=seed))}
    assert len(seeds) == 2 * DEFAULT.frames


def test_chosen_frames_equal_those_of_the_whole_flight() -> None:
    plan = Flight(frames=4, size=(36, 64))
    whole = list(render_frames(plan))
    chosen = list(render_frames(plan, [3, 1]))
    assert len(whole) == 4
    np.testing.assert_array_equal(chosen[0].rgb, whole[3].rgb)
    np.testing.assert_array_equal(chosen[1].rgb, whole[1].rgb)
    assert (whole[0].rgb != whole[1].rgb).any()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"frames": 0}, "frames must be from 1"),
        ({"height": 19.9}, "height must be from 20"),
        ({"frames": 1400}, "at most 1200 m long, got 1400 frames over 1260 m"),
        ({"pitch_deg": 91}, "pitch_deg must be"),
        ({"speed": float("nan")}, "speed must be"),
        ({"time": "night"}, "time of day"),
        ({"town": 0}, "town must be"),
        ({"seed": 1.5}, "seed must be"),
    ],
)
def test_a_bad_plan_is_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(TownError, match=message):
        Flight(**change)  # type: ignore[arg-type]
