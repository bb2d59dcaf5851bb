"""Plans of `architecture` and their weights as ONNX models, from raw frames to labels and entropy."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from onnx import TensorProto
from onnx.helper import make_tensor_value_info

from sunset.classes import CLASSES
from sunset.files.inputs import file_digest
from sunset.perception import Modality, ModelCard, NetworkCard
from sunset_lab.architecture import (
    CONTRASTS,
    DEPTH_LIMIT_M,
    FAR_PLANE_M,
    HEIGHT,
    REFERENCE_DEPTH_M,
    RGB_MEAN,
    RGB_STD,
    WIDTH,
    Layer,
    convolutions,
)
from sunset_lab.calibrate import TEMPERATURE, version_of
from sunset_lab.onnx_layers import Graph, Ranges, Store, Weights

_COUNTS: Final = 65535


@dataclass(frozen=True, slots=True)
class Format:
    """The frames that an exported network takes, and the precision of its numbers."""

    # Height and width of the frames; multiples of 8, and of 16 unless depth is as published.
    size: tuple[int, int] = (HEIGHT, WIDTH)
    published_depth: bool = False  # as in SynDrone's benchmark, not as logarithm and contrasts
    # Of the results in 8 bits; a convolution is computed in 8 bits if its source has a range.
    ranges: Ranges | None = None


@dataclass(frozen=True, slots=True)
class Network:
    """A network of a model: its plan, which ends with the logits, and the plan's `folded_weights`."""

    layers: tuple[Layer, ...]
    weights: Weights

    @property
    def parameters(self) -> int:
        """The number of weights, with the normalisation folded in."""
        used = [self.weights[layer.name] for layer in convolutions(self.layers)]
        return sum(kernel.size + bias.size for kernel, bias in used)


def export(folder: Path, networks: Mapping[Modality, Network], form: Format, card: Mapping[str, Any]) -> None:
    """Write a model: its networks as ONNX, with shared weights in files beside them, and its card.

    The inputs are raw: `bgr` (H, W, 3) uint8 and `depth` (H, W) uint16, as far as the network needs them. The outputs
    are `logits` (1, 28, h, w) float32 at the network's stride, not interpolated and without the temperature; `labels`
    (H, W) uint8, the class of the greatest interpolated logit; and `entropy`, the mean over pixels of the normalised
    Shannon entropy of the softmax of the interpolated logits over the constant `temperature`.

    `card` has the fields of `ModelCard` that do not follow from the networks; thresholds are not set.
    """
    folder.mkdir(parents=True, exist_ok=True)
    store, graphs, cards = Store(folder), {}, {}
    for modality in sorted(networks, reverse=True):  # branches first: their files hold what the fusion shares
        graphs[modality] = _graph(modality, networks[modality], form, store)
    store.write()
    for modality, graph in sorted(graphs.items()):
        path = folder / f"{modality.key}.onnx"
        graph.write(path)
        data = {name: file_digest(folder / name) for name in sorted(graph.data)}
        cards[modality] = NetworkCard(path.name, file_digest(path), networks[modality].parameters, 1.0, data)
    ModelCard(
        version=version_of(cards),
        height=form.size[0],
        width=form.size[1],
        classes=CLASSES,
        entropy_threshold=1.0,
        sharpness_threshold=0.0,
        networks=cards,
        precision="int8" if form.ranges else "float32",
        **card,
    ).write(folder)


def _graph(modality: Modality, network: Network, form: Format, store: Store) -> Graph:
    graph = Graph(modality.key, store, network.weights, form.ranges or {})
    if modality.needs_rgb:
        graph.sizes["rgb.input"] = form.size
        graph.inputs.append(make_tensor_value_info("bgr", TensorProto.UINT8, [*form.size, 3]))
        _rgb_input(graph)
    if modality.needs_depth:
        graph.sizes["depth.input"] = form.size
        graph.inputs.append(make_tensor_value_info("depth", TensorProto.UINT16, form.size))
        _depth_input(graph, form.size, published=form.published_depth)
    for layer in network.layers:
        graph.layer(layer)
    logits = network.layers[-1].name
    _outputs(graph, logits, form.size)
    graph.outputs += [
        make_tensor_value_info("logits", TensorProto.FLOAT, [1, len(CLASSES), *graph.sizes[logits]]),
        make_tensor_value_info("labels", TensorProto.UINT8, form.size),
        make_tensor_value_info("entropy", TensorProto.FLOAT, []),
    ]
    return graph


def _rgb_input(graph: Graph) -> None:
    """Add `rgb.input` (1, 3, H, W), normalised, from `bgr` (H, W, 3) uint8."""
    graph.node("Transpose", ["bgr"], "bgr.planes", perm=[2, 0, 1])
    graph.node("Cast", ["bgr.planes"], "bgr.float", to=TensorProto.FLOAT)
    order = graph.constant("rgb.order", [2, 1, 0], np.int64)
    graph.node("Gather", ["bgr.float", order], "rgb.planes", axis=0)
    scale = 1 / (255 * np.asarray(RGB_STD)).reshape(1, 3, 1, 1)
    shift = -(np.asarray(RGB_MEAN) / np.asarray(RGB_STD)).reshape(1, 3, 1, 1)
    graph.node("Mul", ["rgb.planes", graph.constant("rgb.scale", scale)], "rgb.scaled")
    graph.node("Add", ["rgb.scaled", graph.constant("rgb.shift", shift)], "rgb.input")


def _depth_input(graph: Graph, size: tuple[int, int], *, published: bool) -> None:
    """Add `depth.input` (1, 3, H, W) from `depth` (H, W) uint16.

    It is the logarithm and local contrasts, or, as the published networks take it, from 0 to 1 in all three channels.
    """
    height, width = size
    shape = graph.constant("depth.shape", [1, 1, *size], np.int64)
    graph.node("Cast", ["depth"], "depth.counts", to=TensorProto.FLOAT)
    graph.node("Reshape", ["depth.counts", shape], "depth.plane")
    if published:
        graph.node("Mul", ["depth.plane", graph.constant("depth.unit", 1 / _COUNTS)], "depth.share")
        graph.node("Concat", ["depth.share"] * 3, "depth.input", axis=1)
        return
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


def _outputs(graph: Graph, logits: str, size: tuple[int, int]) -> None:
    """Add the outputs `logits`, `labels` and `entropy` for frames of the size `size`.

    Softmax ignores a constant added to all classes of a pixel, and interpolation is linear; therefore the greatest
    logit of each coarse pixel is subtracted before the interpolation, so that the exponentials cannot overflow. Logits
    of more than 60 below the greatest count as 60 below, also for the pixels between: in flights this increased the
    entropy of the depth network of `lite` by 0.0002 on average, and by 0.0004 at most. Sums over classes are products
    with a row of ones, which is five times faster than a reduction along that axis.
    """
    small, (height, width) = graph.sizes[logits], size
    graph.node("Identity", [logits], "logits")
    greatest, labels = _greatest(graph, logits, "coarse")
    graph.node("Sub", [logits, greatest], "below")
    graph.node("Max", ["below", graph.constant("least", -60)], "bounded")
    graph.upsample("bounded", "scores", small, height // small[0])
    if small != size:
        _, labels = _greatest(graph, "scores", "fine")
    graph.node("Reshape", [labels, graph.constant("labels.shape", [height, width], np.int64)], "labels")
    flat = graph.constant("scores.shape", [len(CLASSES), height * width], np.int64)
    ones = graph.constant("ones", np.ones((1, len(CLASSES))))
    graph.node("Reshape", ["scores", flat], "scores.flat")
    graph.node("Div", ["scores.flat", graph.constant(TEMPERATURE, 1)], "x")
    graph.node("Exp", ["x"], "exp")
    graph.node("MatMul", [ones, "exp"], "sum")
    graph.node("Mul", ["exp", "x"], "weighted")
    graph.node("MatMul", [ones, "weighted"], "weighted.sum")
    graph.node("Log", ["sum"], "log.sum")
    graph.node("Div", ["weighted.sum", "sum"], "mean.x")
    graph.node("Sub", ["log.sum", "mean.x"], "entropy.nats")
    graph.node("ReduceMean", ["entropy.nats"], "entropy.mean", keepdims=0)
    graph.node("Mul", ["entropy.mean", graph.constant("nats", 1 / np.log(len(CLASSES)))], "entropy")


def _greatest(graph: Graph, scores: str, name: str) -> tuple[str, str]:
    """Add the greatest of each pixel's scores (1, 28, h, w) and its class, both (1, 1, h, w).

    Each round compares one half of the classes with the other, which is several times faster than `ArgMax`, whose axis
    is far apart in memory.
    """
    left = len(CLASSES)
    labels = graph.constant(f"{name}.classes", np.arange(left).reshape(1, left, 1, 1), np.uint8)
    while left > 1:
        half, odd = divmod(left, 2)
        n = f"{name}.of{left}"
        sizes = graph.constant(f"{n}.sizes", [half, half] + [1] * odd, np.int64)
        score = [f"{n}.scores{index}" for index in range(2 + odd)]
        label = [f"{n}.labels{index}" for index in range(2 + odd)]
        graph.node("Split", [scores, sizes], *score, axis=1)
        graph.node("Split", [labels, sizes], *label, axis=1)
        wins = graph.node("Greater", [score[1], score[0]], f"{n}.wins")
        labels = graph.node("Where", [wins, label[1], label[0]], f"{n}.labels")
        scores = graph.node("Max", score[:2], f"{n}.scores")
        if odd:
            scores = graph.node("Concat", [scores, score[2]], f"{n}.all.scores", axis=1)
            labels = graph.node("Concat", [labels, label[2]], f"{n}.all.labels", axis=1)
        left = half + odd
    return scores, labels
