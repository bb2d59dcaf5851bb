"""How fast networks run, against what the processor could do.

For every network of the models that are named, prints its multiply-adds (a million a Mmac), and by engine and number of
threads: the time of a frame in a bare session, as the median and the least of several rounds, and which share of the
processor's peak the least is, at its rates of float32 and int8 products. These are measured before every network, and
the highest count, since other users of a computer may slow it for a while; so the table comes at the end. Then the time
of a frame when two processes of one thread share the frames, and what the `Segmenter` takes, its checks and copies
included.

`--plans` measures the networks that a training would give, in float32 and in int8, with random weights. `--batches`
also runs the branches, which do most of the work, on several frames at once, a frame being a batch of one. What
comes before and after them in the graph, the late fusion too, is laid out for one frame and is not in these times.

The processor should have nothing else to do. Needs the extra `train`; OpenVINO is measured where it is installed, with
float32 asked for.
"""

import argparse
import math
import statistics
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from multiprocessing import get_context
from multiprocessing.synchronize import Barrier
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
import numpy.typing as npt
import onnx
import onnxruntime
from onnx import TensorProto, helper, numpy_helper

from sunset.errors import SunsetError
from sunset.perception import Modality, Model, Segmenter, list_models, load_model
from sunset_lab import CONFIGS, FrameSet, TrainingConfig
from sunset_lab.network import build, folded_weights, ranges
from sunset_lab.onnx_graph import Format, Network, export

Arrays = dict[str, npt.NDArray[Any]]

_SIZES: Final = (576, 1024, 2048)
"""Sides of the square matrices that the peak is measured with; the fastest counts."""

_PATIENCE_S: Final = 60.0
"""How long a process waits for the other one to be ready."""

_barriers: list[Barrier] = []
"""In a process that measures beside another one: where the two wait for each other."""


@dataclass(frozen=True)
class Work:
    """Multiply-adds by the type that they are done in."""

    float32: int = 0
    int8: int = 0

    def seconds(self, rates: "Work") -> float:
        """Return how long this takes at rates a second."""
        return self.float32 / rates.float32 + self.int8 / rates.int8


def work(path: Path) -> Work:
    """Count the multiply-adds of a network's convolutions and matrix products, from its graph.

    Those between dequantised tensors are int8, in the engines that are compared here.
    """
    model = onnx.shape_inference.infer_shapes(onnx.load(path, load_external_data=False), data_prop=True)
    graph = model.graph
    shapes = {tensor.name: tuple(tensor.dims) for tensor in graph.initializer}
    for value in (*graph.input, *graph.output, *graph.value_info):
        shapes[value.name] = tuple(size.dim_value for size in value.type.tensor_type.shape.dim)
    dequantised = {node.output[0] for node in graph.node if node.op_type == "DequantizeLinear"}
    counts = {True: 0, False: 0}
    for node in graph.node:
        if node.op_type == "Conv":
            each = math.prod(shapes[node.input[1]][1:])
        elif node.op_type in {"MatMul", "Gemm"}:  # no network here transposes the first factor
            each = shapes[node.input[0]][-1]
        else:
            continue
        counts[dequantised.issuperset(node.input[:2])] += each * math.prod(shapes[node.output[0]])
    return Work(float32=counts[False], int8=counts[True])


def seconds(
    function: Callable[[], object], rounds: int, begin: Callable[[], object] = lambda: None
) -> list[float]:
    """Return the wall times of calls, after one that is not counted, and a call of `begin`."""
    function()
    begin()
    times = []
    for _ in range(rounds):
        started = time.perf_counter()
        function()
        times.append(time.perf_counter() - started)
    return times


def session(network: Path | bytes, threads: int) -> Any:
    """Open a network as the project does, with any number of threads."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    return onnxruntime.InferenceSession(network, options, providers=["CPUExecutionProvider"])


def product(size: int, *, quantised: bool) -> bytes:
    """Return a network that multiplies two square matrices; `quantised` gives one that engines do in int8."""
    rng = np.random.default_rng(0)
    kind = TensorProto.UINT8 if quantised else TensorProto.FLOAT
    weights = rng.integers(-64, 64, (size, size)).astype(np.int8 if quantised else np.float32)
    constants = [numpy_helper.from_array(weights, "b")]
    nodes = [helper.make_node("MatMul", ["a", "b"], ["c"])]
    if quantised:
        scale, zero = np.float32(0.01), np.uint8(128)
        scales = {"s": np.array(scale), "z": np.array(zero), "bz": np.array(np.int8(0))}
        constants += [numpy_helper.from_array(value, name) for name, value in scales.items()]
        nodes = [
            helper.make_node("DequantizeLinear", ["a", "s", "z"], ["a.real"]),
            helper.make_node("DequantizeLinear", ["b", "s", "bz"], ["b.real"]),
            helper.make_node("MatMul", ["a.real", "b.real"], ["c.real"]),
            helper.make_node("QuantizeLinear", ["c.real", "s", "z"], ["c"]),
        ]
    values = [helper.make_tensor_value_info(name, kind, [size, size]) for name in "ac"]
    graph = helper.make_graph(nodes, "product", values[:1], values[1:], constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=9)
    return bytes(model.SerializeToString())


def peak(threads: int, known: Work = Work()) -> Work:
    """Return the multiply-adds a second of the fastest product of two square matrices, or those known if higher."""
    rates = {}
    for quantised in (False, True):
        best = 0.0
        for size in _SIZES:
            a = np.ones((size, size), dtype=np.uint8 if quantised else np.float32)
            opened = session(product(size, quantised=quantised), threads)
            best = max(best, size**3 / min(seconds(lambda: opened.run(None, {"a": a}), 10)))  # noqa: B023
        rates[quantised] = round(best)
    return Work(float32=max(known.float32, rates[False]), int8=max(known.int8, rates[True]))


def frame(size: tuple[int, int]) -> Arrays:
    """Return a frame of noise: the time does not depend on the content."""
    rng = np.random.default_rng(0)
    return {
        "bgr": rng.integers(0, 256, (*size, 3), dtype=np.uint8),
        "depth": rng.integers(0, 65536, size, dtype=np.uint16),
    }


def drawn(config: TrainingConfig, folder: Path) -> Iterator[Model]:
    """Yield a training's networks in float32 and in int8, with random weights."""
    layers, (height, width) = config.plan(config.modalities), Format().size
    modules = build(layers).eval()
    weights, noise = folded_weights(layers, modules), frame((height, width))
    frames = FrameSet(noise["bgr"][None], noise["depth"][None], np.zeros((1, height, width), dtype=np.uint8))
    networks = {modality: Network(config.layers(modality.key), weights) for modality in Modality}
    limits = ranges(config.plan(config.branches), modules, frames)
    for precision, form in {"float32": Format(), "int8": Format(ranges=limits)}.items():
        card = {
            "name": f"{config.name}, random in {precision},",
            "description": "random",
            "architecture": "random",
        }
        export(folder / precision, networks, form, card)
        yield load_model(folder / precision)


def write_branches(path: Path, modality: Modality, frames: int, out: Path) -> Arrays:
    """Write a network's branches, from pictures to logits, for several frames at once; returns what they take."""
    model = onnx.shape_inference.infer_shapes(onnx.load(path))
    branches = ("rgb",) * modality.needs_rgb + ("depth",) * modality.needs_depth
    ends = [[f"{branch}.{end}" for branch in branches] for end in ("input", "logits")]
    part = onnx.utils.Extractor(model).extract_model(*ends)
    del part.graph.value_info[:]  # it says one frame
    shapes = {}
    for value in (*part.graph.input, *part.graph.output):
        value.type.tensor_type.shape.dim[0].dim_value = frames
        shapes[value.name] = [size.dim_value for size in value.type.tensor_type.shape.dim]
    onnx.save(part, out)
    rng = np.random.default_rng(0)
    return {name: rng.standard_normal(shapes[name], dtype=np.float32) for name in ends[0]}


def with_onnxruntime(path: Path, inputs: Arrays, threads: int) -> Callable[[], Any]:
    """Return a call of a bare session, which need not give the `logits`."""
    opened = session(path, threads)
    outputs = [value.name for value in opened.get_outputs() if value.name != "logits"]
    return lambda: opened.run(outputs, inputs)


def with_openvino(path: Path, inputs: Arrays, threads: int) -> Callable[[], object]:
    """Return a call of OpenVINO, with one stream and no rounding of float32."""
    openvino = import_module("openvino")  # an engine that the project does not need
    hints = {"INFERENCE_NUM_THREADS": threads, "NUM_STREAMS": 1, "INFERENCE_PRECISION_HINT": "f32"}
    request = openvino.Core().compile_model(path, "CPU", hints).create_infer_request()
    return lambda: request.infer(inputs, share_inputs=True)


ENGINES: Final = {"ONNX Runtime": with_onnxruntime} | (
    {"OpenVINO": with_openvino} if find_spec("openvino") else {}
)


def _meet(barrier: Barrier) -> None:
    """Let a process know where it waits for the other one."""
    _barriers.append(barrier)


def worker(engine: str, path: Path, inputs: Arrays, rounds: int) -> list[float]:
    """Return the seconds of frames in a process of its own, with one thread, when the other process is ready too."""
    (barrier,) = _barriers
    return seconds(ENGINES[engine](path, inputs, 1), rounds, barrier.wait)


def together(engine: str, path: Path, inputs: Arrays, rounds: int) -> list[float]:
    """Return the seconds of a frame when two processes share the frames; the slower of the two counts."""
    context = get_context("spawn")
    barrier = context.Barrier(2, timeout=_PATIENCE_S)
    with ProcessPoolExecutor(2, context, initializer=_meet, initargs=(barrier,)) as pool:
        both = [pool.submit(worker, engine, path, inputs, rounds) for _ in range(2)]
        times = max((one.result() for one in both), key=statistics.median)
    return [each / 2 for each in times]


@dataclass(frozen=True)
class Row:
    """The seconds of calls that take so many frames each, and have so much to do."""

    engine: str
    how: str
    times: list[float]
    todo: Work
    threads: int
    frames: int = 1

    def line(self, peaks: dict[int, Work]) -> str:
        """Return a line of figures."""
        median, least = (
            1e3 * each / self.frames for each in (statistics.median(self.times), min(self.times))
        )
        share = 100 * self.todo.seconds(peaks[self.threads]) / min(self.times)
        return f"  {self.engine:<13}{self.how:<27}{median:7.1f} ms{least:7.1f} ms{share:6.0f} %"


def rows(model: Model, modality: Modality, threads: Iterable[int], rounds: int) -> Iterator[Row]:
    """Yield a row of figures for every way to run a network."""
    path = model.folder / model.card.networks[modality].file
    noise = frame((model.card.height, model.card.width))
    inputs = {name: value for name, value in noise.items() if _needs(modality, name)}
    todo = work(path)

    def answer(segmenter: Segmenter) -> object:
        return segmenter.segment(modality, inputs.get("bgr"), inputs.get("depth"))

    for engine, opened in ENGINES.items():
        for many in threads:
            times = seconds(opened(path, inputs, many), rounds)
            yield Row(engine, f"{many} thread(s)", times, todo, many)
        yield Row(engine, "2 processes", together(engine, path, inputs, rounds), todo, 2)
    yield Row("Segmenter", "1 thread(s)", seconds(partial(answer, Segmenter(model)), rounds), todo, 1)


def batch_rows(
    model: Model, modality: Modality, threads: Iterable[int], rounds: int, frames: int
) -> Iterator[Row]:
    """Yield a row of figures for every way to run a network's branches on several frames at once."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "branches.onnx"
        inputs = write_branches(model.folder / model.card.networks[modality].file, modality, frames, path)
        todo = work(path)
        for engine, opened in ENGINES.items():
            for many in threads:
                times = seconds(opened(path, inputs, many), rounds)
                yield Row(engine, f"{many} thread(s), branches by {frames}", times, todo, many, frames)


def _needs(modality: Modality, name: str) -> bool:
    return modality.needs_rgb if name == "bgr" else modality.needs_depth


def _at_least_one(text: str) -> int:
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, got {text!r}")
    return int(text)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "models", nargs="*", help="names or folders (default: all that are installed, or --plans)"
    )
    parser.add_argument("--plans", choices=CONFIGS, nargs="+", default=[], help="trainings (default: none)")
    parser.add_argument(
        "--batches", type=_at_least_one, nargs="+", default=[], help="frames at once (default: none)"
    )
    parser.add_argument(
        "--rounds", type=_at_least_one, default=20, help="of each measurement (default: %(default)s)"
    )
    parser.add_argument("--threads", type=_at_least_one, nargs="+", default=[1, 2], help="(default: 1 2)")
    given = parser.parse_args(arguments)
    peaks = {threads: Work() for threads in sorted({1, 2, *given.threads})}
    table: list[tuple[str, list[Row]]] = []
    try:
        with TemporaryDirectory() as folder:
            for model in models(given.models, given.plans, Path(folder)):
                for modality in sorted(model.card.networks):
                    print(f"Measuring {model.card.name} {modality.key}", file=sys.stderr, flush=True)
                    peaks = {threads: peak(threads, known) for threads, known in peaks.items()}
                    measured = list(rows(model, modality, peaks, given.rounds))
                    todo = measured[0].todo
                    for frames in given.batches:
                        measured += batch_rows(model, modality, peaks, given.rounds, frames)
                    size = f"{todo.float32 / 1e6:.0f} Mmac float32, {todo.int8 / 1e6:.0f} int8"
                    table.append((f"{model.card.name} {modality.key}: {size}", measured))
    except SunsetError as error:
        parser.error(str(error))
    finally:
        if table:  # what was measured is not lost
            show(table, peaks)


def show(table: Sequence[tuple[str, list[Row]]], peaks: dict[int, Work]) -> None:
    """Print the processor's peaks and the figures of every network."""
    for threads, rates in peaks.items():
        print(
            f"peak of {threads} thread(s): {rates.float32 / 1e9:.0f} Gmac/s float32, {rates.int8 / 1e9:.0f} int8"
        )
    print(f"  {'':40}{'median':>7}{'least':>10}{'of peak':>11}")
    for title, measured in table:
        print("\n".join([title, *(row.line(peaks) for row in measured)]))


def models(names: Sequence[str], plans: Sequence[str], folder: Path) -> Iterator[Model]:
    """Yield the models that are measured."""
    yield from [load_model(name) for name in names or ([] if plans else list_models())]
    for name in plans:
        yield from drawn(CONFIGS[name], folder / name)


if __name__ == "__main__":
    main()
