"""The part of an exported network after its logits: labels and entropy at full size."""

import numpy as np

from sunset.classes import CLASSES
from sunset.training.onnx_writer import Graph


def write_outputs(
    graph: Graph, logits: str, small: tuple[int, int], size: tuple[int, int], temperature: float
) -> None:
    """Add the outputs `logits`, `labels` and `entropy`.

    Softmax is blind to a constant added to all classes of a pixel, and interpolation is linear; so the
    greatest logit of each coarse pixel is taken off before interpolating, and the exponentials at full
    resolution cannot overflow. What is more than 60 below the greatest counts as 60 below, which
    interpolation carries to the pixels between: in flights this made the entropy of the depth network of
    `lite` 0.0002 higher on average, 0.0004 at most. Sums over classes are products with a row of ones,
    which is five times faster than a reduction along that axis.

    The logits have height and width `small`, the frames `size`. For the entropy's softmax they are divided by the
    temperature.
    """
    height, width = size
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


def _greatest(graph: Graph, scores: str, name: str) -> tuple[str, str]:
    """Add the greatest of each pixel's scores (1, 28, h, w) and its class, both (1, 1, h, w).

    Each round lets half of the classes play the other half, which is several times faster than `ArgMax`, a walk
    along an axis far apart in memory.
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
