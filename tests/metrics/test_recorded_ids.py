"""Counts of a prediction against recorded ids, as the evaluator takes them, against counting pixel by pixel."""

import numpy as np
import numpy.typing as npt
from hypothesis import given, settings
from hypothesis import strategies as st

from sunset.classes import CARLA_IDS, CLASS_OF_CARLA_ID, CLASSES
from sunset.metrics import ClassCounts, count_classes, image_iou
from sunset_ros.seeding import generator

INDEX = {carla_id: index for index, carla_id in enumerate(CARLA_IDS.values())}


def compare(prediction: npt.NDArray[np.uint8], carla_ids: npt.NDArray[np.uint8]) -> ClassCounts:
    return count_classes(prediction, CLASS_OF_CARLA_ID[carla_ids])


@settings(max_examples=30)
@given(st.integers(0, 10_000))
def test_counts_are_those_of_a_loop_over_pixels(seed: int) -> None:
    rng = generator(seed, "test")
    prediction = rng.integers(0, 4, size=(6, 5), dtype=np.uint8)
    carla_ids = rng.choice(np.array([0, 1, 2, 3, 5, 4, 255], dtype=np.uint8), size=(6, 5))
    counts = compare(prediction, carla_ids)
    ious = []
    for index in range(len(CLASSES)):
        both = predicted = truth = 0
        for said, recorded in zip(prediction.flat, carla_ids.flat, strict=True):
            if int(recorded) not in INDEX:
                continue
            is_true = INDEX[int(recorded)] == index
            both += is_true and said == index
            predicted += said == index
            truth += is_true
        assert (counts.intersection[index], counts.predicted[index], counts.truth[index]) == (
            both,
            predicted,
            truth,
        )
        if predicted + truth:
            ious.append(both / (predicted + truth - both))
    assert image_iou(counts) == (np.mean(ious) if ious else 0.0)


def test_counts_have_one_entry_a_class() -> None:
    counts = compare(np.full((2, 2), 27, np.uint8), np.full((2, 2), 105, np.uint8))
    assert counts.intersection.shape == counts.predicted.shape == counts.truth.shape == (28,)
    assert (counts.truth[27], image_iou(counts)) == (4, 1.0)


def test_a_prediction_that_is_no_class_counts_against_the_truth() -> None:
    counts = compare(np.full((1, 2), 200, np.uint8), np.full((1, 2), 7, np.uint8))
    assert counts.predicted.tolist() == [0] * 28
    assert image_iou(counts) == 0.0


def test_a_frame_without_any_known_class_has_no_iou() -> None:
    assert np.isnan(image_iou(compare(np.zeros((2, 2), np.uint8), np.zeros((2, 2), np.uint8))))
