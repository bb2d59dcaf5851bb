"""Writes a plan of `architecture` with its weights as an ONNX model, from raw frames to labels and entropy."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from onnx import TensorProto, checker, helper, numpy_helper

from sunset.classes import CLASSES
from sunset.training.architecture import Concat, Conv, Layer, MaxPool, Pool, Resize, Shuffle, Spread
from sunset.training.inputs import (
    CONTRASTS,
    DEPTH_LIMIT_M,
    FAR_PLANE_M,
    HEIGHT,
    REFERENCE_DEPTH_M,
    RGB_MEAN,
    RGB_STD,
    WIDTH,
    upsampling,
)
from sunset.training.network import Weights

__all__ = ["export"]

_OPSET: Final = 18
_IR_VERSION: Final = 9


class _Graph:
    """Collects nodes and constants."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def constant(self, name: str, value: npt.ArrayLike, dtype: npt.DTypeLike = np.float32) -> str:
        self.constants.append(numpy_helper.from_array(np.asarray(value, dtype=dtype), name))
        return name

    def kernel(self, name: str, value: npt.NDArray[np.float32], dtype: type[np.floating[Any]]) -> str:
        """Store weights as a type; the runtime makes float32 of them once, when it loads the model."""
        if dtype is np.float32:
            return self.constant(name, value)
        self.constant(f"{name}.stored", value, dtype)
        return self.node("Cast", [f"{name}.stored"], name, to=TensorProto.FLOAT)

    def node(self, kind: str, inputs: Sequence[str], output: str, **attributes: object) -> str:
        self.nodes.append(helper.make_node(kind, list(inputs), [output], **attributes))
        return output


def _upsample(graph: _Graph, source: str, output: str, size: tuple[int, int], factor: int) -> str:
    if factor == 1:
        return graph.node("Identity", [source], output)
    rows = graph.constant(f"{output}.rows", upsampling(size[0], factor))
    columns = graph.constant(f"{output}.columns", upsampling(size[1], factor).T)
    graph.node("MatMul", [source, columns], f"{output}.wide")
    return graph.node("MatMul", [rows, f"{output}.wide"], output)


def _rgb_input(graph: _Graph) -> None:
    graph.node("Transpose", ["bgr"], "bgr.planes", perm=[2, 0, 1])
    graph.node("Cast", ["bgr.planes"], "bgr.float", to=TensorProto.FLOAT)
    graph.node(
        "Gather", ["bgr.float", graph.constant("rgb.order", [2, 1, 0], np.int64)], "rgb.planes", axis=0
    )
    scale = 1 / (255 * np.asarray(RGB_STD)).reshape(1, 3, 1, 1)
    shift = -(np.asarray(RGB_MEAN) / np.asarray(RGB_STD)).reshape(1, 3, 1, 1)
    graph.node("Mul", ["rgb.planes", graph.constant("rgb.scale", scale)], "rgb.scaled")
    graph.node("Add", ["rgb.scaled", graph.constant("rgb.shift", shift)], "rgb.input")


def _depth_input(graph: _Graph) -> None:
    shape = graph.constant("depth.shape", [1, 1, HEIGHT, WIDTH], np.int64)
    graph.node("Cast", ["depth"], "depth.counts", to=TensorProto.FLOAT)
    graph.node("Reshape", ["depth.counts", shape], "depth.plane")
    graph.node("Mul", ["depth.plane", graph.constant("depth.unit", FAR_PLANE_M / 65535)], "depth.metres")
    graph.node("Max", ["depth.metres", graph.constant("depth.nearest", 1)], "depth.positive")
    reference = graph.constant("depth.reference", 1 / REFERENCE_DEPTH_M)
    graph.node("Mul", ["depth.positive", reference], "depth.relative")
    channels = [graph.node("Log", ["depth.relative"], "depth.log")]
    graph.node("Min", ["depth.metres", graph.constant("depth.limit", DEPTH_LIMIT_M)], "depth.near")
    for block, unit, limit in CONTRASTS:
        name = f"depth.contrast{block}"
        mean = f"{name}.blocks"
        graph.node("AveragePool", ["depth.near"], mean, kernel_shape=[block, block], strides=[block, block])
        _upsample(graph, mean, f"{name}.mean", (HEIGHT // block, WIDTH // block), block)
        graph.node("Sub", ["depth.near", f"{name}.mean"], f"{name}.metres")
        graph.node("Mul", [f"{name}.metres", graph.constant(f"{name}.unit", 1 / unit)], f"{name}.units")
        low, high = graph.constant(f"{name}.low", -limit), graph.constant(f"{name}.high", limit)
        channels.append(graph.node("Clip", [f"{name}.units", low, high], name))
    graph.node("Concat", channels, "depth.input", axis=1)


def _convolution(graph: _Graph, layer: Conv, weights: Weights, dtype: type[np.floating[Any]]) -> None:
    kernel, bias = weights[layer.name]
    names = [
        graph.kernel(f"{layer.name}.kernel", kernel, dtype),
        graph.constant(f"{layer.name}.bias", bias),
    ]
    steps = [("Add", [layer.add])] * bool(layer.add) + [("Relu", [])] * layer.relu
    result = f"{layer.name}.conv" if steps else layer.name
    graph.node(
        "Conv",
        [layer.source, *names],
        result,
        kernel_shape=[layer.kernel] * 2,
        strides=[layer.stride] * 2,
        dilations=[layer.dilation] * 2,
        pads=[layer.padding] * 4,
    )
    for index, (kind, more) in enumerate(steps, start=1):
        output = layer.name if index == len(steps) else f"{layer.name}.{kind.lower()}"
        result = graph.node(kind, [result, *more], output)


def _layer(
    graph: _Graph,
    layer: Layer,
    weights: Weights,
    sizes: dict[str, tuple[int, int]],
    dtype: type[np.floating[Any]],
) -> None:
    match layer:
        case Conv():
            height, width = sizes[layer.source]
            sizes[layer.name] = (-(-height // layer.stride), -(-width // layer.stride))
            _convolution(graph, layer, weights, dtype)
        case MaxPool():
            height, width = sizes[layer.source]
            sizes[layer.name] = (-(-height // 2), -(-width // 2))
            geometry = {"kernel_shape": [3, 3], "strides": [2, 2], "pads": [1] * 4}
            graph.node("MaxPool", [layer.source], layer.name, **geometry)
        case Spread():
            sizes[layer.name] = sizes[layer.like]
            size = graph.constant(f"{layer.name}.size", [1, 1, *sizes[layer.like]], np.int64)
            graph.node("Expand", [layer.source, size], layer.name)
        case Pool():
            sizes[layer.name] = (1, 1)
            graph.node("GlobalAveragePool", [layer.source], layer.name)
        case Resize():
            height, width = sizes[layer.source]
            sizes[layer.name] = (height * layer.factor, width * layer.factor)
            _upsample(graph, layer.source, layer.name, (height, width), layer.factor)
        case Shuffle():
            height, width = sizes[layer.source]
            sizes[layer.name] = (height * 2, width * 2)
            graph.node("DepthToSpace", [layer.source], layer.name, blocksize=2, mode="CRD")
        case Concat():
            sizes[layer.name] = sizes[layer.sources[0]]
            graph.node("Concat", layer.sources, layer.name, axis=1)


def _outputs(graph: _Graph, logits: str, size: tuple[int, int], temperature: float) -> None:
    """Add labels and entropy at full resolution.

    Softmax is blind to a constant added to all classes of a pixel, and interpolation is linear; so the
    greatest logit of each coarse pixel is taken off before interpolating, and the exponentials at full
    resolution cannot overflow. Sums over classes are products with a row of ones, which is five times
    faster than a reduction along that axis.
    """
    graph.node("Identity", [logits], "logits")
    axis = graph.constant("classes.axis", [1], np.int64)
    graph.node("ReduceMax", [logits, axis], "greatest", keepdims=1)
    graph.node("Sub", [logits, "greatest"], "below")
    graph.node("Max", ["below", graph.constant("least", -60)], "bounded")
    _upsample(graph, "bounded", "scores", size, HEIGHT // size[0])
    graph.node("ArgMax", ["scores"], "labels.index", axis=1, keepdims=0)
    graph.node("Cast", ["labels.index"], "labels.batch", to=TensorProto.UINT8)
    shape = graph.constant("labels.shape", [HEIGHT, WIDTH], np.int64)
    graph.node("Reshape", ["labels.batch", shape], "labels")
    flat = graph.constant("scores.shape", [len(CLASSES), HEIGHT * WIDTH], np.int64)
    ones = graph.constant("ones", np.ones((1, len(CLASSES))))
    graph.node("Reshape", ["scores", flat], "scores.flat")
    graph.node("Mul", ["scores.flat", graph.constant("temperature.inverse", 1 / temperature)], "x")
    graph.node("Exp", ["x"], "exp")
    graph.node("MatMul", [ones, "exp"], "sum")
    graph.node("Mul", ["exp", "x"], "weighted")
    graph.node("MatMul", [ones, "weighted"], "weighted.sum")
    graph.node("Log", ["sum"], "log.sum")
    graph.node("Div", ["weighted.sum", "sum"], "mean.x")
    graph.node("Sub", ["log.sum", "mean.x"], "entropy.nats")
    graph.node("ReduceMean", ["entropy.nats"], "entropy.mean", keepdims=0)
    graph.node("Mul", ["entropy.mean", graph.constant("nats", 1 / np.log(len(CLASSES)))], "entropy")


def export(
    path: Path,
    layers: Sequence[Layer],
    weights: Weights,
    *,
    inputs: Sequence[str],
    temperature: float,
    dtype: type[np.floating[Any]] = np.float16,
) -> None:
    """Write a network as ONNX.

    Its inputs are raw: `bgr` (144, 256, 3) uint8 and `depth` (144, 256) uint16, those of its `inputs`.
    Its outputs are `logits` (1, 28, h, w) float32 at the network's stride, before interpolation and without
    the temperature; `labels` (144, 256) uint8, the class of the greatest interpolated logit; and `entropy`,
    the mean over pixels of the normalised Shannon entropy of the softmax of the interpolated logits over the
    temperature.

    Args:
        path: the file.
        layers: the plan; its last layer is the logits.
        weights: kernels and biases by layer, as `folded_weights` gives them.
        inputs: "rgb", "depth" or both.
        temperature: greater than 0.
        dtype: of the kernels in the file; inference is in float32 in any case.
    """
    graph = _Graph()
    sizes = {}
    if "rgb" in inputs:
        _rgb_input(graph)
        sizes["rgb.input"] = (HEIGHT, WIDTH)
    if "depth" in inputs:
        _depth_input(graph)
        sizes["depth.input"] = (HEIGHT, WIDTH)
    for layer in layers:
        _layer(graph, layer, weights, sizes, dtype)
    size = sizes[layers[-1].name]
    _outputs(graph, layers[-1].name, size, temperature)
    raw = {
        "rgb": helper.make_tensor_value_info("bgr", TensorProto.UINT8, [HEIGHT, WIDTH, 3]),
        "depth": helper.make_tensor_value_info("depth", TensorProto.UINT16, [HEIGHT, WIDTH]),
    }
    results = [
        helper.make_tensor_value_info("logits", TensorProto.FLOAT, [1, len(CLASSES), *size]),
        helper.make_tensor_value_info("labels", TensorProto.UINT8, [HEIGHT, WIDTH]),
        helper.make_tensor_value_info("entropy", TensorProto.FLOAT, []),
    ]
    body = helper.make_graph(graph.nodes, path.stem, [raw[name] for name in inputs], results, graph.constants)
    model = helper.make_model(
        body, opset_imports=[helper.make_opsetid("", _OPSET)], ir_version=_IR_VERSION, producer_name="sunset"
    )
    checker.check_model(model)
    path.write_bytes(model.SerializeToString(deterministic=True))
