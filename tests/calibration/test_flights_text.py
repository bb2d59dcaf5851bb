import msgspec

from sunset.calibration import FlightThresholds
from sunset.calibration.flight import OF_CARD, flights_text

GOOD = FlightThresholds(
    entropy_threshold=0.1,
    sharpness_threshold=1.0,
    over={"rgb": 0.02},
    auc={"image_shift": 0.95},
    missed={"image_shift": 0.05},
    cured={"image_shift": 0.95},
    made_of={},
)


def test_the_table_says_which_flights_are_beyond_a_model() -> None:
    assert GOOD.shortfalls() == ()
    assert GOOD.warning("lite") == ""
    assert flights_text("lite", {"a": GOOD}, ()).endswith("All of it holds for lite.\n")
    bad = msgspec.structs.replace(
        GOOD, over={"rgb": 0.03}, auc={"image_shift": 0.949}, missed={"y": 0.06}, cured={"x": 0.94}
    )
    text = flights_text("lite", {"a": GOOD, "b": bad}, {"b"})
    assert text.endswith(
        "Beyond lite is b: 3% of the windows of rgb are over it, the AUC of image_shift is 0.95, 6% of the windows "
        "with y are not over it and 6% of the windows after the cure of x are over it.\n"
    )
    assert [line.split()[:2] for line in text.splitlines()[1:3]] == [["a", "no"], ["b", "yes"]]


def test_the_default_flight_has_the_thresholds_of_the_card() -> None:
    default = msgspec.structs.replace(GOOD, made_of={OF_CARD: "0.1 1.0"})
    text = flights_text("lite", {"default": default}, ())
    assert "On default runs have the thresholds of the model's card" in text
