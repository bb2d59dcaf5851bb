import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from sunset.perception import Modality, Model
from sunset_lab import TrainingConfig
from sunset_lab.shapes import LiteShape

pytestmark = pytest.mark.thorough

torch = pytest.importorskip("torch")
onnx = pytest.importorskip("onnx")

from benchmarks import inference  # noqa: E402

torch.set_num_threads(1)  # the networks are tiny, and other tests run beside

TINY = LiteShape(16, (16, 16, 16), (1, 1, 1), pyramid=16, rates=(2,), skips=(16, 16), decoder=16)


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> list[Model]:
    return list(inference.drawn(TrainingConfig(shape=TINY), tmp_path_factory.mktemp("drawn")))


def save(path: Path, *nodes: str, kernel: str) -> Path:
    """A graph of nodes in ONNX's own notation, from `x` to `y`."""
    text = f"""
        <ir_version: 9, opset_import: ["" : 18]>
        graph ({kernel}, float[1, 8, 4, 5] x, float s, int8 z) => (float[1, 6, 4, 5] y) {{ {" ".join(nodes)} }}
    """
    onnx.save(onnx.parser.parse_model(text), path)
    return path


def test_convolutions_count_a_kernel_for_every_pixel(tmp_path: Path) -> None:
    path = save(tmp_path / "x.onnx", "y = Conv<pads = [1, 1, 1, 1]>(x, k)", kernel="float[6, 8, 3, 3] k")
    assert inference.work(path) == inference.Work(float32=6 * 8 * 9 * 20)


@pytest.mark.parametrize("product", ["p = Gemm(k, flat)", "p = MatMul(k, flat)"])
def test_products_of_matrices_count_too(product: str, tmp_path: Path) -> None:
    before = "a = Constant<value_ints = [8, 20]>() flat = Reshape(x, a)"
    after = "b = Constant<value_ints = [1, 6, 4, 5]>() y = Reshape(p, b)"
    path = save(tmp_path / "x.onnx", before, product, after, kernel="float[6, 8] k")
    assert inference.work(path) == inference.Work(float32=6 * 8 * 20)


def test_work_between_dequantised_tensors_is_int8(tmp_path: Path) -> None:
    kernel = "k = DequantizeLinear(q, s, z)"
    source = "r = QuantizeLinear(x, s, z) d = DequantizeLinear(r, s, z)"
    both = save(tmp_path / "both.onnx", kernel, source, "y = Conv(d, k)", kernel="int8[6, 8, 1, 1] q")
    one = save(tmp_path / "one.onnx", kernel, "y = Conv(x, k)", kernel="int8[6, 8, 1, 1] q")
    assert inference.work(both) == inference.Work(int8=6 * 8 * 20)
    assert inference.work(one) == inference.Work(float32=6 * 8 * 20)


def test_plans_are_drawn_in_both_precisions(models: list[Model]) -> None:
    for modality in Modality:
        float32, int8 = (inference.work(model.folder / f"{modality.key}.onnx") for model in models)
        assert float32.int8 == 0 < int8.int8
        assert int8.float32 < float32.float32
        assert int8.float32 + int8.int8 <= float32.float32  # 8 bits spare some products with padding


@pytest.mark.parametrize("modality", Modality)
def test_branches_take_several_frames_at_once(
    modality: Modality, models: list[Model], tmp_path: Path
) -> None:
    network, out = models[0].folder / f"{modality.key}.onnx", tmp_path / "branches.onnx"
    inputs = inference.write_branches(network, modality, 3, out)
    all_at_once, work = inference.with_onnxruntime(out, inputs, 1)(), inference.work(out)
    inference.write_branches(network, modality, 1, out)
    assert work.float32 == 3 * inference.work(out).float32
    for index in range(3):
        one = {name: value[index : index + 1] for name, value in inputs.items()}
        for logits, expected in zip(all_at_once, inference.with_onnxruntime(out, one, 1)(), strict=True):
            assert logits.shape == (3, 28, 72, 128)
            np.testing.assert_allclose(logits[index : index + 1], expected, atol=1e-5)


def test_two_processes_measure_when_both_are_ready(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[None] = []
    barrier = threading.Barrier(2, timeout=60)
    monkeypatch.setitem(inference.ENGINES, "none", lambda *_: lambda: calls.append(None))
    monkeypatch.setattr(inference, "_barriers", [barrier])
    with ThreadPoolExecutor(2) as pool:
        one = pool.submit(inference.worker, "none", Path(), {}, 3)
        while not barrier.n_waiting and not one.done():
            pass
        assert len(calls) == 1  # not counted
        other = pool.submit(inference.worker, "none", Path(), {}, 3)
        assert len(one.result()) == len(other.result()) == 3


def test_two_processes_share_the_frames(models: list[Model]) -> None:
    noise = {"depth": inference.frame((144, 256))["depth"]}
    times = inference.together("ONNX Runtime", models[0].folder / "depth.onnx", noise, 3)
    assert len(times) == 3
    assert min(times) > 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--rounds", "0"], "at least 1"),
        (["--threads", "1", "0"], "at least 1"),
        (["--batches", "few"], "at least 1"),
        (["lite", "huge"], "There is no model 'huge'"),
    ],
)
def test_what_cannot_be_measured_is_refused(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as way_out:
        inference.main(arguments)
    out, err = capsys.readouterr()
    assert (way_out.value.code, out) == (2, "")
    assert words in err
