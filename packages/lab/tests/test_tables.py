"""Tables of IoU: the sums on made-up counts, and a few rendered frames."""

import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError
from sunset.metrics import ClassCounts, accumulated_iou, count_classes, image_iou
from sunset.perception import Modality, Model, load_model
from sunset_lab.measuring import Measured
from sunset_lab.tables import (
    AXES,
    VIEWS,
    Entry,
    IouTables,
    claims,
    iou_csv,
    iou_json,
    iou_markdown,
    measure_iou,
    settings,
)

pytestmark = pytest.mark.thorough

FUSION, RGB, DEPTH = (Entry("lite", modality) for modality in Modality)


def counted(frames: int, networks: int, seed: int) -> tuple[Measured, list[list[ClassCounts]]]:
    rng = np.random.default_rng(seed)
    counts = []
    for _ in range(frames):
        truth = rng.integers(0, 6, (9, 16), dtype=np.uint8)
        guesses = [
            np.where(rng.random((9, 16)) < 0.5, truth, rng.integers(0, 7, (9, 16))).astype(np.uint8)
            for _ in range(networks)
        ]
        counts.append([count_classes(guess, truth) for guess in guesses])
    rows = [[[c.intersection, c.predicted, c.truth] for c in frame] for frame in counts]
    return Measured(np.array(rows)), counts


@given(frames=st.integers(1, 6), seed=st.integers(0, 1000))
def test_means_are_those_of_the_single_images_and_of_their_sum(frames: int, seed: int) -> None:
    measured, counts = counted(frames, 2, seed)
    for network in range(2):
        own = [frame[network] for frame in counts]
        assert measured.per_image()[network] == pytest.approx(np.mean([image_iou(c) for c in own]))
        together = accumulated_iou(
            np.stack([c.intersection for c in own]),
            np.stack([c.predicted for c in own]),
            np.stack([c.truth for c in own]),
        )
        assert measured.dataset()[network] == pytest.approx(together)
    assert measured.shares().sum() == pytest.approx(1)
    assert np.isnan(measured.by_class()[:, 7:]).all()


def test_a_few_views_differ_and_many_have_every_setting_equally_often() -> None:
    assert len(set(settings(VIEWS // 2))) == VIEWS // 2
    assert settings(5) == settings(VIEWS)[:5]
    for axis in AXES:
        assert len(set(Counter(getattr(setting, axis) for setting in settings(VIEWS)).values())) == 1


def made(shares: Sequence[Sequence[float]]) -> Measured:
    """Counts of one frame of two classes, building and car; `shares` has (IoU of each) by network."""
    counts = np.zeros((1, len(shares), 3, 28), dtype=np.int64)
    for network, (building, car) in enumerate(shares):
        for label, (iou, pixels) in {"building": (building, 990), "car": (car, 10)}.items():
            index = CLASSES.index(label)
            counts[0, network, :, index] = [round(iou * pixels), round(iou * pixels), pixels]
    return Measured(counts)


def tables(shares: Sequence[Sequence[float]], networks: tuple[Entry, ...]) -> IouTables:
    measured = made(shares)
    return IouTables(networks, {7: measured, 8: measured}, measured, settings(1))


def test_claims_that_hold_and_claims_that_do_not() -> None:
    good = list(claims(tables([(0.9, 0.9), (0.8, 0.8), (0.7, 0.7)], (FUSION, RGB, DEPTH))))
    assert len(good) == 9
    assert all(line.startswith("holds: ") for line in good)
    bad = list(claims(tables([(0.9, 0.2), (0.9, 0.19), (0.8, 0.2)], (FUSION, RGB, DEPTH))))
    assert all(line.startswith("does not hold: ") for line in bad if "depth" not in line)
    assert "holds: town 7, lite: fusion 0.550 ≥ depth 0.500 + 0.05" in bad
    assert any(line.endswith("not car 0.200") for line in bad)


def test_models_are_put_in_order() -> None:
    other = Entry("reference", Modality.FUSION)
    found = list(claims(tables([(0.8, 0.8), (0.9, 0.9)], (FUSION, other))))
    assert "best on town 8: reference fusion 0.900, then lite fusion 0.800" in found


def test_a_model_of_one_network_claims_its_classes_only() -> None:
    assert len(list(claims(tables([(0.8, 0.8)], (RGB,))))) == 3


def test_a_row_of_the_markdown_is_as_wide_as_its_head() -> None:
    text = iou_markdown(tables([(0.9, 0.9), (0.8, 0.8)], (FUSION, RGB)))
    assert "| car      |           1.00% |       0.900 |    0.800 |" in text
    blocks = [[line for line in part.splitlines() if line.startswith("|")] for part in text.split("\n\n")]
    for block in filter(None, blocks):
        assert len({line.count("|") for line in block}) == 1
        assert len({len(line) for line in block}) == 1


@pytest.fixture(scope="module")
def measured(flight: Path) -> IouTables:
    del flight  # it is there
    return measure_iou([load_model("lite")], frames=2, jobs=1)


def test_two_frames_of_each_place_make_every_table(measured: IouTables) -> None:
    assert measured.networks == (FUSION, RGB, DEPTH)
    assert [len(part) for part in measured.places().values()] == [2, 2, 2]
    assert list(measured.places()) == ["town 7", "town 8", "default flight"]
    for axis in AXES:
        assert sum(len(part) for part in measured.along(axis).values()) == 4
    pixels = measured.flight.counts[:, :, 2].sum(axis=2)
    assert (pixels == 144 * 256).all()
    assert (measured.flight.per_image() > 0.1).all()


def test_rows_and_object_agree(measured: IouTables) -> None:
    rows = list(csv.DictReader(iou_csv(measured).splitlines()))
    found = iou_json(measured)
    frames = found["frames"]
    assert isinstance(frames, dict)
    assert {row["frames"] for row in rows} == set(frames)
    for row in rows:
        network = frames[row["frames"]]["networks"][f"{row['model']} {row['modality']}"]
        values = {"mean over frames": network["mean_over_frames"], "mIoU": network["miou"]}
        expected = network["classes"][row["class"]] if row["class"] else values[row["measure"]]
        assert float(row["iou"]) == pytest.approx(expected, rel=1e-4, abs=1e-6)


def test_models_of_other_sizes_are_not_put_in_one_table() -> None:
    lite = load_model("lite")
    larger = Model(lite.folder, replace(lite.card, height=288, width=512))
    with pytest.raises(InvalidInputError, match="of one size, got lite 256x144, lite 512x288"):
        measure_iou([lite, larger])


def test_models_that_cannot_be_told_apart_are_not_put_in_one_table() -> None:
    lite = load_model("lite")
    version = lite.card.version
    with pytest.raises(InvalidInputError, match=rf"got lite \({version}\) more than once\."):
        measure_iou([lite, load_model(lite.folder)])
