import pickle
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sunset.errors import InvalidInputError, ModelError, OutputError
from sunset.perception import Modality, Segmenter
from sunset_lab import MODALITIES, TrainingConfig
from sunset_lab.frames import FrameSets
from sunset_lab.shapes import ReferenceShape

pytestmark = pytest.mark.thorough

torch = pytest.importorskip("torch")
pytest.importorskip("onnx")

from sunset_lab.importing import import_checkpoints  # noqa: E402
from sunset_lab.network import build, forward, rgb_input  # noqa: E402  needs torch

torch.set_num_threads(1)

Entries = dict[str, Any]


def light(modality: str = "rgb") -> Entries:
    """A state dict of the right names and shapes, whose file is small: each tensor repeats one number."""
    shape = ReferenceShape()
    config = TrainingConfig(shape=shape)
    layers = config.plan(MODALITIES) if modality == "fusion" else shape.network("", "")
    with torch.device("meta"):
        names = build(layers).state_dict()
    return {name: torch.zeros((), dtype=value.dtype).expand(value.shape) for name, value in names.items()}


def without(entries: Entries, *names: str) -> Entries:
    return {name: value for name, value in entries.items() if name not in names}


class Attack:
    def __reduce__(self) -> tuple[Callable[[str], Any], tuple[str]]:
        return Path.touch, (Path("attacked"),)  # type: ignore[return-value]


def test_the_published_state_dicts_become_a_model_that_computes_what_torch_computes(
    sets: FrameSets, tmp_path: Path
) -> None:
    torch.manual_seed(0)
    layers = TrainingConfig(shape=ReferenceShape()).plan(MODALITIES)
    modules = build(layers).eval()
    for prefix in ("rgb", "dth"):
        modules.get_parameter(f"{prefix}.classifier.4.weight").data.normal_(std=0.1)
    for name, values in modules.named_buffers():
        if values.is_floating_point():
            values.uniform_(*((0.5, 1.5) if name.endswith("running_var") else (-0.1, 0.1)))
    entries = modules.state_dict()
    torch.save(entries, tmp_path / "fusion.pth")
    for name, prefix in (("rgb", "rgb."), ("depth", "dth.")):
        branch = {key.removeprefix(prefix): entries[key] for key in entries if key.startswith(prefix)}
        torch.save(branch, tmp_path / f"{name}.pth")
    calls = []

    def progress(what: str, done: int, total: int) -> None:
        calls.append((what, done, total))

    model = import_checkpoints(
        tmp_path, tmp_path / "model", name="published", height=64, width=96, progress=progress
    )
    assert calls == [("Importing", done, 3) for done in range(4)]
    card = model.card
    assert list(card.networks) == list(Modality)
    assert (card.name, card.height, card.width) == ("published", 64, 96)
    assert (card.architecture, card.precision) == ("deeplabv3_resnet50", "float32")
    assert (card.entropy_threshold, card.sharpness_threshold) == (1.0, 0.0)
    assert "sunset models calibrate" in str(card.training["left_out"])
    bgr = np.ascontiguousarray(sets.test.bgr[0, :64, :96])
    depth = np.ascontiguousarray(sets.test.depth[0, :64, :96])
    share = torch.from_numpy(depth.astype(np.float32) / 65535).expand(1, 3, -1, -1)
    results = {"rgb.input": rgb_input(torch.from_numpy(bgr[np.newaxis])), "depth.input": share}
    with torch.no_grad():
        forward(layers, modules, results)
    segmenter = Segmenter(model)
    for modality in Modality:
        expected = results[f"{modality.key}.logits"][0].numpy()
        assert expected.std() > 0
        assert np.abs(segmenter.logits(modality, bgr, depth) - expected).max() < 1e-4


def test_one_checkpoint_makes_a_model_of_one_network(tmp_path: Path) -> None:
    torch.save(light(), tmp_path / "depth.pth")
    model = import_checkpoints(tmp_path, tmp_path / "model", name="x", height=16, width=16)
    assert list(model.card.networks) == [Modality.DEPTH]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (
            lambda d: without(d, "backbone.bn1.bias", "classifier.4.bias"),
            r'does not fit a deeplabv3_resnet50 with 28 classes: .* "backbone\.bn1\.bias", "classifier\.4\.bias"\.$',
        ),
        (
            lambda d: d | {"aux_classifier.4.bias": torch.zeros(28)},
            r'28 classes: Unexpected key\(s\) in state_dict: "aux_classifier\.4\.bias"\.$',
        ),
        (
            lambda d: d | {"classifier.4.weight": torch.zeros(21, 256, 1, 1)},
            r"size mismatch for classifier\.4\.weight: .*\[21, 256, 1, 1\].*\[28, 256, 1, 1\]\)\.$",
        ),
        (lambda d: d | {"classifier.4.bias": [0.0] * 28}, r'parameter named "classifier\.4\.bias"'),
        (
            lambda d: d | {"classifier.4.bias": torch.zeros(28, device="meta")},
            r'parameter named "classifier\.4\.bias"',
        ),
        (
            lambda d: d | {"classifier.4.bias": torch.full((28,), float("nan"))},
            r"has weights that are not finite as float32: .* import another",
        ),
        (
            lambda d: d | {"classifier.4.bias": torch.full((28,), 1e300, dtype=torch.float64)},
            r"has weights that are not finite as float32: .* import another",
        ),
        (
            lambda d: d | {"backbone.bn1.running_var": torch.linspace(1, -1, 64)},
            r"has weights that are not finite as float32: .* import another",
        ),
        (
            lambda d: (
                d
                | {"backbone.conv1.weight": torch.full((64, 3, 7, 7), 1e38)}
                | {"backbone.bn1.weight": torch.full((64,), 10.0)}
            ),
            r"has weights that are not finite as float32: .* import another",
        ),
        (lambda _: [torch.zeros(3)], r"must hold a state dict, tensors by name, got an unsuitable list\."),
        (lambda _: {}, r"does not fit a deeplabv3_resnet50"),
    ],
)
def test_a_checkpoint_of_something_else_is_refused_in_one_sentence(
    change: Callable[[Entries], object], sentence: str, tmp_path: Path
) -> None:
    torch.save(change(light()), tmp_path / "rgb.pth")
    with pytest.raises(ModelError, match=sentence) as refusal:
        import_checkpoints(tmp_path, tmp_path / "model", name="x")
    assert "\n" not in str(refusal.value)
    assert not (tmp_path / "model").exists()


@pytest.mark.parametrize("kind", [torch.float8_e5m2, torch.float64])
def test_other_floating_point_numbers_are_converted(kind: Any, tmp_path: Path) -> None:
    torch.save(
        {name: value.to(kind) if value.is_floating_point() else value for name, value in light().items()},
        tmp_path / "rgb.pth",
    )
    model = import_checkpoints(tmp_path, tmp_path / "model", name="x", height=16, width=16)
    assert model.card.networks[Modality.RGB].parameters > 39e6


def test_parameters_are_taken_as_tensors(tmp_path: Path) -> None:
    entries = {
        name: torch.nn.Parameter(value) if value.is_floating_point() else value
        for name, value in light().items()
    }
    torch.save(entries, tmp_path / "rgb.pth")
    model = import_checkpoints(tmp_path, tmp_path / "model", name="x", height=16, width=16)
    assert model.card.networks[Modality.RGB].parameters > 39e6


def test_a_fusion_needs_both_branches_and_its_merging_layers(tmp_path: Path) -> None:
    torch.save(without(light("fusion"), "merge.2.weight"), tmp_path / "fusion.pth")
    with pytest.raises(ModelError, match=r'28 classes: Missing key.*"merge\.2\.weight"\.$'):
        import_checkpoints(tmp_path, tmp_path / "model", name="x")


@pytest.mark.parametrize("content", [b"", b"weights", b"PK\x03\x04 cut off", pickle.dumps({"a": 1})[:-1]])
def test_a_file_that_is_no_checkpoint_is_refused_in_one_sentence(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "rgb.pth").write_bytes(content)
    with pytest.raises(ModelError, match=r"rgb\.pth cannot be read as a PyTorch checkpoint") as refusal:
        import_checkpoints(tmp_path, tmp_path / "model", name="x")
    assert "\n" not in str(refusal.value)


def test_a_checkpoint_with_a_flipped_bit_is_refused(tmp_path: Path) -> None:
    torch.save(light(), tmp_path / "rgb.pth")
    data = bytearray((tmp_path / "rgb.pth").read_bytes())
    data[len(data) // 2] ^= 1
    (tmp_path / "rgb.pth").write_bytes(data)
    with pytest.raises(ModelError, match=r"rgb\.pth cannot be read as a PyTorch checkpoint"):
        import_checkpoints(tmp_path, tmp_path / "model", name="x")


def test_a_truncated_checkpoint_is_refused(tmp_path: Path) -> None:
    torch.save(light(), tmp_path / "whole.pth")
    data = (tmp_path / "whole.pth").read_bytes()
    (tmp_path / "rgb.pth").write_bytes(data[: len(data) // 2])
    with pytest.raises(ModelError, match=r"rgb\.pth cannot be read as a PyTorch checkpoint"):
        import_checkpoints(tmp_path, tmp_path / "model", name="x")


def test_a_checkpoint_that_would_execute_code_does_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    torch.save({"model": Attack()}, tmp_path / "rgb.pth")
    with pytest.raises(ModelError, match="refers to code, which is not executed"):
        import_checkpoints(tmp_path, tmp_path / "model", name="x")
    assert not (tmp_path / "attacked").exists()


def test_a_folder_without_checkpoints_is_named(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"has none of the checkpoints rgb\.pth, depth\.pth and fusion\.pth"):
        import_checkpoints(tmp_path, tmp_path / "model", name="x")


@pytest.mark.parametrize(("width", "height"), [(100, 64), (96, 0), (96, 20)])
def test_a_size_that_the_networks_cannot_take_is_refused(width: int, height: int, tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match=f"multiples of 8, of at most 4096, got {width}x{height}"):
        import_checkpoints(tmp_path, tmp_path / "model", name="x", height=height, width=width)


@pytest.mark.skipif(sys.platform == "win32", reason="folders are files with other errors there")
def test_a_model_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    torch.save(light(), tmp_path / "rgb.pth")
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(OutputError, match=r"The model .*file/model cannot be written"):
        import_checkpoints(tmp_path, tmp_path / "file" / "model", name="x", height=16, width=16)


def test_a_name_that_no_card_can_hold_is_refused_before_the_work(tmp_path: Path) -> None:
    torch.save(light(), tmp_path / "rgb.pth")
    with pytest.raises(InvalidInputError, match="UTF-8"):
        import_checkpoints(tmp_path, tmp_path / "model", name="a\udcff", height=16, width=16)
    assert not (tmp_path / "model").exists()
