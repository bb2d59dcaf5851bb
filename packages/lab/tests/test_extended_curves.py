"""Faults of extensions that degrade images are measured, drawn and calibrated on like the paper's own."""

import json
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from tests.docs.test_docs import blocks

from sunset.calibration import Condition, effects, suite_strengths
from sunset.cli import main
from sunset.data import read_bag, write_bag
from sunset.errors import ExtensionError
from sunset.perception import Modality
from sunset.system import extended_system

pytestmark = pytest.mark.thorough

HAZE = """
import numpy as np

from sunset.nodes import Fusion, NodeParameter
from sunset.image_messages import array_of_bgr, image_of_bgr
from sunset.system import *


def add_haze(bgr, density):
    return np.clip(bgr * (1 - density) + 255 * density, 0, 255).astype(np.uint8)


def remove_haze(bgr, density):
    return np.clip((bgr - 255 * density) / (1 - density), 0, 255).astype(np.uint8)


class HazyFusion(Fusion):
    haze = NodeParameter(0.0, "external fault: how dense the haze is", minimum=0.0, maximum=0.95)

    def _on_rgb(self, message):
        super()._on_rgb(image_of_bgr(message.header, add_haze(array_of_bgr(message), self.haze)))


EXTENSION = Extension(
    node_classes={"sensor_fusion": HazyFusion},
    failures=(Failure("F6", "nothing is seen", "unsure", "sure", signal="segmentation_entropy"),),
    faults=(
        Fault(
            name="haze",
            failure="F6",
            node="sensor_fusion",
            kind=FaultKind.EXTERNAL,
            description="The colour images are hazy.",
            value=0.6,
            limits=(0.0, 0.95),
            cures=((Adaptation(AdaptationKind.SET_PARAMETER, "sensor_fusion", "modality", 1),),),
            effect=Effect(degrade=add_haze, RESTOREstrengths=(0.3, 0.9)),
        ),
    ),
)
"""

RNG = np.random.default_rng(5)
BGR = RNG.integers(0, 256, (48, 128, 3), dtype=np.uint8)
DEPTH = RNG.integers(1000, 5000, (48, 128), dtype=np.uint16)


@pytest.fixture(scope="module")
def bag(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    with read_bag(flight) as reader:
        taken = [reader.frame(index) for index in range(200, 205)]
        return write_bag(tmp_path_factory.mktemp("bags") / "five", taken, list(reader.stamps_ns[:5]))


@pytest.fixture
def haze(tmp_path: Path) -> Path:
    file = tmp_path / "haze.py"
    file.write_text(HAZE.replace("RESTORE", ""), encoding="utf-8")
    return file


@pytest.fixture
def dirt(tmp_path: Path) -> Path:
    """The page's own file."""
    (source,) = (block for block in blocks("docs/extending.md", "python") if block.startswith("# dirt.py"))
    file = tmp_path / "dirt.py"
    file.write_text(source, encoding="utf-8")
    return file


def test_curves_have_faults_of_extensions_too(
    bag: Path, haze: Path, dirt: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    curves = ["models", "curves", "--bag", str(bag), "--jobs", "1"]
    extensions = ["--extension", str(haze), "--extension", str(dirt)]
    assert main([*curves, "--at", "haze=0.7", *extensions, "--out", str(tmp_path / "out")]) == 0
    text = capsys.readouterr().out
    assert "cure of haze: set sensor_fusion.modality to 1" in text
    assert "cure of lens_dirt: restart camera" in text
    assert "lens_dirt at 3" in text

    found = json.loads((tmp_path / "out" / "curves.json").read_text(encoding="utf-8"))
    points = {
        (name, strength): case for case in found["faults"] for name, strength in case["strengths"].items()
    }
    assert [strength for name, strength in points if name == "haze"] == [0.3, 0.7, 0.9]
    dense, own = points["haze", 0.9], found["nominal"]["rgb"]
    assert dense["faulty"]["iou"] < points["haze", 0.3]["faulty"]["iou"] < found["nominal"]["fusion"]["iou"]
    assert dense["cured"] == own
    dirty = points["lens_dirt", 3.0]
    assert dirty["suite"]
    assert dirty["faulty"]["sharpness_auc"] == 1.0
    assert dirty["cured"] == found["nominal"]["fusion"]
    pairs = [set(case["strengths"]) for case in found["pairs"]]
    assert {"haze", "lens_dirt"} in pairs
    assert {"haze", "image_shift"} in pairs

    assert main([*curves, "--json"]) == 0  # without them, nothing else changes
    plain = json.loads(capsys.readouterr().out)
    assert plain["faults"] == [
        case for case in found["faults"] if not {"haze", "lens_dirt"} & {*case["strengths"]}
    ]


@pytest.mark.parametrize("restored", [False, True])
def test_a_cure_restores_what_the_description_says(restored: bool, haze: Path) -> None:
    haze.write_text(HAZE.replace("RESTORE", "restore=remove_haze, " if restored else ""), encoding="utf-8")
    with extended_system([haze]):
        assert suite_strengths()["haze"] == 0.6
        faulty = Condition(Modality.FUSION).with_faults({"haze": 0.5})
        np.testing.assert_array_equal(faulty.seen(BGR, DEPTH, RNG).bgr, (BGR * 0.5 + 127.5).astype(np.uint8))
        cured = faulty.cured_of("haze")
        assert (cured == Condition(Modality.RGB)) == (not restored)
        assert cured.modality is Modality.RGB
        assert np.abs(cured.seen(BGR, DEPTH, RNG).bgr.astype(int) - BGR).max() <= 2
    assert "haze" not in effects()


def test_what_an_effect_gets_wrong_is_one_sentence(
    bag: Path, haze: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    curves = ["models", "curves", "--bag", str(bag), "--extension", str(haze)]
    for jobs, mistake, sentence in (
        (2, "None", "must return an image of shape (144, 256, 3) and type uint8, got None and NoneType."),
        (1, "np.copyto(bgr, 0)", "The effect of the fault haze raised ValueError at the strength 0.6: "),
        (1, "bgr.missing", "The effect of the fault haze raised AttributeError at the strength 0.6: "),
    ):
        haze.write_text(
            HAZE.replace("RESTORE", "").replace("np.clip(bgr * ", f"{mistake} #"), encoding="utf-8"
        )
        assert main([*curves, "--jobs", str(jobs)]) == 2
        told = capsys.readouterr().err.splitlines()[-1]
        assert sentence in told


def test_an_effect_that_raises_is_an_error_of_its_extension(haze: Path) -> None:
    haze.write_text(HAZE.replace("RESTORE", "random=True, "), encoding="utf-8")
    with (
        extended_system([haze]),
        pytest.raises(ExtensionError, match=r"raised TypeError .* takes 2 positional"),
    ):
        Condition(Modality.RGB).with_faults({"haze": 0.5}).seen(BGR, DEPTH, RNG)


@pytest.mark.skipif(find_spec("onnx") is None, reason="calibrating needs onnx")
def test_a_model_is_calibrated_on_faults_of_extensions_too(
    bag: Path, haze: Path, dirt: Path, tmp_path: Path
) -> None:
    calibrate = ["models", "calibrate", "lite", "--bag", str(bag), "--jobs", "1"]
    extensions = ["--extension", str(haze), "--extension", str(dirt)]
    assert main([*calibrate, *extensions, "--out", str(tmp_path / "mine")]) == 0
    card = json.loads((tmp_path / "mine" / "card.json").read_text(encoding="utf-8"))
    faults = card["results"]["faults_at_suite_strength"]
    assert {"haze", "haze, cured", "lens_dirt", "lens_dirt, cured", "image_shift"} <= set(faults)
    assert faults["haze"]["strength"] == 0.6


@pytest.mark.skipif(find_spec("matplotlib") is None, reason="figures need matplotlib")
def test_the_figure_of_faults_has_those_of_extensions_that_show_in_the_entropy(
    haze: Path, dirt: Path, tmp_path: Path
) -> None:
    figure = tmp_path / "entropy.svg"
    extensions = ["--extension", str(haze), "--extension", str(dirt)]
    assert main(["faults", "figure", "--out", str(figure), "--duration", "1", *extensions]) == 0
    drawn = figure.read_text(encoding="utf-8")
    assert "<!-- haze -->" in drawn
    assert "<!-- image shift -->" in drawn
    assert "lens dirt" not in drawn
