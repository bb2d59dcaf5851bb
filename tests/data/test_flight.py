import numpy as np
import pytest

from sunset.data import DEFAULT_FLIGHT, FlightPlan, render_frames
from sunset.data.town import build_town
from sunset.data.views import _is_free
from sunset.errors import InvalidInputError


def test_the_default_flight_is_forty_seconds_at_ten_hertz() -> None:
    stamps = DEFAULT_FLIGHT.stamps_ns()
    assert len(stamps) == 400
    assert set(np.diff(stamps).tolist()) == {100_000_000}
    assert DEFAULT_FLIGHT.size == (144, 256)
    assert DEFAULT_FLIGHT.town == 1


def test_the_flight_is_smooth_and_keeps_its_speed() -> None:
    poses = DEFAULT_FLIGHT.poses()
    points = np.array([(pose.x, pose.y) for pose in poses])
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=0), axis=1), 0.9, rtol=0.01)
    turns = np.degrees(np.diff([pose.heading for pose in poses])) * 10
    assert np.abs(turns).max() < 20
    assert np.abs(points).max() < 230


def test_the_camera_looks_where_it_flies() -> None:
    poses = DEFAULT_FLIGHT.poses()
    points = np.array([(pose.x, pose.y) for pose in poses])
    course = np.arctan2(*np.diff(points, axis=0).T[::-1])
    np.testing.assert_allclose(course, [pose.heading for pose in poses][:-1], atol=0.03)


def test_no_building_is_in_the_way() -> None:
    town = build_town(1)
    assert all(_is_free(town, pose) for pose in DEFAULT_FLIGHT.poses()[::10])


def test_every_frame_has_noise_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sunset.data.flight.render", lambda _, view, **__: view.seed)
    seeds = {number for seed in (0, 1) for number in render_frames(FlightPlan(seed=seed))}
    assert len(seeds) == 2 * DEFAULT_FLIGHT.frames


def test_chosen_frames_equal_those_of_the_whole_flight() -> None:
    plan = FlightPlan(frames=4, size=(36, 64))
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
        ({"height": 20}, "height must be from 45"),
        ({"pitch_deg": 91}, "pitch_deg must be"),
        ({"speed": float("nan")}, "speed must be"),
        ({"time": "night"}, "time of day"),
        ({"town": 0}, "town must be"),
        ({"seed": 1.5}, "seed must be"),
    ],
)
def test_a_bad_plan_is_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        FlightPlan(**change)  # type: ignore[arg-type]
