"""The part of an exported network before the first convolution: from raw frames to a branch's input."""

from typing import Final

import numpy as np
from onnx import TensorProto

from sunset.training.inputs import CONTRASTS, DEPTH_LIMIT_M, FAR_PLANE_M, REFERENCE_DEPTH_M, RGB_MEAN, RGB_STD
from sunset.training.onnx_writer import Graph

_COUNTS: Final = 65535


def rgb_input(graph: Graph) -> None:
    """Add `rgb.input` (1, 3, H, W), normalised, from `bgr` (H, W, 3) uint8."""
    graph.node("Transpose", ["bgr"], "bgr.planes", perm=[2, 0, 1])
    graph.node("Cast", ["bgr.planes"], "bgr.float", to=TensorProto.FLOAT)
    order = graph.constant("rgb.order", [2, 1, 0], np.int64)
    graph.node("Gather", ["bgr.float", order], "rgb.planes", axis=0)
    scale = 1 / (255 * np.asarray(RGB_STD)).reshape(1, 3, 1, 1)
    shift = -(np.asarray(RGB_MEAN) / np.asarray(RGB_STD)).reshape(1, 3, 1, 1)
    graph.node("Mul", ["rgb.planes", graph.constant("rgb.scale", scale)], "rgb.scaled")
    graph.node("Add", ["rgb.scaled", graph.constant("rgb.shift", shift)], "rgb.input")


def _depth_plane(graph: Graph, size: tuple[int, int]) -> None:
    shape = graph.constant("depth.shape", [1, 1, *size], np.int64)
    graph.node("Cast", ["depth"], "depth.counts", to=TensorProto.FLOAT)
    graph.node("Reshape", ["depth.counts", shape], "depth.plane")


def depth_input(graph: Graph, size: tuple[int, int]) -> None:
    """Add `depth.input` (1, 3, H, W), logarithm and local contrasts, from `depth` (H, W) uint16."""
    height, width = size
    _depth_plane(graph, size)
    graph.node("Mul", ["depth.plane", graph.constant("depth.unit", FAR_PLANE_M / _COUNTS)], "depth.metres")
    graph.node("Max", ["depth.metres", graph.constant("depth.nearest", 1)], "depth.positive")
    reference = graph.constant("depth.reference", 1 / REFERENCE_DEPTH_M)
    graph.node("Mul", ["depth.positive", reference], "depth.relative")
    channels = [graph.node("Log", ["depth.relative"], "depth.log")]
    graph.node("Min", ["depth.metres", graph.constant("depth.limit", DEPTH_LIMIT_M)], "depth.near")
    for block, unit, limit in CONTRASTS:
        name = f"depth.contrast{block}"
        mean = f"{name}.blocks"
        graph.node("AveragePool", ["depth.near"], mean, kernel_shape=[block, block], strides=[block, block])
        graph.upsample(mean, f"{name}.mean", (height // block, width // block), block)
        graph.node("Sub", ["depth.near", f"{name}.mean"], f"{name}.metres")
        graph.node("Mul", [f"{name}.metres", graph.constant(f"{name}.unit", 1 / unit)], f"{name}.units")
        low, high = graph.constant(f"{name}.low", -limit), graph.constant(f"{name}.high", limit)
        channels.append(graph.node("Clip", [f"{name}.units", low, high], name))
    graph.node("Concat", channels, "depth.input", axis=1)


def published_depth_input(graph: Graph, size: tuple[int, int]) -> None:
    """Add `depth.input` (1, 3, H, W) as the published networks take it: 0 to 1, three times the same."""
    _depth_plane(graph, size)
    graph.node("Mul", ["depth.plane", graph.constant("depth.unit", 1 / _COUNTS)], "depth.share")
    graph.node("Concat", ["depth.share"] * 3, "depth.input", axis=1)
