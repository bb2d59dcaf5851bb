"""What the shipped models' cards, written by their training runs, have to say."""

from typing import Any

import pytest

from sunset.perception import Modality, ModelCard, list_models, load_model
from sunset.system import BLUR_SIGMA, current_system
from sunset_lab import CONFIGS

pytestmark = pytest.mark.thorough
FAULTS = current_system().faults

DROP = {"lite": 0.03, "reference": 0.02}
"""What a fault costs at least in IoU. `reference`, trained without an accelerator, has less to lose: its card tells."""


@pytest.fixture(scope="module", params=list_models())
def card(request: pytest.FixtureRequest) -> ModelCard:
    return load_model(request.param).card


def test_late_fusion_beats_each_sensor_alone_on_held_out_towns(card: ModelCard) -> None:
    results: Any = card.results
    for town in ("validation town", "test town"):
        iou = results["iou_per_image"][town]
        assert iou["fusion"] >= iou["rgb"] + 0.01
        assert iou["fusion"] >= iou["depth"] + 0.05


def test_8_bits_cost_less_than_a_hundredth(card: ModelCard) -> None:
    assert card.precision == "int8"
    measured: Any = card.results["iou_by_precision_on_the_validation_town"]
    for modality in Modality:
        assert measured[modality.key]["int8"] >= measured[modality.key]["float32"] - 0.01


def test_every_f4_fault_was_measured_at_its_suite_strength_and_shows_in_the_entropy(card: ModelCard) -> None:
    strengths = {
        name: FAULTS[name].value for name in ("image_degradation", "image_shift", "depth_degradation")
    }
    strengths["unneeded_enhancement"] = strengths["image_degradation"]
    rows: Any = card.results["faults_at_suite_strength"]
    assert rows["autofocus_needed"]["strength"] == BLUR_SIGMA, (
        "run: sunset train --resume, or models calibrate"
    )
    for name, strength in strengths.items():
        assert rows[name]["strength"] == strength, "run: sunset train --resume, or sunset models calibrate"
        assert rows[name]["auc"] >= 0.95
        assert rows[name]["iou"] < rows["nominal, fusion"]["iou"] - DROP[card.name]


def test_every_cure_brings_the_quality_back(card: ModelCard) -> None:
    rows: Any = card.results["faults_at_suite_strength"]
    for name in ("image_degradation", "unneeded_enhancement", "image_shift", "depth_degradation"):
        nominal = rows["nominal, rgb" if name == "depth_degradation" else "nominal, fusion"]
        cured = rows[f"{name}, cured"]
        assert cured["iou"] == pytest.approx(nominal["iou"], abs=0.02)
        assert cured["entropy"] < card.entropy_threshold < rows[name]["entropy"]


def test_blur_shows_in_the_sharpness(card: ModelCard) -> None:
    rows: Any = card.results["faults_at_suite_strength"]
    blurred = rows["autofocus_needed"]
    assert blurred["iou"] < rows["nominal, fusion"]["iou"] - DROP[card.name]
    assert blurred["sharpness_auc"] >= 0.99
    assert blurred["sharpness"] < card.sharpness_threshold < rows["nominal, fusion"]["sharpness"]


def test_the_networks_are_not_too_large_to_ship() -> None:
    folders = [load_model(name).folder for name in list_models()]
    sizes = {folder.name: sum(file.stat().st_size for file in folder.iterdir()) for folder in folders}
    assert max(sizes.values()) <= 90e6, sizes


def test_the_networks_agree_on_the_nominal_entropy(card: ModelCard) -> None:
    rows: Any = card.results["faults_at_suite_strength"]
    entropies = [rows[f"nominal, {name}"]["entropy"] for name in ("fusion", "rgb", "depth")]
    assert max(entropies) - min(entropies) < 0.005


def test_a_shipped_model_is_what_its_configuration_trains(card: ModelCard) -> None:
    config = CONFIGS[card.name]
    stages: Any = card.training["stages"]
    assert card.architecture == config.shape.name
    first: Any = card.training.get("before", card.training)
    assert first["seed"] == config.seed
    assert card.training["logit_adjustment"] == config.logit_adjustment
    assert list(stages) == [stage.name for stage in config.stages()]
    for stage in config.stages():
        assert stages[stage.name]["schedule"]["learning_rate"] == stage.schedule.learning_rate
        assert stages[stage.name]["schedule"]["class_weight_range"] == list(stage.schedule.class_weight_range)
