import numpy as np
import numpy.typing as npt
import pytest

from sunset.errors import ModelError
from sunset.metrics import normalised_entropy
from sunset.perception import Modality, Model, Segmenter

Frame = tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16]]


def interpolate(low: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
    """Interpolate logits (28, h, w) to (28, 144, 256) pixel by pixel, as the definition of bilinear says."""
    _, height, width = low.shape
    factor = 144 // height

    def axis(size: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.float64]]:
        at = np.clip((np.arange(factor * size) + 0.5) / factor - 0.5, 0, size - 1)
        floor = np.floor(at).astype(np.int64)
        return floor, np.minimum(floor + 1, size - 1), at - floor

    top, bottom, v = axis(height)
    left, right, u = axis(width)
    rows = low[:, top] * (1 - v)[:, None] + low[:, bottom] * v[:, None]
    result: npt.NDArray[np.float64] = rows[:, :, left] * (1 - u) + rows[:, :, right] * u
    return result


@pytest.mark.parametrize("modality", list(Modality))
def test_labels_and_entropy_are_those_of_the_interpolated_logits(
    lite: Model, frame: Frame, modality: Modality
) -> None:
    segmenter = Segmenter(lite)
    result = segmenter.segment(modality, *frame)
    full = interpolate(segmenter.logits(modality, *frame))
    temperature = lite.card.networks[modality].temperature
    assert result.entropy == pytest.approx(normalised_entropy(full, temperature=temperature), abs=1e-5)
    assert (result.labels == full.argmax(axis=0)).mean() > 0.9999


@pytest.mark.parametrize("modality", list(Modality))
def test_the_bits_do_not_depend_on_threads(lite: Model, frame: Frame, modality: Modality) -> None:
    one = Segmenter(lite, threads=1)
    two = Segmenter(lite, threads=2)
    assert one.segment(modality, *frame).entropy == two.segment(modality, *frame).entropy
    assert np.array_equal(one.logits(modality, *frame), two.logits(modality, *frame))


def test_the_answer_does_not_depend_on_what_came_before(lite: Model, frame: Frame) -> None:
    segmenter = Segmenter(lite)
    first = segmenter.segment(Modality.FUSION, *frame)
    segmenter.segment(Modality.FUSION, 255 - frame[0], frame[1])
    again = segmenter.segment(Modality.FUSION, *frame)
    assert again.entropy == first.entropy
    assert np.array_equal(again.labels, first.labels)


def test_labels_are_read_only_class_indices(lite: Model, frame: Frame) -> None:
    labels = Segmenter(lite).segment(Modality.FUSION, *frame).labels
    assert labels.shape == (144, 256)
    assert labels.dtype == np.uint8
    assert labels.max() < 28
    with pytest.raises(ValueError, match="read-only"):
        labels[0, 0] = 1


def test_extreme_images_have_an_entropy_between_0_and_1(lite: Model) -> None:
    for value in (0, 255):
        bgr = np.full((144, 256, 3), value, dtype=np.uint8)
        depth = np.full((144, 256), value * 257, dtype=np.uint16)
        for modality in Modality:
            assert 0 <= Segmenter(lite).segment(modality, bgr, depth).entropy <= 1


def test_an_input_that_is_not_looked_at_may_be_none(lite: Model, frame: Frame) -> None:
    bgr, depth = frame
    segmenter = Segmenter(lite)
    assert (
        segmenter.segment(Modality.RGB, bgr, None).entropy
        == segmenter.segment(Modality.RGB, bgr, depth).entropy
    )
    assert segmenter.segment(Modality.DEPTH, None, depth).labels.shape == (144, 256)


def test_a_view_of_a_larger_array_gives_the_same_as_its_copy(lite: Model, frame: Frame) -> None:
    mirrored = frame[0][:, ::-1]
    segmenter = Segmenter(lite)
    assert (
        segmenter.segment(Modality.RGB, mirrored, None).entropy
        == segmenter.segment(Modality.RGB, mirrored.copy(), None).entropy
    )


def test_a_missing_input_is_refused(lite: Model, frame: Frame) -> None:
    with pytest.raises(
        ModelError, match=r"needs a depth image of shape .144, 256. and type uint16, got none"
    ):
        Segmenter(lite).segment(Modality.FUSION, frame[0], None)


def test_an_image_of_another_size_is_refused(lite: Model) -> None:
    with pytest.raises(
        ModelError, match=r"colour image of shape \(144, 256, 3\) .* got shape \(72, 128, 3\)"
    ):
        Segmenter(lite).segment(Modality.RGB, np.zeros((72, 128, 3), dtype=np.uint8), None)


def test_a_depth_of_another_type_is_refused(lite: Model, frame: Frame) -> None:
    wrong = frame[1].astype(np.float32)
    with pytest.raises(ModelError, match=r"type uint16, got shape .144, 256. and type float32"):
        Segmenter(lite).segment(Modality.DEPTH, None, wrong)  # type: ignore[arg-type]


def test_no_threads_are_refused(lite: Model) -> None:
    with pytest.raises(ModelError, match="must be at least 1, got 0"):
        Segmenter(lite, threads=0)
