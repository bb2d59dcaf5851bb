"""Ranges of results, which networks in 8 bits need."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
import torch
from torch import nn

from sunset_lab.architecture import Concat, Conv, Layer, MaxPool, Pool, Spread
from sunset_lab.batches import FrameSet
from sunset_lab.network import digest_of_weights, forward, frame_inputs
from sunset_lab.onnx_layers import Ranges
from sunset_lab.over_frames import Arrays, keep

_OUTLIERS: Final = 1e-4
"""The share of a frame's sampled values that may lie outside the range on either side."""


def ranges(layers: Sequence[Layer], modules: nn.Module, frames: FrameSet, kept: Path | None = None) -> Ranges:
    """Return the ranges of the results that are stored in 8 bits, sampled on at most 32 frames.

    A branch's input and first convolution, its logits and the late fusion stay in float.

    Args:
        layers: the plan of all branches.
        modules: in evaluation mode.
        frames: of the training.
        kept: a folder that keeps the result of each frame; None to keep none.
    """
    names = tuple(sorted(_rounded(layers)))
    origin = kept and (digest_of_weights(modules.state_dict()), frames.digest())
    work = keep(partial(_limits, layers, modules, frames, names), kept, "ranges", names, origin)
    chosen = np.linspace(0, len(frames) - 1, min(32, len(frames))).astype(int)
    limits = np.array([work(int(index))[0] for index in chosen])
    lowest, highest = limits[:, :, 0].min(axis=0), limits[:, :, 1].max(axis=0)
    return {name: (float(low), float(high)) for name, low, high in zip(names, lowest, highest, strict=True)}


def _rounded(layers: Sequence[Layer]) -> set[str]:
    """Return the names of the results that are stored in 8 bits."""
    names = set()
    for layer in layers:
        if isinstance(layer, Conv) and layer.norm:
            names |= {layer.name, f"{layer.name}.conv"} if layer.add else {layer.name}
        elif isinstance(layer, MaxPool | Pool | Spread | Concat):
            names.add(layer.name)
    return names


def _limits(
    layers: Sequence[Layer], modules: nn.Module, frames: FrameSet, names: Sequence[str], index: int
) -> Arrays:
    """Return the ranges of the named results on a frame, (names, 2)."""
    results = frame_inputs(frames.bgr[index : index + 1], frames.depth[index : index + 1])
    with torch.no_grad():
        forward(layers, modules, results)
    values = (results[name].numpy().ravel() for name in names)
    limits = [np.quantile(v[:: 1 + v.size // 50_000], (_OUTLIERS, 1 - _OUTLIERS)) for v in values]
    return (np.array(limits, dtype=np.float64),)
