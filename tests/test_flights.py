"""A flight is described by a bag or by conditions, and what cannot be is refused in one sentence."""

from pathlib import Path

import pytest

from sunset.data import HEIGHTS_M, PITCHES_DEG
from sunset.errors import InvalidInputError
from sunset.flights import HELD_OUT, KEYS, PANEL, TIMES, WEATHERS, FlightSpec, parse_flights
from sunset_lab.frames import TRAINING_TOWNS, VALIDATION_TOWN


def test_a_flight_without_conditions_is_the_default_one() -> None:
    assert FlightSpec.of({}) == FlightSpec()
    assert (FlightSpec().name, FlightSpec().conditions()) == ("default", {})


def test_what_describes_a_flight_describes_the_same_one_again() -> None:
    written = {"town": 8, "height": 50, "angle": 60, "time": "evening", "weather": "hazy", "seed": 3}
    spec = FlightSpec.of(written)
    assert spec == FlightSpec(town=8, time="evening", weather="hazy", seed=3)
    assert FlightSpec.of(spec.conditions()) == spec
    assert spec.name == "town8-50m-60deg-evening-hazy-seed3"
    bag = FlightSpec.of({"bag": "some/where.mcap"})
    assert (bag.bag, bag.name, bag.conditions()) == (
        Path("some/where.mcap"),
        "where",
        {"bag": "some/where.mcap"},
    )
    assert FlightSpec(bag=Path("x"), label="mine").name == "mine"


@pytest.mark.parametrize(
    ("conditions", "sentence"),
    [
        ({"town": 9}, "The flight's town must be a whole number from 1 to 8, got 9."),
        ({"town": 1.5}, "The flight's town must be a whole number from 1 to 8, got 1.5."),
        ({"town": True}, "The flight's town must be a whole number from 1 to 8, got True."),
        ({"height": 0}, "The flight's height [m] must be a number from 20 to 300, got 0."),
        ({"height": float("nan")}, "The flight's height [m] must be a number from 20 to 300, got nan."),
        ({"angle": 120}, "The flight's angle [degrees] must be a number from 0 to 90, got 120."),
        ({"angle": "steep"}, "The flight's angle [degrees] must be a number from 0 to 90, got 'steep'."),
        ({"time": "night"}, "The flight's time of day must be one of morning, noon, evening, got 'night'."),
        ({"weather": "rain"}, "The flight's weather must be one of clear, hazy, overcast, got 'rain'."),
        ({"seed": -1}, "A seed must be a whole number from 0 to 4294967295, got -1."),
        (
            {"hight": 20},
            "A flight has no 'hight': did you mean 'height', or name some of " + ", ".join(KEYS) + ".",
        ),
        ({"bag": ""}, "The bag of a flight must be a path, got ''."),
        ({"bag": 3}, "The bag must be a path, got 3."),
        (
            {"bag": "mine", "town": 2},
            "A flight is a bag or is rendered, not both: leave out the bag mine, or the conditions.",
        ),
        (
            {"label": "x"},
            "A flight has no 'label': name some of bag, town, height, angle, time, weather, seed.",
        ),
    ],
)
def test_what_is_not_a_flight_is_refused(conditions: dict[str, object], sentence: str) -> None:
    with pytest.raises(InvalidInputError) as refused:
        FlightSpec.of(conditions)
    assert str(refused.value) == sentence


def test_the_panel_varies_what_flights_are_made_of_and_half_of_it_was_never_trained_on() -> None:
    assert len({flight.name for flight in PANEL}) == 8
    assert set(HELD_OUT) < set(PANEL)
    for values in ("town", "height", "angle"):
        assert len({getattr(flight, values) for flight in PANEL}) >= 5
    assert {flight.time for flight in PANEL} == set(TIMES)
    assert {flight.weather for flight in PANEL} == set(WEATHERS)
    seen = {*TRAINING_TOWNS, VALIDATION_TOWN}
    assert len(HELD_OUT) == 4
    for flight in HELD_OUT:
        assert flight.town not in seen
        # random views are up to 10 % higher or lower, and up to 3° steeper or flatter
        assert all(abs(flight.height / height - 1) > 0.1 for height in HEIGHTS_M)
        assert all(abs(flight.angle - pitch) > 3 for pitch in PITCHES_DEG)


def test_a_label_is_fit_for_a_table() -> None:
    with pytest.raises(InvalidInputError, match="The label of a flight must be 1 to 40 of the letters"):
        FlightSpec(label="a b")


def test_a_bag_goes_by_no_name_of_another_flight() -> None:
    for name in ("default", "panel", PANEL[0].name):
        with pytest.raises(InvalidInputError, match=f"The label {name} is the name of another flight"):
            parse_flights([f"{name}=over/town.mcap"])
