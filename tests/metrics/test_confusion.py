import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from sunset.metrics import accumulated_iou, class_iou, count_classes, image_iou

Labels = npt.NDArray[np.uint8]


def labels(*rows: list[int]) -> Labels:
    return np.array(rows, dtype=np.uint8)


def iou_by_sets(prediction: Labels, truth: Labels) -> float:
    """Return the same figure from sets of pixels, as a second implementation."""
    pixels = [
        (p, t) for p, t in zip(prediction.ravel().tolist(), truth.ravel().tolist(), strict=True) if t < 28
    ]
    ratios = []
    for name in range(28):
        predicted = {i for i, (p, _) in enumerate(pixels) if p == name}
        true = {i for i, (_, t) in enumerate(pixels) if t == name}
        if predicted | true:
            ratios.append(len(predicted & true) / len(predicted | true))
    return sum(ratios) / len(ratios) if ratios else math.nan


def test_counts_of_a_small_image() -> None:
    counts = count_classes(labels([0, 0, 3], [5, 3, 27]), labels([0, 3, 3], [5, 5, 27]))
    assert counts.intersection[[0, 3, 5, 27]].tolist() == [1, 1, 1, 1]
    assert counts.predicted[[0, 3, 5, 27]].tolist() == [2, 2, 1, 1]
    assert counts.truth[[0, 3, 5, 27]].tolist() == [1, 2, 2, 1]
    assert counts.intersection.sum() == 4
    assert counts.predicted.sum() == counts.truth.sum() == 6


def test_what_is_no_class_counts_for_none() -> None:
    counts = count_classes(labels([29, 28, 200, 2, 2]), labels([2, 2, 2, 2, 255]))
    assert (counts.intersection.sum(), counts.predicted.sum(), counts.truth[2]) == (1, 1, 4)


def test_image_iou_is_the_mean_over_classes_that_are_there() -> None:
    # class 0: 1/2, class 3: 1/3, class 5: 1/2, class 27: 1/1
    counts = count_classes(labels([0, 0, 3], [5, 3, 27]), labels([0, 3, 3], [5, 5, 27]))
    assert image_iou(counts) == pytest.approx((1 / 2 + 1 / 3 + 1 / 2 + 1) / 4)


def test_class_only_in_the_prediction_counts_as_wrong() -> None:
    assert image_iou(count_classes(labels([7, 8]), labels([7, 7]))) == pytest.approx((1 / 2 + 0) / 2)


@pytest.mark.parametrize("unknown", [28, 100, 255])
def test_pixels_without_a_true_class_are_left_out(unknown: int) -> None:
    counts = count_classes(labels([4, 9, 9]), labels([4, unknown, unknown]))
    assert counts.predicted.sum() == 1
    assert image_iou(counts) == 1.0


@pytest.mark.parametrize("unknown", [28, 255])
def test_prediction_that_is_no_class_is_wrong_for_the_true_class_only(unknown: int) -> None:
    counts = count_classes(labels([4, unknown]), labels([4, 4]))
    assert (counts.predicted.sum(), counts.truth.sum()) == (1, 2)
    assert image_iou(counts) == 0.5


def test_image_without_any_true_class_has_no_iou() -> None:
    assert math.isnan(image_iou(count_classes(labels([1, 2]), labels([255, 255]))))


def test_absent_classes_are_marked() -> None:
    iou, present = class_iou(count_classes(labels([1, 2]), labels([1, 1])))
    assert np.flatnonzero(present).tolist() == [1, 2]
    assert iou[[0, 1, 2]].tolist() == [0.0, 0.5, 0.0]


def test_different_shapes_are_refused() -> None:
    with pytest.raises(ValueError, match=r"shape \(1, 2\), got \(1, 3\)"):
        count_classes(labels([1, 2, 3]), labels([1, 2]))


def test_accumulated_iou_is_of_the_summed_counts_and_not_the_mean_of_ratios() -> None:
    # image 1: class 0 4/4. image 2: class 0 0/2, class 1 0/2 → of images 1 and 0, mean 0.5;
    # together class 0 has 4 right of 4 + 2 = 6, class 1 has 0 of 2.
    images = [
        count_classes(labels([0, 0, 0, 0]), labels([0, 0, 0, 0])),
        count_classes(labels([0, 0]), labels([1, 1])),
    ]
    stacked = [
        np.stack([getattr(i, name) for i in images]) for name in ("intersection", "predicted", "truth")
    ]
    assert accumulated_iou(*stacked) == pytest.approx((4 / 6 + 0) / 2)
    assert np.mean([image_iou(i) for i in images]) == 0.5


def test_accumulated_iou_of_no_images_is_none() -> None:
    nothing = np.empty((0, 28), dtype=np.int64)
    assert accumulated_iou(nothing, nothing, nothing) is None


@given(
    arrays(np.uint8, (4, 5), elements=st.sampled_from([0, 1, 2, 27, 28, 255])),
    arrays(np.uint8, (4, 5), elements=st.sampled_from([0, 1, 2, 27, 28, 255])),
)
@settings(max_examples=100)
def test_agrees_with_sets_of_pixels(prediction: Labels, truth: Labels) -> None:
    expected = iou_by_sets(prediction, truth)
    assert image_iou(count_classes(prediction, truth)) == pytest.approx(expected, nan_ok=True)


def test_more_pixels_are_counted_than_a_float_can_count() -> None:
    image = np.zeros((4097, 4097), np.uint8)  # 2**24 + 8193 pixels
    counts = count_classes(image, image)
    assert {int(one[0]) for one in (counts.intersection, counts.predicted, counts.truth)} == {image.size}
