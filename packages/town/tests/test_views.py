from itertools import islice

import numpy as np
import pytest

from sunset_town import CARLA_IDS, TIMES, WEATHERS, TownError, render_views, training_views
from sunset_town.town import build_town

pytestmark = pytest.mark.xdist_group("towns")  # each is built once

SMALL = (72, 128)


@pytest.mark.thorough
def test_every_class_is_seen_from_training_views() -> None:
    seen = {int(label) for frame in render_views(1, 60, 0, size=SMALL) for label in np.unique(frame.labels)}
    assert seen == set(CARLA_IDS.values())


def test_a_range_of_views_can_be_split() -> None:
    whole = list(training_views(1, 6, 9))
    parts = [*training_views(1, 2, 9), *training_views(1, 4, 9, start=2)]
    assert whole == parts
    assert whole != list(training_views(1, 6, 10))


def test_views_keep_to_the_choices_given() -> None:
    views = list(training_views(1, 25, 1, heights=(50,), pitches=(60,), times=("noon",), weathers=("hazy",)))
    assert all(45 <= view.pose.z <= 55 for view in views)
    assert all(57 <= np.degrees(view.pose.pitch) <= 63 for view in views)
    assert {(view.time, view.weather) for view in views} == {("noon", "hazy")}


def test_views_use_every_time_and_weather() -> None:
    views = list(training_views(1, 60, 2))
    assert {view.time for view in views} == set(TIMES)
    assert {view.weather for view in views} == set(WEATHERS)


def test_nothing_is_close_to_the_camera() -> None:
    for frame in render_views(1, 15, 3, heights=(20,), size=SMALL):
        assert frame.depth.min() > 3 / 1000 * 65535


def test_views_come_one_by_one() -> None:
    assert len(list(islice(training_views(1, 10**9, 0), 3))) == 3


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": -1}, "seed must be"),
        ({"count": -1}, "counted from 0"),
        ({"start": -1}, "counted from 0"),
        ({"heights": ()}, "heights must be"),
        ({"heights": (2,)}, "heights must be"),
        ({"pitches": (95,)}, "pitches must be"),
        ({"times": ()}, "at least one time"),
        ({"town": 12}, "town must be"),
    ],
)
def test_bad_choices_are_refused(change: dict[str, object], message: str) -> None:
    arguments: dict[str, object] = {"town": 1, "count": 1, "seed": 0, **change}
    with pytest.raises(TownError, match=message):
        list(training_views(**arguments))  # type: ignore[arg-type]


def test_a_height_below_the_roofs_everywhere_is_refused_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sunset_town.flight.CLEARANCE_M", 1e9)
    build_town(1)
    with pytest.raises(TownError, match="No free air was found at a height of 20"):
        list(training_views(1, 1, 0, heights=(20,)))
