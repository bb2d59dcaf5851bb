import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sunset.errors import InvalidInputError, OutputError
from sunset.perception import Modality, Segmenter
from sunset.training import FrameSets, NetworkShape, Schedule, TrainingConfig, train_on

torch = pytest.importorskip("torch")
pytest.importorskip("onnx")

from sunset.training.loop import fit  # noqa: E402  needs torch
from sunset.training.network import build, depth_input, folded_weights, forward, rgb_input  # noqa: E402
from sunset.training.onnx_graph import export  # noqa: E402  needs onnx

torch.set_num_threads(1)  # the networks are tiny, and other tests run beside

TINY = TrainingConfig(
    name="tiny",
    shape=NetworkShape(16, (16, 16, 16), (1, 1, 1), pyramid=16, rates=(2,), skips=(16, 16), decoder=16),
    schedule=Schedule(steps=6, batch=2, learning_rate=5e-3, warm_up=2, checkpoint_every=3, log_every=2),
)


def test_onnx_runtime_computes_what_torch_computes(sets: FrameSets, tmp_path: Path) -> None:
    onnxruntime = pytest.importorskip("onnxruntime")
    torch.manual_seed(0)
    layers = TINY.all_layers()
    modules = build(layers)
    inputs = {
        "rgb.input": rgb_input(torch.from_numpy(sets.test.bgr[:4])),
        "depth.input": depth_input(torch.from_numpy(sets.test.depth[:4].astype(np.float32))),
    }
    modules.train()
    with torch.no_grad():
        forward(layers, modules, dict(inputs))  # running statistics of its own
        modules.eval()
        results: dict[str, Any] = dict(inputs)
        forward(layers, modules, results)
    weights = folded_weights(layers, modules)
    for name, sources in (("rgb", ("rgb",)), ("depth", ("depth",)), ("fusion", ("rgb", "depth"))):
        path = tmp_path / f"{name}.onnx"
        export(path, TINY.layers(name), weights, inputs=sources, temperature=1.5, dtype=np.float32)
        session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
        raw: dict[str, tuple[str, Any]] = {"rgb": ("bgr", sets.test.bgr), "depth": ("depth", sets.test.depth)}
        for index in range(4):
            feed = {raw[source][0]: raw[source][1][index] for source in sources}
            (logits,) = session.run(["logits"], feed)
            expected = results[f"{name}.logits"][index : index + 1].numpy()
            assert np.abs(logits - expected).max() < 1e-4


def test_a_run_writes_a_model_with_its_card_and_log(sets: FrameSets, tmp_path: Path) -> None:
    calls: list[tuple[str, int, int]] = []
    model = train_on(
        TINY,
        sets,
        tmp_path / "tiny",
        work=tmp_path / "work",
        progress=lambda what, done, total: calls.append((what, done, total)),
    )
    assert calls == [("steps", step, 6) for step in range(1, 7)]
    assert model.card.name == "tiny"
    assert set(model.card.networks) == set(Modality)
    assert 0 < model.card.entropy_threshold < 1
    assert (tmp_path / "tiny" / "card.md").read_text(encoding="utf-8").startswith("# tiny, version ")
    lines = [json.loads(line) for line in (tmp_path / "work" / "log.jsonl").read_text("utf-8").splitlines()]
    assert [line["step"] for line in lines] == [2, 4, 6]
    assert all(line[name] > 0 for line in lines for name in ("rgb", "depth", "fusion"))
    segmenter = Segmenter(model)
    means = [
        np.mean([segmenter.segment(m, *pair).entropy for pair in zip(flight.bgr, flight.depth, strict=True)])
        for flight in (sets.validation_flight,)
        for m in Modality
    ]
    assert means == pytest.approx([means[0]] * 3, abs=2e-3)  # one threshold serves all networks


def test_one_branch_alone_makes_a_model(sets: FrameSets, tmp_path: Path) -> None:
    config = TrainingConfig(name="tiny", modalities=("depth",), shape=TINY.shape, schedule=TINY.schedule)
    model = train_on(config, sets, tmp_path / "out", work=tmp_path / "work")
    assert list(model.card.networks) == [Modality.DEPTH]


def test_a_resumed_run_learns_what_an_undisturbed_one_learns(sets: FrameSets, tmp_path: Path) -> None:
    whole = fit(TINY, sets.train, tmp_path / "whole")

    def stop(done: int, _: int) -> None:
        if done == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fit(TINY, sets.train, tmp_path / "parts", progress=stop)
    resumed = fit(TINY, sets.train, tmp_path / "parts", resume=True)
    for name, (kernel, bias) in whole.items():
        assert np.array_equal(kernel, resumed[name][0])
        assert np.array_equal(bias, resumed[name][1])
    steps = [
        [json.loads(line)["step"] for line in (tmp_path / run / "log.jsonl").read_text("utf-8").splitlines()]
        for run in ("whole", "parts")
    ]
    assert steps == [[2, 4, 6], [2, 4, 6]]


def test_learning_lowers_the_loss(sets: FrameSets, tmp_path: Path) -> None:
    fit(TINY.with_steps(30), sets.train, tmp_path)
    lines = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text("utf-8").splitlines()]
    for name in ("rgb", "depth", "fusion"):
        assert lines[-1][name] < 0.9 * lines[0][name]


def test_the_checkpoint_of_another_run_is_refused(sets: FrameSets, tmp_path: Path) -> None:
    fit(TINY.with_steps(1), sets.train, tmp_path)
    with pytest.raises(InvalidInputError, match="is of another training"):
        fit(TINY, sets.train, tmp_path, resume=True)


def test_a_folder_that_cannot_be_written_is_named(sets: FrameSets, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(OutputError, match="The training cannot write to"):
        train_on(TINY.with_steps(1), sets, tmp_path / "out", work=tmp_path / "file" / "work")


def test_without_torch_the_extra_is_named() -> None:
    program = (
        "import sys; sys.modules['torch'] = None\n"
        "from pathlib import Path\n"
        "from sunset.training import TrainingConfig, train\n"
        "train(TrainingConfig(), Path('out'), work=Path('work'))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "MissingExtraError: Training needs torch, not installed: pip install" in done.stderr
