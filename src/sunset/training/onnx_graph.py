"""Writes plans of `architecture` with their weights as ONNX models, from raw frames to labels and entropy."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt
from onnx import TensorProto

from sunset.classes import CLASSES
from sunset.perception import Modality, NetworkCard
from sunset.training.architecture import (
    Concat,
    Conv,
    Layer,
    MaxPool,
    Pool,
    Resize,
    Shuffle,
    Spread,
    convolutions,
)
from sunset.training.inputs import HEIGHT, WIDTH
from sunset.training.onnx_inputs import depth_input, published_depth_input, rgb_input
from sunset.training.onnx_writer import Graph, Store, tensor_info

__all__ = ["Format", "Network", "Ranges", "Weights", "export"]

Weights: TypeAlias = Mapping[str, tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]]
"""Per convolution its kernel (out, in, k, k) and bias (out,), normalisation folded in."""

Ranges: TypeAlias = Mapping[str, tuple[float, float]]
"""Least and greatest value of the results that are stored in 8 bits."""

_KERNEL_LIMIT: Final = 63
"""Kernels take 7 bits: processors without instructions for 8-bit products add two of them in 16 bits."""


@dataclass(frozen=True, slots=True)
class Format:
    """What an exported network takes, and how its numbers are stored.

    Attributes:
        size: height and width of the frames; multiples of 8, and of 16 unless depth is as published.
        published_depth: depth enters as in SynDrone's benchmark, not as logarithm and contrasts.
        dtype: of the kernels in the file, where they are not in 8 bits; inference is in float32 then.
        ranges: of the results that are computed in 8 bits; a convolution is, if its source has a range.
    """

    size: tuple[int, int] = (HEIGHT, WIDTH)
    published_depth: bool = False
    dtype: type[np.floating[Any]] = np.float32
    ranges: Ranges | None = None

    @property
    def precision(self) -> str:
        """How the numbers are stored, for the model's card."""
        return "int8" if self.ranges else "float32" if self.dtype is np.float32 else "float16 weights"


@dataclass(frozen=True, slots=True)
class Network:
    """One network of a model.

    Attributes:
        layers: its plan; the last layer is the logits.
        weights: kernels and biases by layer, as `folded_weights` gives them.
        temperature: greater than 0.
    """

    layers: tuple[Layer, ...]
    weights: Weights
    temperature: float = 1.0

    @property
    def parameters(self) -> int:
        """The number of weights, normalisation folded in."""
        used = [self.weights[layer.name] for layer in convolutions(self.layers)]
        return sum(kernel.size + bias.size for kernel, bias in used)


def export(folder: Path, networks: Mapping[Modality, Network], form: Format) -> dict[Modality, NetworkCard]:
    """Write a model's networks as ONNX; what they share is stored once, in files beside them.

    Their inputs are raw: `bgr` (H, W, 3) uint8 and `depth` (H, W) uint16, those that they need. Their outputs
    are `logits` (1, 28, h, w) float32 at the network's stride, before interpolation and without the
    temperature; `labels` (H, W) uint8, the class of the greatest interpolated logit; and `entropy`, the mean
    over pixels of the normalised Shannon entropy of the softmax of the interpolated logits over the
    constant `temperature`.

    Args:
        folder: receives the files.
        networks: what is written.
        form: what they take, and how they are stored.

    Returns:
        The networks' entries on the model's card.
    """
    folder.mkdir(parents=True, exist_ok=True)
    store = Store(folder)
    writers = {
        modality: _Writer(modality, networks[modality], form, store)
        for modality in sorted(
            networks, reverse=True
        )  # branches first: what the fusion shares is in their files
    }
    store.write()
    cards = {}
    for modality, writer in sorted(writers.items()):
        path, network = folder / f"{modality.key}.onnx", networks[modality]
        writer.write(path)
        data = {name: _sha256(folder / name) for name in sorted(writer.graph.data)}
        cards[modality] = NetworkCard(path.name, _sha256(path), network.parameters, network.temperature, data)
    return cards


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


class _Writer:
    """Puts one network together, and writes it."""

    def __init__(self, modality: Modality, network: Network, form: Format, store: Store) -> None:
        self.graph = Graph(modality.key, store)
        self._modality = modality
        self._weights = network.weights
        self._form = form
        self._ranges = form.ranges or {}
        self._sizes: dict[str, tuple[int, int]] = {}
        if modality.needs_rgb:
            rgb_input(self.graph)
            self._sizes["rgb.input"] = form.size
        if modality.needs_depth:
            (published_depth_input if form.published_depth else depth_input)(self.graph, form.size)
            self._sizes["depth.input"] = form.size
        for layer in network.layers:
            self._layer(layer)
        self._logits = network.layers[-1].name
        self._outputs(self._logits, network.temperature)

    def write(self, path: Path) -> None:
        height, width = self._form.size
        inputs = []
        if self._modality.needs_rgb:
            inputs.append(tensor_info("bgr", TensorProto.UINT8, [height, width, 3]))
        if self._modality.needs_depth:
            inputs.append(tensor_info("depth", TensorProto.UINT16, [height, width]))
        outputs = [
            tensor_info("logits", TensorProto.FLOAT, [1, len(CLASSES), *self._sizes[self._logits]]),
            tensor_info("labels", TensorProto.UINT8, [height, width]),
            tensor_info("entropy", TensorProto.FLOAT, []),
        ]
        self.graph.write(path, inputs, outputs)

    def _result(self, kind: str, inputs: Sequence[str], name: str, **attributes: object) -> None:
        """Add a node whose result is rounded to 8 bits if it has a range."""
        if name not in self._ranges:
            self.graph.node(kind, inputs, name, **attributes)
            return
        self.graph.node(kind, inputs, f"{name}.exact", **attributes)
        scale, zero = _grid(self._ranges[name])
        grid = (
            self.graph.constant(f"{name}.scale", scale),
            self.graph.constant(f"{name}.zero", zero, np.uint8),
        )
        self.graph.node("QuantizeLinear", [f"{name}.exact", *grid], f"{name}.8bit")
        self.graph.node("DequantizeLinear", [f"{name}.8bit", *grid], name)

    def _layer(self, layer: Layer) -> None:
        graph, sizes = self.graph, self._sizes
        match layer:
            case Conv():
                height, width = sizes[layer.source]
                sizes[layer.name] = (-(-height // layer.stride), -(-width // layer.stride))
                self._convolution(layer)
            case MaxPool():
                height, width = sizes[layer.source]
                sizes[layer.name] = (-(-height // 2), -(-width // 2))
                geometry = {"kernel_shape": [3, 3], "strides": [2, 2], "pads": [1] * 4}
                self._result("MaxPool", [layer.source], layer.name, **geometry)
            case Pool():
                sizes[layer.name] = (1, 1)
                self._result("GlobalAveragePool", [layer.source], layer.name)
            case Spread():
                sizes[layer.name] = sizes[layer.like]
                size = graph.constant(f"{layer.name}.size", [1, 1, *sizes[layer.like]], np.int64)
                self._result("Expand", [layer.source, size], layer.name)
            case Resize():
                height, width = sizes[layer.source]
                sizes[layer.name] = (height * layer.factor, width * layer.factor)
                result = f"{layer.name}.linear" if layer.relu else layer.name
                graph.upsample(layer.source, result, (height, width), layer.factor)
                if layer.relu:
                    self._result("Relu", [result], layer.name)
            case Shuffle():
                height, width = sizes[layer.source]
                sizes[layer.name] = (height * 2, width * 2)
                self._result("DepthToSpace", [layer.source], layer.name, blocksize=2, mode="CRD")
            case Concat():
                sizes[layer.name] = sizes[layer.sources[0]]
                self._result("Concat", layer.sources, layer.name, axis=1)

    def _convolution(self, layer: Conv) -> None:
        height, width = self._sizes[layer.source]
        kernel, bias = self._weights[layer.name]
        kernel = kernel[:, :, layer.taps(height), layer.taps(width)]
        attributes = {
            "kernel_shape": kernel.shape[2:],
            "strides": [layer.stride] * 2,
            "dilations": [layer.dilation] * 2,
            "pads": [layer.padding(height), layer.padding(width)] * 2,
        }
        steps = [("Add", [layer.add])] * bool(layer.add) + [("Relu", [])] * layer.relu
        result = f"{layer.name}.conv" if steps else layer.name
        self._result(
            "Conv", [layer.source, *self._kernel_and_bias(layer, kernel, bias)], result, **attributes
        )
        for index, (kind, more) in enumerate(steps, start=1):
            output = layer.name if index == len(steps) else f"{layer.name}.{kind.lower()}"
            self._result(kind, [result, *more], output)
            result = output

    def _kernel_and_bias(
        self, layer: Conv, kernel: npt.NDArray[np.float32], bias: npt.NDArray[np.float32]
    ) -> tuple[str, str]:
        graph, name = self.graph, layer.name
        if layer.source in self._ranges:
            return self._in_8_bits(layer, kernel, bias)
        dtype = self._form.dtype
        if dtype is np.float32:
            stored = graph.weights(f"{name}.kernel", kernel)
        else:  # the runtime makes float32 of them once, when it loads the model
            graph.weights(f"{name}.kernel.stored", kernel, dtype)
            stored = graph.node("Cast", [f"{name}.kernel.stored"], f"{name}.kernel", to=TensorProto.FLOAT)
        return stored, graph.constant(f"{name}.bias", bias)

    def _in_8_bits(
        self, layer: Conv, kernel: npt.NDArray[np.float32], bias: npt.NDArray[np.float32]
    ) -> tuple[str, str]:
        """Store a kernel in 7 bits, with a scale per output channel, and the bias on the products' grid."""
        graph, name = self.graph, layer.name
        greatest = np.abs(kernel).max(axis=(1, 2, 3))
        scales = np.maximum(greatest, 1e-8).astype(np.float32) / _KERNEL_LIMIT
        rounded = np.rint(kernel / scales[:, None, None, None])
        graph.weights(f"{name}.kernel.8bit", rounded, np.int8)
        graph.constant(f"{name}.kernel.scale", scales)
        graph.constant(f"{name}.kernel.zero", np.zeros(len(scales)), np.int8)
        stored = [f"{name}.kernel.{part}" for part in ("8bit", "scale", "zero")]
        products = scales * np.float32(_grid(self._ranges[layer.source])[0])
        graph.constant(f"{name}.bias.32bit", np.rint(bias / products), np.int32)
        graph.constant(f"{name}.bias.scale", products)
        return (
            graph.node("DequantizeLinear", stored, f"{name}.kernel", axis=0),
            graph.node(
                "DequantizeLinear", [f"{name}.bias.32bit", f"{name}.bias.scale"], f"{name}.bias", axis=0
            ),
        )

    def _outputs(self, logits: str, temperature: float) -> None:
        """Add labels and entropy at full resolution.

        Softmax is blind to a constant added to all classes of a pixel, and interpolation is linear; so the
        greatest logit of each coarse pixel is taken off before interpolating, and the exponentials at full
        resolution cannot overflow. Sums over classes are products with a row of ones, which is five times
        faster than a reduction along that axis.
        """
        graph, size = self.graph, self._sizes[logits]
        height, width = self._form.size
        graph.node("Identity", [logits], "logits")
        axis = graph.constant("classes.axis", [1], np.int64)
        graph.node("ReduceMax", [logits, axis], "greatest", keepdims=1)
        graph.node("Sub", [logits, "greatest"], "below")
        graph.node("Max", ["below", graph.constant("least", -60)], "bounded")
        graph.upsample("bounded", "scores", size, height // size[0])
        graph.node("ArgMax", ["scores"], "labels.index", axis=1, keepdims=0)
        graph.node("Cast", ["labels.index"], "labels.batch", to=TensorProto.UINT8)
        shape = graph.constant("labels.shape", [height, width], np.int64)
        graph.node("Reshape", ["labels.batch", shape], "labels")
        flat = graph.constant("scores.shape", [len(CLASSES), height * width], np.int64)
        ones = graph.constant("ones", np.ones((1, len(CLASSES))))
        graph.node("Reshape", ["scores", flat], "scores.flat")
        graph.node("Div", ["scores.flat", graph.constant("temperature", temperature)], "x")
        graph.node("Exp", ["x"], "exp")
        graph.node("MatMul", [ones, "exp"], "sum")
        graph.node("Mul", ["exp", "x"], "weighted")
        graph.node("MatMul", [ones, "weighted"], "weighted.sum")
        graph.node("Log", ["sum"], "log.sum")
        graph.node("Div", ["weighted.sum", "sum"], "mean.x")
        graph.node("Sub", ["log.sum", "mean.x"], "entropy.nats")
        graph.node("ReduceMean", ["entropy.nats"], "entropy.mean", keepdims=0)
        graph.node("Mul", ["entropy.mean", graph.constant("nats", 1 / np.log(len(CLASSES)))], "entropy")


def _grid(limits: tuple[float, float]) -> tuple[float, int]:
    """Return scale and zero point of the 8-bit numbers that cover a range and 0."""
    low, high = min(limits[0], 0.0), max(limits[1], 0.0)
    scale = max(high - low, 1e-8) / 255
    return scale, round(-low / scale)
