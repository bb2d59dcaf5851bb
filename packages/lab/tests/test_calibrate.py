"""Calibration of a model on a handful of frames."""

import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from sunset.calibration import window_means
from sunset.data import read_bag, write_bag
from sunset.errors import DataError, InvalidInputError, ModelError, OutputError
from sunset.perception import Modality, Segmenter, load_model
from sunset_lab import FrameSet, frames_of_bag, validation_flight

pytestmark = pytest.mark.thorough

onnx = pytest.importorskip("onnx")

from sunset_lab.calibrate import calibrate_model, set_temperature  # noqa: E402  needs onnx


@pytest.fixture(scope="module")
def bag(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    with read_bag(flight) as reader:
        taken = [reader.frame(index) for index in range(200, 205)]
        return write_bag(tmp_path_factory.mktemp("bags") / "five", taken, list(reader.stamps_ns[:5]))


@pytest.fixture(scope="module")
def frames(bag: Path) -> FrameSet:
    return frames_of_bag(bag)


def seal(folder: Path) -> None:
    """Put the checksums of the networks on the card."""
    card = json.loads((folder / "card.json").read_text(encoding="utf-8"))
    for network in card["networks"].values():
        network["sha256"] = hashlib.sha256((folder / network["file"]).read_bytes()).hexdigest()
    (folder / "card.json").write_text(json.dumps(card), encoding="utf-8")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A user's own model, with temperatures that are nobody's."""
    own = tmp_path / "mine"
    shutil.copytree(load_model("lite").folder, own)
    for modality in Modality:
        set_temperature(own / f"{modality.key}.onnx", 3.0)
    seal(own)
    return own


def only(folder: Path, modality: Modality) -> Path:
    """Take a model's other networks away."""
    kept = load_model(folder).card.networks[modality].files
    card = json.loads((folder / "card.json").read_text(encoding="utf-8"))
    card["networks"] = {modality.key: card["networks"][modality.key]}
    (folder / "card.json").write_text(json.dumps(card), encoding="utf-8")
    for path in folder.iterdir():
        if path.name not in {*kept, "card.json", "card.md"}:
            path.unlink()
    return folder


@pytest.fixture
def small(folder: Path) -> Path:
    """The same with one network only."""
    return only(folder, Modality.DEPTH)


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_copy_has_one_entropy_for_all_networks_and_thresholds_that_part(
    folder: Path, frames: FrameSet, tmp_path: Path
) -> None:
    before = contents(folder)
    steps: list[tuple[str, int, int]] = []

    def progress(what: str, done: int, total: int) -> None:
        steps.append((what, done, total))

    calibrated = calibrate_model(
        load_model(folder), frames, tmp_path / "new" / "out", source="a few", jobs=1, stages=progress
    )

    card, segmenter = calibrated.card, Segmenter(calibrated)
    pairs = list(zip(frames.bgr, frames.depth, strict=True))
    entropies = [
        np.array([segmenter.segment(modality, *pair).entropy for pair in pairs]) for modality in Modality
    ]
    means = [float(values.mean()) for values in entropies]
    assert means == pytest.approx([means[0]] * 3, rel=0.03)  # every third pixel is looked at
    assert card.networks[Modality.FUSION].temperature == 1.0
    assert all(window_means(values, 1).max() < card.entropy_threshold for values in entropies)
    rows = card.results["faults_at_suite_strength"]
    assert isinstance(rows, dict)
    assert rows["depth_degradation"]["over"] == rows["autofocus_needed"]["under"] == 1.0
    assert rows["nominal, fusion"]["over"] == rows["nominal, fusion"]["under"] == 0.0
    assert rows["depth_degradation, cured"]["iou"] == rows["nominal, rgb"]["iou"]
    assert card.results["measured_on"] == "5 frames: a few"
    assert steps[-1] == ("Measuring", 5, 5)
    assert contents(folder) == before
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == ["out"]


def test_a_model_of_ones_own_is_changed_in_its_place(small: Path, frames: FrameSet) -> None:
    (small / "notes.txt").write_text("mine", encoding="utf-8")
    files = sorted({*contents(small), "card.md"})
    model = load_model(small)

    calibrated = calibrate_model(model, frames, jobs=1)

    assert calibrated.folder == small
    assert calibrated.card.version != model.card.version
    assert calibrated.card.networks[Modality.DEPTH].temperature == 1.0
    assert calibrated.card.sharpness_threshold == 0.0  # it sees no colour image that could be blurred
    assert sorted(contents(small)) == files
    again = calibrate_model(load_model(small), frames, jobs=2)
    assert again.card == calibrated.card


def test_a_model_in_the_current_folder_is_calibrated(
    small: Path, frames: FrameSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    (small / "inner").mkdir()
    for folder, name in ((small, "."), (small / "inner", "..")):
        monkeypatch.chdir(folder)
        assert (
            calibrate_model(load_model(name), frames, jobs=1).card.networks[Modality.DEPTH].temperature == 1.0
        )


def test_weights_beside_a_network_are_kept_and_shared(small: Path, frames: FrameSet, tmp_path: Path) -> None:
    network = onnx.load(small / "depth.onnx")
    onnx.save(network, small / "depth.onnx", save_as_external_data=True, location="weights.bin")
    card = json.loads((small / "card.json").read_text(encoding="utf-8"))
    digest = hashlib.sha256((small / "weights.bin").read_bytes()).hexdigest()
    card["networks"]["depth"]["data"] = {"weights.bin": digest}
    (small / "card.json").write_text(json.dumps(card), encoding="utf-8")
    seal(small)

    calibrated = calibrate_model(load_model(small), frames, tmp_path / "out", jobs=1)

    assert calibrated.card.networks[Modality.DEPTH].data == {"weights.bin": digest}
    assert {"weights.bin", "depth.onnx"} < set(contents(tmp_path / "out"))


def test_an_interrupted_calibration_changes_nothing(small: Path, frames: FrameSet) -> None:
    before = contents(small)

    def interrupt(what: str, done: int, total: int) -> None:
        del total
        if (what, done) == ("Measuring", 3):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        calibrate_model(load_model(small), frames, jobs=1, stages=interrupt)
    assert contents(small) == before


def test_a_model_of_the_package_is_not_changed(frames: FrameSet) -> None:
    with pytest.raises(InvalidInputError, match="'lite' is an installed one and is not changed"):
        calibrate_model(load_model("lite"), frames)


def test_a_folder_that_is_there_is_not_written_over(small: Path, frames: FrameSet, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    with pytest.raises(OutputError, match="out exists"):
        calibrate_model(load_model(small), frames, tmp_path / "out")


def test_a_folder_that_cannot_be_made_is_named(small: Path, frames: FrameSet, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(OutputError, match=r"The model .*file/out cannot be written"):
        calibrate_model(load_model(small), frames, tmp_path / "file" / "out")


def test_too_few_frames_are_refused(small: Path, frames: FrameSet) -> None:
    few = FrameSet(frames.bgr[:4], frames.depth[:4], frames.labels[:4])
    with pytest.raises(DataError, match="at least 5 frames of 256x144 pixels, got 4 of 256x144"):
        calibrate_model(load_model(small), few)


def test_frames_that_show_nothing_are_refused(folder: Path) -> None:
    blank = FrameSet(
        np.zeros((5, 144, 256, 3), np.uint8),
        np.zeros((5, 144, 256), np.uint16),
        np.zeros((5, 144, 256), np.uint8),
    )
    with pytest.raises(DataError, match="tell nothing about a threshold"):
        calibrate_model(load_model(only(folder, Modality.RGB)), blank, jobs=1)


def test_a_network_without_a_temperature_is_refused(small: Path, frames: FrameSet) -> None:
    network = onnx.load(small / "depth.onnx")
    for thing in (*network.graph.initializer, *network.graph.node):
        if thing.name == "temperature":
            thing.name = "warmth"
        if "temperature" in getattr(thing, "input", ()):
            thing.input[list(thing.input).index("temperature")] = "warmth"
    (small / "depth.onnx").write_bytes(network.SerializeToString())
    seal(small)
    with pytest.raises(ModelError, match=r"depth.onnx has no constant 'temperature'"):
        calibrate_model(load_model(small), frames)


def test_frames_of_a_bag_are_those_of_the_bag(bag: Path, frames: FrameSet) -> None:
    with read_bag(bag) as reader:
        np.testing.assert_array_equal(frames.bgr[3], reader.frame(3).rgb)
        np.testing.assert_array_equal(frames.depth[3], reader.frame(3).depth)
    assert frames.labels.max() < 28
    assert len(frames) == 5


def test_the_validation_flight_is_rendered_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(tmp_path))
    steps: list[tuple[str, int, int]] = []

    def progress(what: str, done: int, total: int) -> None:
        steps.append((what, done, total))

    one = validation_flight((144, 256), count=1, jobs=1, progress=progress)
    other = validation_flight((144, 256), count=1, jobs=1, progress=progress)
    assert one.bgr.shape == (2, 144, 256, 3)
    np.testing.assert_array_equal(one.bgr, other.bgr)
    assert not np.array_equal(one.bgr[0], one.bgr[1])  # two courses
    assert [(done, total) for _, done, total in steps] == [(0, 1), (1, 1), (0, 1), (1, 1)]


def test_without_onnx_the_extra_is_named() -> None:
    program = "import sys; sys.modules['onnx'] = None; import sunset; sunset.calibrate_model('lite')"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "MissingExtraError: Calibrating needs onnx, not installed" in done.stderr
