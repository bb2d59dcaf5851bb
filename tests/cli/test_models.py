"""`sunset models`: measuring, calibrating, and what a user gets wrong with it."""

import csv
import json
import re
import shutil
import sys
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sunset
from sunset.cli import main
from sunset.data import Frame, read_bag, write_bag
from sunset.perception import load_model
from sunset_lab.curves_text import as_json
from sunset_lab.shapes import ReferenceShape

ARGUMENTS: dict[str, tuple[Sequence[str], str]] = {
    "curves of an unknown model": (["curves", "huge"], "huge"),
    "curves of a folder that is no model": (["curves", "."], "card.json"),
    "curves over a missing bag": (["curves", "--bag", "nowhere"], "nowhere"),
    "curves of no group": (["curves", "--every", "0"], "at least 1, got '0'"),
    "curves without a process": (["curves", "--jobs", "0"], "at least 1, got '0'"),
    "curves at an unknown fault": (["curves", "--at", "rotor_failure=1"], "rotor_failure"),
    "curves at no number": (["curves", "--at", "image_shift=wide"], "image_shift=wide"),
    "curves at nothing": (["curves", "--at", "image_shift"], "such as image_shift=8"),
    "curves out of range": (["curves", "--at", "image_degradation=7"], "at most 1.9, got 7"),
    "curves at half a pixel": (["curves", "--at", "image_shift=2.5"], "whole number"),
    "curves into a file": (["curves", "--out", "file"], "file"),
    "calibrating an unknown model": (["calibrate", "huge"], "huge"),
    "calibrating nothing": (["calibrate"], "model"),
    "calibrating a model of the package": (["calibrate", "lite"], "--out"),
    "calibrating over a folder": (["calibrate", "lite", "--bag", "bag", "--out", "."], "exists"),
    "calibrating on a missing bag": (["calibrate", "lite", "--bag", "nowhere", "--out", "o"], "nowhere"),
    "calibrating on too little": (["calibrate", "lite", "--bag", "short", "--out", "o"], "got 1 of"),
    "IoU of an unknown model": (["iou", "lite", "huge"], "huge"),
    "IoU of no frame": (["iou", "--frames", "0"], "at least 1, got '0'"),
    "IoU into a file": (["iou", "--out", "file"], "file"),
    "importing nothing": (["import", ".", "--size", "256", "--out", "o"], "such as 256x144, got '256'"),
    "importing from nothing": (["import", "nowhere"], "rgb.pth, depth.pth and fusion.pth"),
    "importing over a folder": (["import", ".", "--out", "."], "exists"),
    "importing at an odd size": (["import", ".", "--size", "30x20", "--out", "o"], "got 30x20"),
    "importing with a name that is no text": (["import", ".", "--out", "o", "--name", "a\udcff"], "UTF-8"),
    "importing into a folder whose name is no text": (["import", ".", "--out", "a\udcff"], "UTF-8"),
    "importing over a model": (["import", "old"], "--out"),
    "calibrating on a missing device": (
        ["calibrate", "lite", "--out", "o", "--device", "cuda"],
        "onnxruntime-gpu",
    ),
    "curves on a missing device": (["curves", "--device", "cuda"], "onnxruntime-gpu"),
    "iou on a missing device": (["iou", "--device", "cuda"], "onnxruntime-gpu"),
    "an unknown action": (["paint"], "paint"),
}

NEEDS_TRAIN = {
    "calibrating a model of the package",
    "calibrating over a folder",
    "calibrating on a missing bag",
    "calibrating on too little",
    "calibrating on a missing device",
    "importing from nothing",
    "importing at an odd size",
    "importing with a name that is no text",
    "importing into a folder whose name is no text",
}
"""Without the extra `train`, these end with the sentence that names it."""


@pytest.fixture(scope="module")
def bag(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five frames of the default flight."""
    with read_bag(flight) as reader:
        frames = [reader.frame(index) for index in range(5)]
        return write_bag(tmp_path_factory.mktemp("bags") / "five", frames, list(reader.stamps_ns[:5]))


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """A user's own model, which sees depth only."""
    folder = tmp_path / "own"
    folder.mkdir()
    lite = load_model("lite").folder
    card = json.loads((lite / "card.json").read_text(encoding="utf-8"))
    card["networks"] = {"depth": card["networks"]["depth"]}
    for file in (card["networks"]["depth"]["file"], *card["networks"]["depth"].get("data", {})):
        shutil.copy(lite / file, folder / file)
    (folder / "card.json").write_text(json.dumps(card | {"name": "own"}), encoding="utf-8")
    return folder


@pytest.mark.parametrize("case", ARGUMENTS)
def test_a_bad_argument(
    case: str, bag: Path, tmp_path: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    (tmp_path / "old-model").mkdir()
    (tmp_path / "bag").symlink_to(bag)
    with read_bag(bag) as reader:
        write_bag(tmp_path / "short", [reader.frame(0)], [0])
    arguments, word = ARGUMENTS[case]
    if case in NEEDS_TRAIN and not (find_spec("onnx") and find_spec("torch")):
        word = "pip install 'sunset-exemplar[train]'"

    assert word in complaint(["models", *arguments])


def test_curves_are_printed_and_written(
    model: Path, bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib")
    out = tmp_path / "new" / "curves"
    command = ["models", "curves", str(model), "--bag", str(bag), "--at", "depth_degradation=0.25"]

    assert main([*command, "--jobs", "1", "--out", str(out)]) == 0
    text = capsys.readouterr().out
    assert main([*command, "--jobs", "1", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)

    assert text.startswith("own, version ")
    assert any(line.split()[:2] == ["depth_degradation", "0.25*"] for line in text.splitlines())
    assert "image_shift" not in text  # it cannot see it
    assert json.loads((out / "curves.json").read_text(encoding="utf-8")) == found
    rows = list(csv.DictReader((out / "curves.csv").read_text(encoding="utf-8").splitlines()))
    assert [row["strengths"] for row in rows if row["suite"] == "1"] == ["0.25"]
    assert {path.name for path in out.iterdir()} == {
        "curves.csv",
        "curves.json",
        "severities.json",
        "curves.png",
        "cures.png",
    }


@pytest.mark.thorough
def test_curves_need_no_matplotlib(
    model: Path,
    bag: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)

    command = ["models", "curves", str(model), "--bag", str(bag), "--jobs", "1", "--out", str(tmp_path / "o")]
    assert main(command) == 0

    told = capsys.readouterr().err.strip().splitlines()[-1]
    assert told.startswith("The figures were left out because matplotlib is not installed")
    assert {path.name for path in (tmp_path / "o").iterdir()} == {
        "curves.csv",
        "curves.json",
        "severities.json",
    }


@pytest.mark.thorough
def test_iou_is_printed_and_written(
    model: Path, flight: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    del flight
    command = ["models", "iou", str(model), "--frames", "2", "--jobs", "1"]

    assert main([*command, "--out", str(tmp_path / "o")]) == 0
    text = capsys.readouterr().out
    assert main([*command, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)

    assert text == (tmp_path / "o" / "iou.md").read_text(encoding="utf-8")
    rows = list(csv.DictReader((tmp_path / "o" / "iou.csv").read_text(encoding="utf-8").splitlines()))
    (value,) = [
        row["iou"] for row in rows if (row["frames"], row["measure"]) == ("town 7", "mean over frames")
    ]
    mean = found["frames"]["town 7"]["networks"]["own depth"]["mean_over_frames"]
    assert float(value) == pytest.approx(mean, rel=1e-5)
    assert f"{mean:.3f}" in text


@pytest.mark.thorough
def test_a_model_is_calibrated_on_a_bag(
    model: Path, bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("onnx")
    named = shutil.copytree(bag, tmp_path / "five\udcff")  # whose name no card can hold

    assert (
        main(
            [
                "models",
                "calibrate",
                str(model),
                "--bag",
                str(named),
                "--jobs",
                "1",
                "--out",
                str(tmp_path / "o"),
            ]
        )
        == 0
    )

    printed = dict(line.rsplit(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    card = load_model(tmp_path / "o").card
    assert float(printed["entropy threshold"]) == pytest.approx(card.entropy_threshold, abs=1e-4)
    assert printed["depth temperature"] == "1.0000"
    assert "5 frames: the bag five\ufffd" in str(card.results["measured_on"])


@pytest.mark.thorough
def test_a_calibration_says_where_the_model_sees_nothing_in_the_frames(
    model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("onnx")
    random = np.random.default_rng(1)
    size, kinds = (144, 256), ((3, np.uint8), (1, np.uint16), (1, np.uint8))
    noise = [
        Frame(*(random.integers(0, 16, (*size, depth), kind).squeeze() for depth, kind in kinds))
        for _ in range(5)
    ]
    bag = write_bag(tmp_path / "noise", noise, [number * 10**8 for number in range(5)])

    command = ["models", "calibrate", str(model), "--jobs", "1", "--bag"]
    assert main([*command, str(bag), "--out", str(tmp_path / "mine")]) == 0

    told = capsys.readouterr().err
    assert re.search(r"segments healthy frames with an IoU of 0\.0\d only", told)
    assert load_model(tmp_path / "mine").card.name == "mine"


@pytest.mark.thorough
def test_a_model_without_fusion_is_said_not_to_do_for_a_run(
    model: Path, bag: Path, complaint: Callable[[Sequence[str]], str], capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("onnx")

    assert main(["models", "calibrate", str(model), "--bag", str(bag), "--jobs", "1"]) == 0
    told = capfd.readouterr().err.strip().splitlines()[-1]
    assert told.endswith("is calibrated; a run also needs fusion and rgb.")

    assert "'own' lacks fusion and rgb, which a run needs, since" in complaint(["run", "--model", "own"])


def checkpoint(path: Path, **other: Any) -> None:
    """Write the published network's state dict: zeros, but for some of the entries of `backbone.bn1`."""
    torch = pytest.importorskip("torch")
    from sunset_lab.network import build  # noqa: PLC0415  needs torch

    with torch.device("meta"):
        names = build(ReferenceShape().network("", "")).state_dict()
    entries = {name: torch.zeros((), dtype=like.dtype).expand(like.shape) for name, like in names.items()}
    path.parent.mkdir()
    torch.save(entries | {f"backbone.bn1.{name}": value for name, value in other.items()}, path)


@pytest.mark.thorough
def test_an_import_makes_a_folder_named_after_the_checkpoints(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    complaint: Callable[[Sequence[str]], str],
) -> None:
    pytest.importorskip("onnx")
    checkpoint(tmp_path / "weights" / "rgb.pth")
    monkeypatch.chdir(tmp_path)

    assert main(["models", "import", "weights", "--size", "16x16"]) == 0

    told = capfd.readouterr().err
    assert "run 'sunset models calibrate weights-model' next" in told
    assert told.strip().endswith("a run also needs fusion and depth.")
    assert load_model("weights-model").card.name == "weights-model"
    assert "weights-model exists" in complaint(["models", "import", "weights"])
    assert "lacks fusion and depth, which a run needs" in complaint(["run", "--model", "weights-model"])


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("number", "kind", "words"),
    [
        (0.0, "meta", "does not fit a deeplabv3_resnet50"),
        (1e300, "float64", "not finite as float32"),
        (float("nan"), "float8_e4m3fn", "not finite as float32"),
        (-1.0, "float32", "not finite as float32"),
    ],
)
def test_a_checkpoint_with_impossible_numbers(
    number: float, kind: str, words: str, tmp_path: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    torch = pytest.importorskip("torch")
    pytest.importorskip("onnx")
    variances = torch.full((64,), number, dtype=torch.float64)
    variances = variances.to("meta") if kind == "meta" else variances.to(getattr(torch, kind))
    checkpoint(tmp_path / "weights" / "rgb.pth", running_var=variances)

    assert words in complaint(["models", "import", "weights"])


@pytest.mark.thorough
def test_a_call_without_options_measures_what_its_command_measures(
    model: Path, flight: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with read_bag(flight) as reader:
        frames = [reader.frame(index) for index in range(6)]
        six = write_bag(tmp_path / "six", frames, list(reader.stamps_ns[:6]))

    assert (
        main(["models", "curves", str(model), "--bag", str(six), "--at", "depth_degradation=0.25", "--json"])
        == 0
    )

    printed = json.loads(capsys.readouterr().out)
    curves = sunset.measure_curves(model, six, strengths={"depth_degradation": 0.25})
    assert curves.frames == 6
    assert json.loads(json.dumps(as_json(curves))) == printed
    assert signature(sunset.measure_iou).parameters["frames"].default is None  # as of the command
