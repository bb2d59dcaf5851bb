"""Finds the ranges of results, so that networks can be computed in 8 bits."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
import torch
from torch import nn

from sunset.training.architecture import Layer, rounded
from sunset.training.batches import FrameSet
from sunset.training.network import digest_of_weights, forward, frame_inputs
from sunset.training.onnx_layers import Ranges
from sunset.training.spread import Arrays, keep

_OUTLIERS: Final = 1e-4
"""The share of the values looked at, of a frame's result, that may lie outside its range on either side."""


def ranges(layers: Sequence[Layer], modules: nn.Module, frames: FrameSet, kept: Path | None = None) -> Ranges:
    """Return the ranges of the results that can do with 8 bits, on evenly chosen training frames and values.

    The rest stays in float: a branch's input and first convolution, the logits, and the late fusion. The plan is of
    all branches, the modules are in evaluation mode, and `kept` is a folder that keeps what was found, frame by frame.
    """
    names = tuple(sorted(rounded(layers)))
    what = kept and (digest_of_weights(modules.state_dict()), frames.digest())
    work = keep(partial(_limits, layers, modules, frames, names), kept, "ranges", names, what)
    chosen = np.linspace(0, len(frames) - 1, min(32, len(frames))).astype(int)
    limits = np.array([work(int(index))[0] for index in chosen])
    lowest, highest = limits[:, :, 0].min(axis=0), limits[:, :, 1].max(axis=0)
    return {name: (float(low), float(high)) for name, low, high in zip(names, lowest, highest, strict=True)}


def _limits(
    layers: Sequence[Layer], modules: nn.Module, frames: FrameSet, names: Sequence[str], index: int
) -> Arrays:
    """Return the ranges of results on a frame, (names, 2)."""
    results = frame_inputs(frames.bgr[index : index + 1], frames.depth[index : index + 1])
    with torch.no_grad():
        forward(layers, modules, results)
    values = (results[name].numpy().ravel() for name in names)
    limits = [np.quantile(v[:: 1 + v.size // 50_000], (_OUTLIERS, 1 - _OUTLIERS)) for v in values]
    return (np.array(limits, dtype=np.float64),)
