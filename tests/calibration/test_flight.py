"""Thresholds belong to a model and a flight: found once, kept, and used in place of the model's own."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sunset.calibration import FlightThresholds, fit_to_flight, flight_thresholds, plan_curves
from sunset.calibration import flight as module
from sunset.calibration.flight import OF_CARD
from sunset.data import BagReader, flights_folder, read_bag, write_bag
from sunset.perception import Modality, Segmenter, load_model

pytestmark = pytest.mark.xdist_group("calibration")  # what is found is found once

MODEL = load_model("lite")
FRAMES = 25


@pytest.fixture(scope="module")
def bag(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> BagReader:
    """Return some frames of the default flight, brighter than they were."""
    path = tmp_path_factory.mktemp("flight") / "bright"
    with read_bag(flight) as reader:
        frames = [reader.frame(index) for index in range(FRAMES)]
        bright = [replace(frame, rgb=np.minimum(frame.rgb, 200) + np.uint8(55)) for frame in frames]
        write_bag(path, bright, reader.stamps_ns[:FRAMES])
    return read_bag(path, size=(144, 256))


@pytest.fixture(scope="module")
def found(bag: BagReader, tmp_path_factory: pytest.TempPathFactory) -> FlightThresholds:
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("cache")
        patch.setenv("SUNSET_CACHE_DIR", str(folder))
        answers = folder / "images.sqlite"
        fitted, found = fit_to_flight(MODEL, bag, jobs=1, cache=answers)
        assert found is not None
        thresholds = fitted.card.entropy_threshold, fitted.card.sharpness_threshold
        assert thresholds == (found.entropy_threshold, found.sharpness_threshold)
        assert replace(fitted.card, entropy_threshold=1.0) == replace(
            MODEL.card, entropy_threshold=1.0, sharpness_threshold=thresholds[1]
        )
        # what is kept is not measured again
        patch.setattr(module, "_look_at_all", None)
        assert fit_to_flight(MODEL, bag, jobs=1, cache=answers) == (fitted, found)
        (file,) = flights_folder().glob("thresholds-*.json")
        kept = json.loads(file.read_text())
        assert kept["made_of"]["network fusion"] == MODEL.card.networks[Modality.FUSION].digest
        file.write_text("{")
        with pytest.raises(TypeError):
            fit_to_flight(MODEL, bag, jobs=1)
    return found


def test_few_healthy_windows_of_any_network_are_over_the_threshold(
    bag: BagReader, found: FlightThresholds
) -> None:
    segmenter = Segmenter(MODEL)
    for modality in Modality:
        frames = map(bag.frame, range(FRAMES))
        entropies = [segmenter.segment(modality, frame.rgb, frame.depth).entropy for frame in frames]
        windows = np.convolve(entropies, np.full(5, 0.2), "valid")
        share = float((windows > found.entropy_threshold + 1e-9).mean())
        assert share == pytest.approx(found.over[modality.key], abs=0.01)
        assert share <= 0.02


def test_every_fault_of_the_entropy_is_judged_before_and_after_its_cure(found: FlightThresholds) -> None:
    faults = {"image_degradation", "unneeded_enhancement", "image_shift", "depth_degradation"}
    assert found.auc.keys() == found.missed.keys() == found.cured.keys() == faults
    assert found.cured["depth_degradation"] == pytest.approx(1 - found.over["rgb"])
    assert found.cured["image_shift"] == pytest.approx(1 - found.over["fusion"])


def test_the_thresholds_of_the_default_flight_are_the_models_own(flight: Path) -> None:
    assert fit_to_flight(MODEL, read_bag(flight, size=(144, 256))) == (MODEL, None)


def test_what_is_measured_on_the_default_flight_are_the_thresholds_of_its_runs(
    flight: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "flights_folder", lambda: tmp_path)
    conditions = module._conditions(plan_curves(MODEL.card, grid={}))
    drawn = np.random.default_rng(1).uniform(0, 1, (400, len(conditions), 2))
    monkeypatch.setattr(module, "_look_at_all", lambda *_: drawn)
    found = flight_thresholds(MODEL, read_bag(flight, size=(144, 256)))
    card = MODEL.card
    assert (found.entropy_threshold, found.sharpness_threshold) == (
        card.entropy_threshold,
        card.sharpness_threshold,
    )
    windows = np.convolve(drawn[:, 0, 0], np.full(5, 0.2), "valid")
    assert found.over["fusion"] == pytest.approx((windows > card.entropy_threshold).mean())
    assert found.made_of[OF_CARD] == f"{card.entropy_threshold} {card.sharpness_threshold}"


def test_frames_that_tell_nothing_leave_the_model_its_thresholds(
    bag: BagReader, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(tmp_path / "cache"))
    conditions = module._conditions(plan_curves(MODEL.card, grid={}))
    monkeypatch.setattr(module, "_look_at_all", lambda *_: np.zeros((FRAMES, len(conditions), 2)))
    fitted, found = fit_to_flight(MODEL, bag)
    assert fitted == MODEL
    assert found is not None
    assert not flights_folder().exists()  # without answers that are kept, thresholds are not kept either
    assert set(found.auc.values()) == {0.5}
    begin = "No threshold of the entropy tells healthy frames of this flight from all faulty ones with the model lite: "
    assert found.warning("lite").startswith(
        f"{begin}the AUC of image_degradation is 0.50, the AUC of unneeded_enhancement is 0.50, the AUC of image_shift "
        "is 0.50, the AUC of depth_degradation is 0.50, 100% of the windows with image_degradation are not over it, "
    )
