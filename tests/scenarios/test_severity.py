"""From what a fault shall cost to its strength."""

import json
from pathlib import Path

import pytest

from sunset.errors import ModelError, ScenarioError
from sunset.perception import load_model
from sunset.perception.card import SEVERITIES_NAME, with_severities
from sunset.scenarios import Scenario, ScenarioFault, with_strengths
from sunset_lab.curves_text import strength_at

SHIFTED = Scenario("shifted", (ScenarioFault("image_shift", severity=2), ScenarioFault("gpu_failure")))
STRENGTHS = {"image_shift": (2.0, 5.0, 10.0, None, None)}


def test_a_severity_becomes_the_strength_of_the_model() -> None:
    shift, failure = with_strengths(SHIFTED, STRENGTHS, "lite").faults
    assert (shift.value, shift.severity) == (5, None)
    assert type(shift.value) is int
    assert failure == SHIFTED.faults[1]


@pytest.mark.parametrize(
    ("strengths", "said"),
    [
        ({}, "gives image_shift a severity, and the model lite does not know its strengths"),
        (
            {"image_shift": (2.0, None, None, None, None)},
            "the severity 2, which no strength reaches with the model lite",
        ),
        ({"image_shift": (None,) * 5}, "with the model lite; no severity can"),
    ],
)
def test_a_severity_that_cannot_be_reached_is_refused(
    strengths: dict[str, tuple[float | None, ...]], said: str
) -> None:
    with pytest.raises(ScenarioError, match=said):
        with_strengths(SHIFTED, strengths, "lite")


def test_the_strengths_of_the_shipped_model_grow_with_the_severity() -> None:
    severities = load_model("lite").card.severities
    assert set(severities) == {"image_degradation", "image_shift", "depth_degradation"}
    for strengths in severities.values():
        reached = [one for one in strengths if one is not None]
        assert reached == sorted(reached)
        assert list(strengths[: len(reached)]) == reached
    assert severities["depth_degradation"][-1] is not None


def test_the_strengths_are_those_that_the_curves_give() -> None:
    page = Path(__file__).parents[2] / "docs" / "curves" / "lite" / "curves.json"
    measured = json.loads(page.read_text(encoding="utf-8"))["faults"]
    points = [(0.0, 0.0)] + [
        (one["strengths"]["depth_degradation"], 1 - one["share_of_nominal_iou"])
        for one in measured
        if "depth_degradation" in one["strengths"]
    ]
    found = [strength_at(points, loss) for loss in (0.10, 0.25, 0.40, 0.55, 0.70)]
    assert load_model("lite").card.severities["depth_degradation"] == pytest.approx(found, rel=1e-3)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"version": "older"}, "must be of lite, version .*, got lite, version older; make it again"),
        ({"strengths": {"image_shift": [1.0]}}, "strengths.*must be a list of five, got"),
    ],
)
def test_a_file_of_severities_that_does_not_fit_is_refused(
    changed: dict[str, object], said: str, tmp_path: Path
) -> None:
    model = load_model("lite")
    content = json.loads((model.folder / SEVERITIES_NAME).read_text(encoding="utf-8"))
    (tmp_path / SEVERITIES_NAME).write_text(json.dumps(content | changed), encoding="utf-8")
    with pytest.raises(ModelError, match=said):
        with_severities(model.card, tmp_path)
