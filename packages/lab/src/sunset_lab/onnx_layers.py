"""Layers of a plan in ONNX graphs, whose large weights are in shared files; and the weights of graphs."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt
import onnx
from onnx import checker, external_data_helper, helper, numpy_helper

from sunset.errors import InvalidInputError
from sunset.files.outputs import draft_of
from sunset.perception import Modality, Model
from sunset_lab.architecture import (
    Concat,
    Conv,
    Layer,
    MaxPool,
    Pool,
    Resize,
    Shuffle,
    Spread,
    convolutions,
    upsampling,
)
from sunset_lab.config import TrainingConfig

Weights: TypeAlias = Mapping[str, tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]]
"""Each convolution's kernel (out, in, k, k) and bias (out,), with the normalisation folded in."""

Ranges: TypeAlias = Mapping[str, tuple[float, float]]
"""Least and greatest value of the results that are stored in 8 bits."""

_Array: TypeAlias = npt.NDArray[np.float32]

_KERNEL_LIMIT: Final = 63
"""Kernels take 7 bits: processors without instructions for 8-bit products add two of them in 16 bits."""

_BIAS_LIMIT: Final = 2**30
"""Biases take 32 bits, which must hold the sum with the products."""

_ROWS: Final = 2
"""The axis of an image's rows; the next is the axis of its columns."""

_LARGE: Final = 16384
"""Weights of so many bytes or more are kept outside the graph's own file."""


class Store:
    """Weights by content, in files beside the graphs: several graphs share the same bytes."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._files: dict[str, bytearray] = {}
        self._known: dict[bytes, tuple[str, int]] = {}

    def place(self, data: bytes, file: str) -> tuple[str, int]:
        """Return the file and the offset of bytes; new bytes are appended to `file`."""
        if data not in self._known:
            content = self._files.setdefault(file, bytearray())
            content.extend(bytes(-len(content) % 64))
            self._known[data] = (file, len(content))
            content.extend(data)
        return self._known[data]

    def write(self) -> None:
        """Write the files."""
        for name, content in self._files.items():
            with draft_of(self._folder / name) as draft:
                draft.write_bytes(content)


class Graph:
    """A graph under construction, whose large weights go into a store.

    `weights` are of the convolutions, and `ranges` of the results in 8 bits; a convolution is computed in 8 bits if its
    source has a range.
    """

    def __init__(self, name: str, store: Store, weights: Weights, ranges: Ranges) -> None:
        self._name, self._store, self._weights, self._ranges = name, store, weights, dict(ranges)
        self._nodes: list[onnx.NodeProto] = []
        self._constants: list[onnx.TensorProto] = []
        self.inputs: list[onnx.ValueInfoProto] = []
        self.outputs: list[onnx.ValueInfoProto] = []
        self.data: set[str] = set()
        """The store's files that the graph needs."""
        self.sizes: dict[str, tuple[int, int]] = {}
        """Height and width of the branches' inputs, and of every layer's result."""

    def constant(self, name: str, value: npt.ArrayLike, dtype: npt.DTypeLike = np.float32) -> str:
        """Add a constant and return its name."""
        self._constants.append(numpy_helper.from_array(np.asarray(value, dtype=dtype), name))
        return name

    def kernel(self, name: str, value: npt.ArrayLike, dtype: npt.DTypeLike = np.float32) -> str:
        """Add a constant to the store if it is large, to the graph if not."""
        self.constant(name, value, dtype)
        tensor = self._constants[-1]
        if len(tensor.raw_data) >= _LARGE:
            file, offset = self._store.place(tensor.raw_data, f"{self._name}.bin")
            external_data_helper.set_external_data(tensor, file, offset, len(tensor.raw_data))
            tensor.ClearField("raw_data")
            self.data.add(file)
        return name

    def node(self, kind: str, inputs: Sequence[str], output: str, *more: str, **attributes: object) -> str:
        """Add a node and return its first output, which names it."""
        self._nodes.append(helper.make_node(kind, list(inputs), [output, *more], output, **attributes))
        return output

    def upsample(self, source: str, output: str, size: tuple[int, int], factor: int) -> str:
        """Add the bilinear interpolation of maps by a whole factor, and return the result's name."""
        if factor == 1:
            return self.node("Identity", [source], output)
        rows = self.constant(f"{output}.rows", upsampling(size[0], factor))
        columns = self.constant(f"{output}.columns", upsampling(size[1], factor).T)
        self.node("MatMul", [source, columns], f"{output}.wide")
        return self.node("MatMul", [rows, f"{output}.wide"], output)

    def layer(self, layer: Layer) -> None:
        """Add a layer, after its sources."""
        name, sizes = layer.name, self.sizes
        match layer:
            case Conv():
                sizes[name] = _scaled(sizes[layer.source], 1, layer.stride)
                self._convolution(layer)
            case MaxPool():
                sizes[name] = _scaled(sizes[layer.source], 1, 2)
                geometry = {"kernel_shape": [3, 3], "strides": [2, 2], "pads": [1] * 4}
                self._result("MaxPool", [layer.source], name, **geometry)
            case Pool():
                sizes[name] = (1, 1)
                self._result("GlobalAveragePool", [layer.source], name)
            case Spread():
                sizes[name] = sizes[layer.like]
                size = self.constant(f"{name}.size", [1, 1, *sizes[layer.like]], np.int64)
                self._result("Expand", [layer.source, size], name)
            case Resize():
                sizes[name] = _scaled(sizes[layer.source], layer.factor)
                result = f"{name}.linear" if layer.relu else name
                self.upsample(layer.source, result, sizes[layer.source], layer.factor)
                if layer.relu:
                    self._result("Relu", [result], name)
            case Shuffle():
                sizes[name] = _scaled(sizes[layer.source], 2)
                self._result("DepthToSpace", [layer.source], name, blocksize=2, mode="CRD")
            case Concat():
                sizes[name] = sizes[layer.sources[0]]
                self._result("Concat", layer.sources, name, axis=1)

    def _result(self, kind: str, inputs: Sequence[str], name: str, **attributes: object) -> None:
        """Add a node whose result is rounded to 8 bits if it has a range."""
        if name not in self._ranges:
            self.node(kind, inputs, name, **attributes)
            return
        self.node(kind, inputs, f"{name}.exact", **attributes)
        scale, zero = _grid(self._ranges[name])
        grid = (self.constant(f"{name}.scale", scale), self.constant(f"{name}.zero", zero, np.uint8))
        self.node("QuantizeLinear", [f"{name}.exact", *grid], f"{name}.8bit")
        self.node("DequantizeLinear", [f"{name}.8bit", *grid], name)

    def _convolution(self, layer: Conv) -> None:
        height, width = self.sizes[layer.source]
        kernel, bias = self._weights[layer.name]
        kernel = kernel[:, :, layer.taps(height), layer.taps(width)]
        if layer.source in self._ranges:
            self._in_8_bits(layer, kernel, bias)
        elif kernel.shape[2:] == (1, 1) and self.sizes[layer.name] == max(self.sizes.values()):
            self._product(layer, kernel, bias)
        else:
            self.kernel(f"{layer.name}.kernel", kernel)
            self.constant(f"{layer.name}.bias", bias)
            pads = [layer.padding(height), layer.padding(width)]
            self._convolve(layer, layer.name, layer.source, kernel.shape[2:], pads)

    def _convolve(
        self, layer: Conv, name: str, source: str, taps: Sequence[int], pads: Sequence[int]
    ) -> None:
        """Add a convolution by the kernel `<name>.kernel`, with its addition and ReLU."""
        steps = [("Add", [layer.add])] * bool(layer.add) + [("Relu", [])] * layer.relu
        value = f"{name}.conv" if steps else name
        self._result(
            "Conv",
            [source, f"{name}.kernel", f"{layer.name}.bias"],
            value,
            kernel_shape=taps,
            strides=[layer.stride] * 2,
            dilations=[layer.dilation] * 2,
            pads=[*pads, *pads],
        )
        for index, (kind, more) in enumerate(steps, start=1):
            output = name if index == len(steps) else f"{name}.{kind.lower()}"
            self._result(kind, [value, *more], output)
            value = output

    def _product(self, layer: Conv, kernel: _Array, bias: _Array) -> None:
        """Add a 1x1 convolution of full-size maps as a matrix product, for which the runtime reorders less."""
        name, (height, width) = layer.name, max(self.sizes.values())
        flat = self.constant(f"{name}.flat", [kernel.shape[1], height * width], np.int64)
        factors = (
            self.kernel(f"{name}.kernel", kernel[:, :, 0, 0]),
            self.node("Reshape", [layer.source, flat], f"{name}.pixels"),
            self.constant(f"{name}.bias", bias[:, None]),
        )
        value = self.node("Gemm", factors, f"{name}.product")
        if layer.relu:
            value = self.node("Relu", [value], f"{name}.relu")
        shape = self.constant(f"{name}.shape", [1, len(kernel), height, width], np.int64)
        self.node("Reshape", [value, shape], name)

    def _in_8_bits(self, layer: Conv, kernel: _Array, bias: _Array) -> None:
        """Add a convolution by a kernel in 7 bits, with a scale per output channel, the bias on its grid."""
        name = layer.name
        greatest = np.abs(kernel).max(axis=(1, 2, 3))
        step_of_input = np.float32(_grid(self._ranges[layer.source])[0])
        scales = np.maximum(greatest, 1e-8).astype(np.float32) / _KERNEL_LIMIT
        scales = np.maximum(scales, np.abs(bias) / (step_of_input * _BIAS_LIMIT)).astype(np.float32)
        self.kernel(f"{name}.kernel.8bit", np.rint(kernel / scales[:, None, None, None]), np.int8)
        grid = (
            self.constant(f"{name}.kernel.scale", scales),
            self.constant(f"{name}.kernel.zero", np.zeros(len(scales)), np.int8),
        )
        products = scales * step_of_input
        rounded = self.constant(f"{name}.bias.32bit", np.rint(bias / products), np.int32)
        step = self.constant(f"{name}.bias.scale", products)
        self.node("DequantizeLinear", [rounded, step], f"{name}.bias", axis=0)
        taps, sizes = list(kernel.shape[2:]), self.sizes[layer.source]
        pads = [layer.padding(size) for size in sizes]
        for axis, size in enumerate(sizes):
            if layer.worth_cutting(size):
                self._in_regions(layer, axis, taps, pads, grid)
                return
        self.node("DequantizeLinear", [f"{name}.kernel.8bit", *grid], f"{name}.kernel", axis=0)
        self._convolve(layer, name, layer.source, taps, pads)

    def _in_regions(
        self, layer: Conv, axis: int, taps: Sequence[int], pads: Sequence[int], grid: Sequence[str]
    ) -> None:
        """Add a convolution in 8 bits as a convolution for each region, along rows (0) or columns (1)."""
        regions = layer.regions(self.sizes[layer.source][axis])
        parts = [f"{layer.name}.region{index}" for index in range(len(regions))]
        for part, (rows, kept) in zip(parts, regions, strict=True):
            self._ranges[part] = self._ranges[layer.name]
            self._ranges[f"{part}.source"] = self._ranges[layer.source]
            bounds = self._bounds(f"{part}.source", rows, axis)
            self._result("Slice", [layer.source, *bounds], f"{part}.source")
            bounds = self._bounds(f"{part}.kernel", kept, axis)
            self.node("Slice", [f"{layer.name}.kernel.8bit", *bounds], f"{part}.kernel.8bit")
            self.node("DequantizeLinear", [f"{part}.kernel.8bit", *grid], f"{part}.kernel", axis=0)
            own, around = list(taps), list(pads)
            own[axis], around[axis] = kept.stop - kept.start, 0
            self._convolve(layer, part, f"{part}.source", own, around)
        self._result("Concat", parts, layer.name, axis=_ROWS + axis)

    def _bounds(self, name: str, part: slice, axis: int) -> list[str]:
        """Add the constants of `Slice` for rows (0) or columns (1)."""
        values = {"start": part.start, "stop": part.stop, "axis": _ROWS + axis}
        return [self.constant(f"{name}.{key}", [value], np.int64) for key, value in values.items()]

    def write(self, path: Path) -> None:
        """Write and check the graph, after the store."""
        body = helper.make_graph(self._nodes, self._name, self.inputs, self.outputs, self._constants)
        opset = helper.make_opsetid("", 18)
        model = helper.make_model(body, opset_imports=[opset], ir_version=9, producer_name="sunset")
        with draft_of(path) as draft:
            draft.write_bytes(model.SerializeToString(deterministic=True))
        checker.check_model(os.fspath(path))


def _scaled(size: tuple[int, int], factor: int, stride: int = 1) -> tuple[int, int]:
    return -(-size[0] * factor // stride), -(-size[1] * factor // stride)


def _grid(limits: tuple[float, float]) -> tuple[float, int]:
    """Return scale and zero point of the 8-bit numbers that cover a range and 0."""
    low, high = min(limits[0], 0.0), max(limits[1], 0.0)
    scale = max(high - low, 1e-8) / 255
    return scale, round(-low / scale)


def stored_weights(model: Model, config: TrainingConfig) -> Weights:
    """Return the weights of a model that `train` wrote, for the networks of a training.

    Weights in 8 bits are converted; rows and columns of kernels that were not stored are zeros.
    """
    weights = {}
    for name in config.modalities:
        why = f"it has no network {name!r}"
        try:
            network = model.card.networks[Modality[name.upper()]]
            graph = onnx.load(model.folder / network.file).graph
            constants = {tensor.name: tensor for tensor in graph.initializer}
            for layer in convolutions(config.plan((name,))):
                why = f"its network {name!r} has no such layer {layer.name}"
                weights[layer.name] = _stored(layer, constants)
        except (KeyError, ValueError) as error:
            raise InvalidInputError(
                f"A training of {config.shape.name} ({', '.join(config.modalities)}) cannot start from the model "
                f"{model.card.name!r}: {why}. Start from a model that 'sunset train' made with the same --model and "
                "--modality."
            ) from error
    return weights


def _stored(layer: Conv, constants: Mapping[str, onnx.TensorProto]) -> tuple[_Array, _Array]:
    """Return a layer's kernel and bias; a missing or unsuitable constant raises KeyError or ValueError."""

    def constant(key: str) -> _Array:
        array: _Array = numpy_helper.to_array(constants[f"{layer.name}.{key}"])
        return array

    if f"{layer.name}.kernel.8bit" in constants:
        kernel = constant("kernel.8bit") * constant("kernel.scale")[:, None, None, None]
        bias = constant("bias.32bit") * constant("bias.scale")
    else:
        kernel, bias = constant("kernel"), constant("bias")
    kernel = kernel.reshape(*layer.channels[::-1], *(kernel.shape[2:] or (1, 1)))
    unstored = [(layer.kernel - taps) // 2 for taps in kernel.shape[2:]]
    kernel = np.pad(kernel, [(0, 0), (0, 0), *((each, each) for each in unstored)])
    return kernel.astype(np.float32), bias.astype(np.float32).reshape(layer.channels[1])
