import pytest

import sunset_town as town
from sunset import classes, flights
from sunset.data import DEFAULT_FLIGHT, FlightPlan, frames_for, render_frames, render_views
from sunset.errors import InvalidInputError, MissingExtraError
from sunset.flights import FlightSpec
from sunset_ros import seeding
from sunset_town.seeding import generator

pytestmark = pytest.mark.xdist_group("towns")  # each is built once


def test_the_default_flight_is_forty_seconds_at_ten_hertz_over_town_1() -> None:
    stamps = DEFAULT_FLIGHT.stamps_ns()
    assert (len(stamps), stamps[0], stamps[-1]) == (400, 100_000_000, 40_000_000_000)
    assert (DEFAULT_FLIGHT.town, DEFAULT_FLIGHT.size) == (1, (144, 256))


def test_scenarios_name_the_conditions_under_which_the_town_renders() -> None:
    assert flights.TOWNS == town.TOWNS
    assert set(flights.TIMES) == set(town.TIMES)
    assert set(flights.WEATHERS) == set(town.WEATHERS)


def test_labels_are_the_ids_of_the_classes() -> None:
    assert town.CARLA_IDS == classes.CARLA_IDS


def test_the_town_draws_the_same_numbers() -> None:
    ours, theirs = (draw(5, "sensor", 3).integers(2**32, size=4) for draw in (seeding.generator, generator))
    assert (ours == theirs).all()


def test_a_plan_has_the_conditions_of_its_specification() -> None:
    spec = FlightSpec(town=3, height=80, angle=90, time="evening", weather="hazy", seed=4)
    plan = FlightPlan.of(spec, 12)
    assert plan == FlightPlan(
        town=3, frames=12, height=80, pitch_deg=90, time="evening", weather="hazy", seed=4
    )
    assert frames_for(410) == 600


def test_mistakes_in_a_plan_and_in_views_are_errors_of_sunset(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InvalidInputError, match="town must be a whole number from 1 to 8, got 99"):
        FlightPlan(town=99)
    with pytest.raises(InvalidInputError, match="frames must be from 1"):
        FlightPlan.of(FlightSpec(), 0)
    with pytest.raises(InvalidInputError, match="heights must be"):
        next(render_views(1, 1, 0, heights=(2,)))
    monkeypatch.setattr("sunset_town.flight.is_free", lambda *_: False)
    with pytest.raises(InvalidInputError, match="No street of town 1"):
        next(render_frames(FlightPlan(height=20)))


def test_without_embreex_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sunset_town.town.EmbreeScene", None)
    town.build_town.cache_clear()
    with pytest.raises(MissingExtraError, match="fly a bag"):
        next(render_frames(DEFAULT_FLIGHT))
