"""What the shipped model's card, written by its training run, has to say."""

from typing import Any

import pytest

from sunset.faults import BLUR_SIGMA, FAULTS
from sunset.perception import load_model
from sunset.training import TrainingConfig


@pytest.fixture(scope="module")
def results() -> Any:
    return load_model("lite").card.results


def test_late_fusion_beats_each_sensor_alone_on_held_out_towns(results: Any) -> None:
    for town in ("validation town", "test town"):
        iou = results["iou_per_image"][town]
        assert iou["fusion"] > max(iou["rgb"], iou["depth"])


def test_every_f4_fault_was_measured_at_its_suite_strength_and_shows_in_the_entropy(results: Any) -> None:
    strengths = {
        name: FAULTS[name].value for name in ("image_degradation", "image_shift", "depth_degradation")
    }
    strengths["unneeded_enhancement"] = strengths["image_degradation"]
    for town in ("validation", "test"):
        rows = results[f"faults_on_flights_over_the_{town}_town"]
        assert rows["autofocus_needed"]["strength"] == BLUR_SIGMA
        for name, strength in strengths.items():
            assert rows[name]["strength"] == strength, "recalibrate: sunset train resumes at the checkpoint"
            assert rows[name]["auc_against_nominal"] >= 0.9
            assert rows[name]["iou"] < rows["nominal, fusion"]["iou"]


def test_the_networks_agree_on_the_nominal_entropy(results: Any) -> None:
    rows = results["faults_on_flights_over_the_validation_town"]
    entropies = [rows[f"nominal, {name}"]["entropy"] for name in ("fusion", "rgb", "depth")]
    assert max(entropies) - min(entropies) < 0.005


def test_the_shipped_model_is_what_the_default_configuration_trains() -> None:
    card, config = load_model("lite").card, TrainingConfig()
    schedule: Any = card.training["schedule"]
    assert card.training["seed"] == config.seed
    assert schedule["steps"] == config.schedule.steps
    assert schedule["batch"] == config.schedule.batch
