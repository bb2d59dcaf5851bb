from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sunset.perception import Modality, ModelCard
from sunset_lab import MODALITIES, TrainingConfig
from sunset_lab.frames import FrameSets
from sunset_lab.shapes import LiteShape, ReferenceShape

pytestmark = pytest.mark.thorough

torch = pytest.importorskip("torch")
onnx = pytest.importorskip("onnx")
onnxruntime = pytest.importorskip("onnxruntime")

from sunset_lab.network import build, depth_input, folded_weights, forward, ranges, rgb_input  # noqa: E402
from sunset_lab.onnx_graph import Format, Network, export  # noqa: E402
from sunset_lab.onnx_layers import Store  # noqa: E402

torch.set_num_threads(1)  # the networks are tiny, and other tests run beside

FRAMES = 4
SHAPES: dict[str, LiteShape | ReferenceShape] = {
    "lite": LiteShape(16, (16, 16, 16), (1, 1, 1), pyramid=16, rates=(2,), skips=(16, 16), decoder=16),
    "reference": ReferenceShape(16, (1, 1, 1, 1), pyramid=16),
}
NEEDED = {Modality.RGB: ("bgr",), Modality.DEPTH: ("depth",), Modality.FUSION: ("bgr", "depth")}


def learned(config: TrainingConfig, sets: FrameSets) -> tuple[Any, dict[str, Any]]:
    """Modules with running statistics of their own, and what they make of four frames."""
    torch.manual_seed(0)
    layers = config.plan(MODALITIES)
    modules = build(layers)
    inputs = {
        "rgb.input": rgb_input(torch.from_numpy(sets.test.bgr[:FRAMES])),
        "depth.input": depth_input(torch.from_numpy(sets.test.depth[:FRAMES].astype(np.float32))),
    }
    with torch.no_grad():
        for module in modules.modules():
            if isinstance(module, torch.nn.BatchNorm2d):
                module.momentum = 1.0
        for name, parameter in modules.named_parameters():
            if "merge" in name or "classifier.4" in name:
                parameter.normal_(std=0.1)  # or logits are near zero
        forward(layers, modules.train(), dict(inputs))
        results: dict[str, Any] = dict(inputs)
        forward(layers, modules.eval(), results)
    return modules, results


CARD = {"name": "tiny", "description": "random", "architecture": "random"}


def networks(config: TrainingConfig, modules: Any) -> dict[Modality, Network]:
    weights = folded_weights(config.plan(MODALITIES), modules)
    return {modality: Network(config.layers(modality.key), weights) for modality in Modality}


def run(path: Path, modality: Modality, sets: FrameSets, index: int) -> list[Any]:
    session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
    raw: Mapping[str, Any] = {"bgr": sets.test.bgr[index], "depth": sets.test.depth[index]}
    feed = {name: raw[name] for name in NEEDED[modality]}
    outputs: list[Any] = session.run(["logits", "labels", "entropy"], feed)
    return outputs


@pytest.mark.parametrize("architecture", SHAPES)
def test_onnx_runtime_computes_what_torch_computes(
    architecture: str, sets: FrameSets, tmp_path: Path
) -> None:
    config = TrainingConfig(shape=SHAPES[architecture])
    modules, results = learned(config, sets)
    export(tmp_path, networks(config, modules), Format(), CARD)
    cards = ModelCard.read(tmp_path / "card.json").networks
    for modality in Modality:
        for index in range(FRAMES):
            logits, labels, entropy = run(tmp_path / cards[modality].file, modality, sets, index)
            expected = results[f"{modality.key}.logits"][index : index + 1]
            assert np.abs(logits - expected.numpy()).max() < 1e-4
            full = torch.nn.functional.interpolate(expected.double(), (144, 256), mode="bilinear")
            assert (labels == full.argmax(1)[0].numpy()).mean() > 0.999  # ties fall either way
            softmax = (full).softmax(1)
            nats = -(softmax * softmax.log()).sum(1).mean()
            assert entropy == pytest.approx(float(nats) / np.log(28), abs=1e-4)


def test_networks_in_8_bits_do_about_what_exact_ones_do(sets: FrameSets, tmp_path: Path) -> None:
    config = TrainingConfig(shape=SHAPES["reference"])
    modules, results = learned(config, sets)
    limits = ranges(config.plan(("rgb", "depth")), modules, sets.test)
    export(tmp_path, networks(config, modules), Format(ranges=limits), CARD)
    cards = ModelCard.read(tmp_path / "card.json").networks
    for modality in Modality:
        logits, _, _ = run(tmp_path / cards[modality].file, modality, sets, 0)
        expected = results[f"{modality.key}.logits"][0:1].numpy()
        error = np.abs(logits - expected).mean() / np.abs(expected - expected.mean()).mean()
        assert 0 < error < 0.2
    graph = onnx.load(tmp_path / "rgb.onnx").graph
    kinds = {value.name: value.data_type for value in graph.initializer}
    assert kinds["rgb.backbone.layer1.0.conv1.kernel.8bit"] == onnx.TensorProto.INT8


def test_what_the_fusion_shares_with_its_branches_is_stored_once(sets: FrameSets, tmp_path: Path) -> None:
    config = TrainingConfig(shape=SHAPES["reference"])
    modules, _ = learned(config, sets)
    export(tmp_path, networks(config, modules), Format(), CARD)
    cards = ModelCard.read(tmp_path / "card.json").networks
    assert list(cards[Modality.RGB].data) == ["rgb.bin"]
    assert list(cards[Modality.DEPTH].data) == ["depth.bin"]
    assert list(cards[Modality.FUSION].data) == ["depth.bin", "rgb.bin"]
    parameters = {modality: card.parameters for modality, card in cards.items()}
    merging = 2 * 56 * 57 + 28 * 57
    assert parameters[Modality.FUSION] == parameters[Modality.RGB] + parameters[Modality.DEPTH] + merging
    stored = sum((tmp_path / name).stat().st_size for name in ("rgb.bin", "depth.bin"))
    assert stored < 4 * parameters[Modality.FUSION]


def test_weights_are_stored_by_content(tmp_path: Path) -> None:
    store = Store(tmp_path)
    assert store.place(b"first", "a.bin") == ("a.bin", 0)
    assert store.place(b"second", "b.bin") == ("b.bin", 0)
    assert store.place(b"third", "a.bin") == ("a.bin", 64)
    assert store.place(b"first", "b.bin") == ("a.bin", 0)
    store.write()
    assert (tmp_path / "a.bin").read_bytes() == b"first".ljust(64, b"\0") + b"third"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.bin", "b.bin"]


def test_frames_of_another_size_are_taken_too(sets: FrameSets, tmp_path: Path) -> None:
    config = TrainingConfig(shape=SHAPES["reference"])
    modules, _ = learned(config, sets)
    export(tmp_path, networks(config, modules), Format(size=(72, 128), published_depth=True), CARD)
    cards = ModelCard.read(tmp_path / "card.json").networks
    session = onnxruntime.InferenceSession(tmp_path / cards[Modality.DEPTH].file)
    depth = sets.test.depth[0, :72, :128]
    (logits,) = session.run(["logits"], {"depth": depth})
    share = torch.from_numpy(depth.astype(np.float32) / 65535).expand(1, 3, -1, -1)
    results = {"depth.input": share}
    with torch.no_grad():
        forward(config.layers("depth"), modules, results)
    assert np.abs(logits - results["depth.logits"].numpy()).max() < 1e-4
