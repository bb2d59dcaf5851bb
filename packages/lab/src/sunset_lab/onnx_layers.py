"""The layers of a plan as nodes of ONNX."""

from collections.abc import Mapping, Sequence
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

from sunset_lab.architecture import Concat, Conv, Layer, MaxPool, Pool, Resize, Shuffle, Spread
from sunset_lab.onnx_writer import Graph

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


class Layers:
    """Writes layers into a graph.

    Args:
        graph: receives them.
        weights: of the convolutions.
        inputs: height and width of the inputs, by name.
        ranges: of the results in 8 bits; a convolution is computed in 8 bits if its source has a range.
    """

    def __init__(
        self, graph: Graph, weights: Weights, inputs: Mapping[str, tuple[int, int]], ranges: Ranges
    ) -> None:
        self.sizes = dict(inputs)
        """Height and width of every result."""
        self._graph = graph
        self._weights = weights
        self._full = max(inputs.values())
        self._ranges = dict(ranges)

    def write(self, layer: Layer) -> None:
        """Add a layer, after its sources."""
        graph, sizes = self._graph, self.sizes
        match layer:
            case Conv():
                sizes[layer.name] = _scaled(sizes[layer.source], 1, layer.stride)
                self._convolution(layer)
            case MaxPool():
                sizes[layer.name] = _scaled(sizes[layer.source], 1, 2)
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
                sizes[layer.name] = _scaled(sizes[layer.source], layer.factor)
                result = f"{layer.name}.linear" if layer.relu else layer.name
                graph.upsample(layer.source, result, sizes[layer.source], layer.factor)
                if layer.relu:
                    self._result("Relu", [result], layer.name)
            case Shuffle():
                sizes[layer.name] = _scaled(sizes[layer.source], 2)
                self._result("DepthToSpace", [layer.source], layer.name, blocksize=2, mode="CRD")
            case Concat():
                sizes[layer.name] = sizes[layer.sources[0]]
                self._result("Concat", layer.sources, layer.name, axis=1)

    def _result(self, kind: str, inputs: Sequence[str], name: str, **attributes: object) -> None:
        """Add a node whose result is rounded to 8 bits if it has a range."""
        if name not in self._ranges:
            self._graph.node(kind, inputs, name, **attributes)
            return
        self._graph.node(kind, inputs, f"{name}.exact", **attributes)
        scale, zero = _grid(self._ranges[name])
        grid = (
            self._graph.constant(f"{name}.scale", scale),
            self._graph.constant(f"{name}.zero", zero, np.uint8),
        )
        self._graph.node("QuantizeLinear", [f"{name}.exact", *grid], f"{name}.8bit")
        self._graph.node("DequantizeLinear", [f"{name}.8bit", *grid], name)

    def _convolution(self, layer: Conv) -> None:
        height, width = self.sizes[layer.source]
        kernel, bias = self._weights[layer.name]
        kernel = kernel[:, :, layer.taps(height), layer.taps(width)]
        if layer.source in self._ranges:
            self._in_8_bits(layer, kernel, bias)
        elif kernel.shape[2:] == (1, 1) and self.sizes[layer.name] == self._full:
            self._product(layer, kernel, bias)
        else:
            self._graph.weights(f"{layer.name}.kernel", kernel)
            self._graph.constant(f"{layer.name}.bias", bias)
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
        graph, name, (height, width) = self._graph, layer.name, self._full
        flat = graph.constant(f"{name}.flat", [kernel.shape[1], height * width], np.int64)
        factors = (
            graph.weights(f"{name}.kernel", kernel[:, :, 0, 0]),
            graph.node("Reshape", [layer.source, flat], f"{name}.pixels"),
            graph.constant(f"{name}.bias", bias[:, None]),
        )
        value = graph.node("Gemm", factors, f"{name}.product")
        if layer.relu:
            value = graph.node("Relu", [value], f"{name}.relu")
        shape = graph.constant(f"{name}.shape", [1, len(kernel), height, width], np.int64)
        graph.node("Reshape", [value, shape], name)

    def _in_8_bits(self, layer: Conv, kernel: _Array, bias: _Array) -> None:
        """Add a convolution by a kernel in 7 bits, with a scale per output channel, the bias on its grid."""
        graph, name = self._graph, layer.name
        greatest = np.abs(kernel).max(axis=(1, 2, 3))
        step_of_input = np.float32(_grid(self._ranges[layer.source])[0])
        scales = np.maximum(greatest, 1e-8).astype(np.float32) / _KERNEL_LIMIT
        scales = np.maximum(scales, np.abs(bias) / (step_of_input * _BIAS_LIMIT)).astype(np.float32)
        graph.weights(f"{name}.kernel.8bit", np.rint(kernel / scales[:, None, None, None]), np.int8)
        graph.constant(f"{name}.kernel.scale", scales)
        graph.constant(f"{name}.kernel.zero", np.zeros(len(scales)), np.int8)
        products = scales * step_of_input
        rounded = graph.constant(f"{name}.bias.32bit", np.rint(bias / products), np.int32)
        step = graph.constant(f"{name}.bias.scale", products)
        graph.node("DequantizeLinear", [rounded, step], f"{name}.bias", axis=0)
        taps, sizes = list(kernel.shape[2:]), self.sizes[layer.source]
        pads = [layer.padding(size) for size in sizes]
        for axis, size in enumerate(sizes):
            if layer.worth_cutting(size):
                self._in_regions(layer, axis, taps, pads)
                return
        self._dequantise(layer, f"{name}.kernel.8bit", f"{name}.kernel")
        self._convolve(layer, name, layer.source, taps, pads)

    def _in_regions(self, layer: Conv, axis: int, taps: Sequence[int], pads: Sequence[int]) -> None:
        """Add a convolution in 8 bits as a convolution for each region, along rows (0) or columns (1)."""
        regions = layer.regions(self.sizes[layer.source][axis])
        parts = [f"{layer.name}.region{index}" for index in range(len(regions))]
        for part, region in zip(parts, regions, strict=True):
            self._ranges[part] = self._ranges[layer.name]
            self._ranges[f"{part}.source"] = self._ranges[layer.source]
            bounds = self._graph.bounds(f"{part}.source", _ROWS + axis, region.source)
            self._result("Slice", [layer.source, *bounds], f"{part}.source")
            bounds = self._graph.bounds(f"{part}.kernel", _ROWS + axis, region.taps)
            self._graph.node("Slice", [f"{layer.name}.kernel.8bit", *bounds], f"{part}.kernel.8bit")
            self._dequantise(layer, f"{part}.kernel.8bit", f"{part}.kernel")
            own, around = list(taps), list(pads)
            own[axis], around[axis] = region.taps.stop - region.taps.start, 0
            self._convolve(layer, part, f"{part}.source", own, around)
        self._result("Concat", parts, layer.name, axis=_ROWS + axis)

    def _dequantise(self, layer: Conv, stored: str, kernel: str) -> None:
        grid = (f"{layer.name}.kernel.scale", f"{layer.name}.kernel.zero")
        self._graph.node("DequantizeLinear", [stored, *grid], kernel, axis=0)


def _scaled(size: tuple[int, int], factor: int, stride: int = 1) -> tuple[int, int]:
    return -(-size[0] * factor // stride), -(-size[1] * factor // stride)


def _grid(limits: tuple[float, float]) -> tuple[float, int]:
    """Return scale and zero point of the 8-bit numbers that cover a range and 0."""
    low, high = min(limits[0], 0.0), max(limits[1], 0.0)
    scale = max(high - low, 1e-8) / 255
    return scale, round(-low / scale)
