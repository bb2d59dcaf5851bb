"""Finds the ranges of results, so that networks can be computed in 8 bits."""

from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np
import torch

from sunset.training.architecture import Concat, Conv, Layer, MaxPool, Pool, Spread
from sunset.training.batches import FrameSet
from sunset.training.network import forward, frame_inputs
from sunset.training.onnx_layers import Ranges

__all__ = ["ranges"]

_FRAMES: Final = 32
_OUTLIERS: Final = 1e-4
"""The share of the values looked at, of a frame's result, that may lie outside its range on either side."""


def ranges(layers: Sequence[Layer], modules: Any, frames: FrameSet) -> Ranges:
    """Return the ranges of the results that can do with 8 bits, on evenly chosen frames and values.

    The rest stays in float: a branch's input and first convolution, the logits, and the late fusion.

    Args:
        layers: the plan of all branches.
        modules: with their weights, in evaluation mode.
        frames: that the weights were learned on.
    """
    names = set(_rounded(layers))
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in names}
    for index in np.linspace(0, len(frames) - 1, min(_FRAMES, len(frames))).astype(int):
        results = frame_inputs(frames.bgr[index : index + 1], frames.depth[index : index + 1])
        with torch.no_grad():
            forward(layers, modules, results)
        for name, limits in found.items():
            values = results[name].numpy().ravel()
            low, high = np.quantile(values[:: 1 + values.size // 50_000], (_OUTLIERS, 1 - _OUTLIERS))
            limits.append((float(low), float(high)))
    return {
        name: (min(low for low, _ in limits), max(high for _, high in limits))
        for name, limits in found.items()
    }


def _rounded(layers: Sequence[Layer]) -> Iterator[str]:
    """Yield the names of the results that are rounded."""
    for layer in layers:
        match layer:
            case Conv() if layer.norm:
                yield layer.name
                if layer.add:
                    yield f"{layer.name}.conv"
            case MaxPool() | Pool() | Spread() | Concat():
                yield layer.name
            case _:
                pass
