"""Curves: the measures on made-up numbers, and the measuring on a few frames of the flight."""

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sunset.calibration import Condition, CurvesPlan, chosen_frames, plan_curves, window_means
from sunset.data import read_bag, write_bag
from sunset.errors import DataError, ModelError
from sunset.perception import Modality, Segmenter, load_model
from sunset.system import BLUR_SIGMA, current_system
from sunset_lab import frames_of_bag
from sunset_lab.curves import (
    BAND,
    Case,
    Curves,
    Figures,
    curves_of,
    measure_curves,
)
from sunset_lab.curves_text import as_csv, as_json, as_text
from sunset_lab.measuring import measure

pytestmark = pytest.mark.thorough
FAULTS = current_system().faults
UNSURE = ("image_degradation", "unneeded_enhancement", "image_shift", "depth_degradation")
BLURRED = "autofocus_needed"

FRAMES = 40
STRONGEST = {
    "image_degradation": (1.5,),
    "unneeded_enhancement": (1.5,),
    "image_shift": (40,),
    "depth_degradation": (5.0,),
    BLURRED: (4.0,),
}


def synthetic(plan: CurvesPlan, seed: int) -> np.ndarray[tuple[int, int, int], np.dtype[np.float64]]:
    """Figures (frames, conditions, 3) of a model that every fault harms the more the stronger it is."""
    rng = np.random.default_rng(seed)
    iou, entropy, sharp = (
        rng.uniform(0.5, 0.7, FRAMES),
        rng.uniform(0, 0.2, FRAMES),
        rng.uniform(1, 2, FRAMES),
    )
    looks = []
    for condition in plan.conditions():
        there = {
            fault: strength for fault, strength in condition.strengths if fault not in condition.restored
        }
        harm = (
            there.get("image_degradation", 0.0)
            + there.get("unneeded_enhancement", 0.0)
            + there.get("image_shift", 0.0) / 20
            + there.get("depth_degradation", 0.0) / 3
            + there.get(BLURRED, 0.0) / 2
        )
        blurred = 1 + there.get(BLURRED, 0.0)
        looks.append(np.stack([iou / (1 + harm), entropy + harm / 10, sharp / blurred], 1))
    return np.stack(looks, axis=1)


@settings(max_examples=20)
@given(seed=st.integers(0, 10_000))
def test_more_harm_is_never_found_to_be_less(seed: int) -> None:
    card = load_model("lite").card
    plan = plan_curves(card)
    curves = curves_of(plan, card, synthetic(plan, seed))
    for fault in (*UNSURE, BLURRED):
        before = [case.before for case in curves.of(fault)]
        strengths = [case.strengths[fault] for case in curves.of(fault)]
        assert strengths == sorted(strengths)
        for name in ("auc", "over", "entropy"):
            values = [getattr(figures, name) for figures in before]
            assert values == sorted(values), name
        assert [figures.iou for figures in before] == sorted((f.iou for f in before), reverse=True)
        sharp = [figures.sharpness_auc for figures in before]
        assert sharp == sorted(sharp) if fault == BLURRED else set(sharp) == {0.5}
        for case in curves.of(fault):
            assert case.after is not None
            assert case.after.iou == pytest.approx(case.goal)
            assert case.after.auc == pytest.approx(0.5)
    assert curves.main.auc == curves.main.sharpness_auc == 0.5


def test_figures_are_means_and_shares() -> None:
    card = load_model("lite").card
    plan = plan_curves(card, {"image_shift": 9}, grid={})
    values = np.zeros((6, len(plan.conditions()), 3))
    shifted = plan.conditions().index(Condition(Modality.FUSION).with_faults({"image_shift": 9}))
    values[:, 0] = [0.5, 0.05, 2.0]
    values[:, shifted, 0] = [0, 0, 0, 0, 0.6, 0.6]
    values[:, shifted, 1] = card.entropy_threshold * np.array([0, 0, 0, 0, 4.9, 5.2])
    curves = curves_of(plan, card, values)
    (case,) = curves.of("image_shift")
    assert case.suite
    assert case.before.iou == pytest.approx(0.2)
    assert curves.share(case.before) == pytest.approx(0.4)
    assert case.before.over == 0.5  # of the two means of five, only the second exceeds the threshold
    assert case.before.auc == 1.0


def figures(iou: float, auc: float = 1.0, sharpness_auc: float = 0.5) -> Figures:
    return Figures(iou, 0.1, auc, 0.5, 1.0, sharpness_auc, 0.0)


@pytest.mark.parametrize(
    ("fault", "before", "after", "words"),
    [
        ("image_shift", figures(0.7), figures(0.99), []),
        ("image_shift", figures(0.49), figures(0.99), ["only 49% of nominal"]),
        ("image_shift", figures(0.76), figures(0.99), ["still 76% of nominal"]),
        ("image_shift", figures(0.98), figures(0.99), ["still 98% of nominal", "falls by less than 0.03"]),
        ("image_shift", figures(0.7, auc=0.94), figures(0.99), ["entropy AUC 0.940"]),
        ("image_shift", figures(0.7), figures(0.97), ["more than 0.02 below 1.000"]),
        ("image_shift", figures(0.7), None, []),
        (BLURRED, figures(0.9, auc=0.5, sharpness_auc=1.0), figures(1.0), []),
        (BLURRED, figures(0.9, sharpness_auc=0.98), figures(1.0), ["sharpness AUC 0.980"]),
        (BLURRED, figures(0.98, sharpness_auc=1.0), figures(1.0), ["falls by less"]),
    ],
)
def test_a_strength_fits_only_if_nothing_is_missing(
    fault: str, before: Figures, after: Figures | None, words: list[str]
) -> None:
    found = Case({fault: 1.0}, True, before, after, 1.0).shortfalls(1.0)
    assert len(found) == len(words)
    assert all(word in text for word, text in zip(words, found, strict=True))


@given(count=st.integers(5, 300), every=st.integers(1, 9))
def test_frames_left_out_are_whole_groups_of_five(count: int, every: int) -> None:
    frames = chosen_frames(count, every)
    assert frames[:5] == [0, 1, 2, 3, 4]
    assert set(frames) <= set(range(count))
    if every == 1:
        assert frames == list(range(count))
        values = np.random.default_rng(count).random(count)
        np.testing.assert_allclose(window_means(values, 1), np.convolve(values, np.full(5, 0.2), "valid"))
    else:
        groups = np.array(frames).reshape(-1, 5)
        assert (np.diff(groups, axis=1) == 1).all()
        assert (np.diff(groups[:, 0]) == 5 * every).all()
        np.testing.assert_array_equal(window_means(np.array(frames, float), every), groups.mean(axis=1))


@pytest.fixture(scope="module")
def bag(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five frames of the default flight."""
    with read_bag(flight) as reader:
        frames = [reader.frame(index) for index in range(100, 105)]
        return write_bag(tmp_path_factory.mktemp("bags") / "five", frames, list(reader.stamps_ns[:5]))


@pytest.fixture(scope="module")
def measured(bag: Path) -> Curves:
    return measure_curves(load_model("lite"), bag, grid=STRONGEST, jobs=2)


def test_the_number_of_processes_changes_no_figure(bag: Path, measured: Curves) -> None:
    calls: list[tuple[int, int]] = []

    def progress(done: int, total: int) -> None:
        calls.append((done, total))

    alone = measure_curves(load_model("lite"), bag, grid=STRONGEST, jobs=1, progress=progress)
    assert alone == measured
    assert calls == [(done, 5) for done in range(1, 6)]


def test_the_nominal_figures_are_those_of_a_plain_measurement(bag: Path, measured: Curves) -> None:
    plain = measure(load_model("lite"), frames_of_bag(bag), range(5), jobs=1).per_image()
    assert [figures.iou for figures in measured.nominal.values()] == pytest.approx(plain.tolist())
    segmenter = Segmenter(load_model("lite"))
    with read_bag(bag) as reader:
        frames = [reader.frame(index) for index in range(5)]
    entropies = [segmenter.segment(Modality.DEPTH, frame.rgb, frame.depth).entropy for frame in frames]
    assert measured.nominal[Modality.DEPTH].entropy == pytest.approx(float(np.mean(entropies)))
    assert measured.frames == 5


def test_strong_faults_harm_and_cures_help(measured: Curves) -> None:
    for fault in (*UNSURE, BLURRED):
        strongest = measured.of(fault)[-1]
        assert strongest.before.iou < 0.8 * measured.main.iou
        assert strongest.after is not None
        assert strongest.after.iou >= strongest.goal - 0.02
        assert strongest.before.sharpness_auc == 1.0 if fault == BLURRED else strongest.before.auc == 1.0
    assert len(measured.pairs) == 9
    assert all(case.after is None and case.suite for case in measured.pairs)


def test_the_table_stars_the_strengths_of_the_suites(measured: Curves) -> None:
    text = as_text(measured)
    starred = {line.split()[0]: line.split()[1] for line in text.splitlines() if "*" in line[:30]}
    degradation = f"{FAULTS['image_degradation'].value:g}*"
    assert starred == {
        "image_degradation": degradation,
        "unneeded_enhancement": degradation,
        "image_shift": f"{FAULTS['image_shift'].value:g}*",
        "depth_degradation": f"{FAULTS['depth_degradation'].value:g}*",
        BLURRED: f"{BLUR_SIGMA:g}*",
    }
    assert max(map(len, text.splitlines()[:-1])) <= 115


def test_rows_and_object_hold_what_the_table_holds(measured: Curves) -> None:
    rows = list(csv.DictReader(as_csv(measured).splitlines()))
    assert len(rows) == 3 + 2 * len(measured.points) + len(measured.pairs)
    suite = [row for row in rows if row["suite"] == "1" and row["faults"] == "image_shift"]
    (faulty, cured) = suite
    (case,) = [case for case in measured.of("image_shift") if case.suite]
    assert (faulty["state"], cured["state"]) == ("faulty", "cured")
    assert float(faulty["iou"]) == pytest.approx(case.before.iou, rel=1e-5)
    found = as_json(measured)
    assert found["frames"] == 5
    assert len(found["faults"]) == len(measured.points)  # type: ignore[arg-type]


def test_a_bag_that_is_too_short_for_a_symptom_is_refused(bag: Path, tmp_path: Path) -> None:
    with read_bag(bag) as reader:
        short = write_bag(tmp_path / "short", [reader.frame(0)], [0])
    with pytest.raises(DataError, match="must have at least 5 frames, got 1"):
        measure_curves(load_model("lite"), short, jobs=1)


def test_what_goes_wrong_in_another_process_is_told(bag: Path, tmp_path: Path) -> None:
    folder = tmp_path / "model"
    shutil.copytree(load_model("lite").folder, folder)
    model = load_model(folder)
    (folder / "rgb.onnx").write_bytes(b"")
    with pytest.raises(ModelError, match="not the one on the model's card"):
        measure_curves(model, bag, jobs=2)


def test_the_band_is_the_one_that_the_documentation_names() -> None:
    assert BAND == (0.5, 0.75)
