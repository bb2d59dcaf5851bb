import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import numpy.typing as npt
import onnxruntime
import pytest

from sunset.errors import InvalidInputError, MissingExtraError, ModelError
from sunset.images import ImageCache, LazyImage
from sunset.metrics import normalised_entropy
from sunset.perception import Modality, Model, Segmenter, list_models, load_model

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
    logits = segmenter.logits(modality, *frame)
    full = interpolate(logits)
    bounded = interpolate(np.maximum(logits, logits.max(axis=0) - 60))
    temperature = lite.card.networks[modality].temperature
    assert result.entropy == pytest.approx(normalised_entropy(bounded, temperature=temperature), abs=1e-5)
    assert result.entropy == pytest.approx(normalised_entropy(full, temperature=temperature), abs=5e-4)
    assert (result.labels == full.argmax(axis=0)).mean() > 0.9999


ANSWERS = """
import sys
from pathlib import Path
import numpy as np
from sunset.perception import Modality, Segmenter, load_model
segmenter = Segmenter(load_model(sys.argv[1]))
with np.load(sys.argv[2]) as frames:
    bgr, depth = frames["bgr"], frames["depth"]
for index in map(int, sys.argv[3:]):
    for modality in Modality:
        result = segmenter.segment(modality, bgr[index], depth[index])
        print(index, modality.key, result.entropy.hex(), result.labels.tobytes().hex())
"""


def bits(segmenter: Segmenter, bgr: npt.NDArray[np.uint8], depth: npt.NDArray[np.uint16]) -> list[bytes]:
    """Return everything that a segmenter answers to a frame, of all networks of its model."""
    results = [segmenter.segment(modality, bgr, depth) for modality in segmenter.model.card.networks]
    logits = [segmenter.logits(modality, bgr, depth) for modality in segmenter.model.card.networks]
    answers = [values.tobytes() for values in logits] + [result.labels.tobytes() for result in results]
    return answers + [result.entropy.hex().encode() for result in results]


def frames(frame: Frame, count: int) -> Iterator[Frame]:
    """Yield frames that differ in every part."""
    bgr, depth = frame
    for index in range(count):
        shifted = np.roll(bgr, 31 * index, axis=1) // (1 + index % 3)
        yield shifted.astype(np.uint8), (depth + 977 * index).astype(np.uint16)


@pytest.mark.thorough
@pytest.mark.parametrize("name", list_models())
def test_the_bits_of_an_answer_do_not_depend_on_what_came_before(name: str, frame: Frame) -> None:
    segmenter = Segmenter(load_model(name))
    material = list(frames(frame, 2))
    first = [bits(segmenter, *one) for one in material]
    assert [bits(segmenter, *one) for one in reversed(material)] == first[::-1]
    assert len({answers[0] for answers in first}) == len(material)


@pytest.mark.thorough
@pytest.mark.parametrize("name", list_models())
def test_the_bits_of_an_answer_do_not_depend_on_what_runs_beside(name: str, frame: Frame) -> None:
    segmenter = Segmenter(load_model(name))
    material = list(frames(frame, 4))
    alone = [bits(segmenter, *one) for one in material]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda one: bits(segmenter, *one), material)) == alone


@pytest.mark.thorough
def test_the_bits_of_an_answer_do_not_depend_on_the_process(tmp_path: Path, frame: Frame) -> None:
    bgr, depth = zip(*frames(frame, 2), strict=True)
    np.savez(tmp_path / "frames.npz", bgr=bgr, depth=depth)
    for name in list_models():
        command = [sys.executable, "-c", ANSWERS, name, str(tmp_path / "frames.npz")]
        orders = (("0", "1"), ("1", "0"))
        runs = [subprocess.Popen([*command, *order], stdout=subprocess.PIPE, text=True) for order in orders]
        answers = [run.communicate()[0].splitlines() for run in runs]
        assert [run.returncode for run in runs] == [0, 0]
        assert len(set(answers[0])) == 6
        assert sorted(answers[0]) == sorted(answers[1])


def test_a_network_is_warmed_up_by_all_that_segmenting_runs(
    tmp_path: Path, lite: Model, frame: Frame, monkeypatch: pytest.MonkeyPatch
) -> None:
    runs: list[tuple[list[str], list[str]]] = []

    class Session:
        def __init__(self, modality: Modality) -> None:
            self._session = lite.session(modality)

        def run(self, outputs: list[str], inputs: dict[str, object]) -> object:
            runs.append((outputs, list(inputs)))
            return self._session.run(outputs, inputs)

    cache = ImageCache(tmp_path / "answers.sqlite")
    segmenter = Segmenter(lite, cache=cache)
    sessions = {modality: Session(modality) for modality in Modality}
    monkeypatch.setattr(Model, "session", lambda _, modality, **__: sessions[modality])
    for modality in Modality:
        segmenter.warm_up(modality)
        segmenter.warm_up(modality)
        segmenter.segment(modality, *frame)
        first, second, segmented = runs[-3:]
        assert first == second == segmented  # an empty image is not looked up, and is run again


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


def test_an_unknown_device_is_refused(lite: Model) -> None:
    with pytest.raises(InvalidInputError, match=r"must be one of cpu, cuda, auto, got 'gpu'\."):
        Segmenter(lite, device="gpu")


OFFERED = "CUDAExecutionProvider" in onnxruntime.get_available_providers()


@pytest.mark.skipif(OFFERED, reason="this ONNX Runtime offers CUDA")
def test_a_device_that_is_not_there_is_refused_and_auto_does_without(lite: Model, frame: Frame) -> None:
    with pytest.raises(
        MissingExtraError, match=r"needs the package onnxruntime-gpu .* or choose the device cpu\."
    ):
        Segmenter(lite, device="cuda")
    chosen = Segmenter(lite, device="auto")
    assert chosen.device == "cpu"
    assert bits(chosen, *frame) == bits(Segmenter(lite), *frame)


def test_a_frame_is_segmented_the_same_with_and_without_a_cache(
    tmp_path: Path, lite: Model, frame: Frame
) -> None:
    cache = ImageCache(tmp_path / "cache.sqlite")
    plain = Segmenter(lite).segment(Modality.FUSION, *frame)
    for _ in range(2):
        cached = Segmenter(lite, cache=cache).segment(Modality.FUSION, *frame)
        assert np.array_equal(cached.labels, plain.labels)
        assert cached.entropy == plain.entropy
        assert not cached.labels.flags.writeable


def test_what_the_cache_has_is_not_computed(tmp_path: Path, lite: Model, frame: Frame) -> None:
    images = [LazyImage.of(array) for array in frame]
    segmenter = Segmenter(lite, cache=ImageCache(tmp_path / "cache.sqlite"))
    labels, entropy = segmenter.look_up(Modality.FUSION, *images)
    unseen = [LazyImage(each.size, _unwanted, name=lambda: b"", cache=None) for each in images]
    for image, known in zip(unseen, images, strict=True):
        image.digest = known.digest
    found, again = segmenter.look_up(Modality.FUSION, *unseen)
    assert (found.key, again) == (labels.key, entropy)
    assert np.array_equal(found.pixels, labels.pixels)


def test_weights_modality_and_inputs_are_told_apart(tmp_path: Path, lite: Model, frame: Frame) -> None:
    bgr, depth = (LazyImage.of(array) for array in frame)
    segmenter = Segmenter(lite, cache=ImageCache(tmp_path / "cache.sqlite"))
    darker = LazyImage.of(frame[0] // 2)
    keys = {
        segmenter.look_up(Modality.FUSION, bgr, depth)[0].key,
        segmenter.look_up(Modality.FUSION, darker, depth)[0].key,
        segmenter.look_up(Modality.RGB, bgr, depth)[0].key,
        segmenter.look_up(Modality.DEPTH, bgr, depth)[0].key,
    }
    assert len(keys) == 4
    assert segmenter.look_up(Modality.RGB, bgr, None)[0].key in keys


def _unwanted() -> npt.NDArray[np.uint8]:
    raise AssertionError("nobody needs the pixels")
