"""The torch side of the networks: runs a plan of `architecture`, and gives its weights as arrays."""

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import torch
from torch import nn
from torch.nn import functional

from sunset.training.architecture import Concat, Conv, Layer, Pool, Resize, Shuffle, convolutions
from sunset.training.inputs import (
    CONTRASTS,
    DEPTH_LIMIT_M,
    FAR_PLANE_M,
    REFERENCE_DEPTH_M,
    RGB_MEAN,
    RGB_STD,
    upsampling,
)

__all__ = ["Weights", "build", "depth_input", "folded_weights", "forward", "rgb_input", "upsample"]

Weights: TypeAlias = Mapping[str, tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]]
"""Per convolution its kernel (out, in, k, k) and bias (out,), normalisation folded in."""


def _key(name: str) -> str:
    return name.replace(".", "_")


def build(layers: Sequence[Layer], momentum: float = 0.1) -> Any:
    """Return a torch `ModuleDict` with the weights of a plan, drawn from torch's global generator.

    Args:
        layers: the plan.
        momentum: of the normalisation's running statistics; with 0.01 a short training is useless.
    """
    modules = nn.ModuleDict()
    for layer in convolutions(tuple(layers)):
        conv = nn.Conv2d(
            *layer.channels,
            layer.kernel,
            layer.stride,
            padding=layer.dilation * (layer.kernel // 2),
            dilation=layer.dilation,
            bias=not layer.norm,
        )
        nn.init.kaiming_normal_(conv.weight, mode="fan_out", nonlinearity="relu")
        parts = [conv]
        if layer.norm:
            parts.append(nn.BatchNorm2d(layer.channels[1], momentum=momentum))
        if layer.add and layer.norm:
            nn.init.constant_(parts[1].weight, 0.5)  # a block starts out near its shortcut
        modules[_key(layer.name)] = nn.Sequential(*parts)
    return modules.to(memory_format=torch.channels_last)


def forward(layers: Sequence[Layer], modules: Any, results: dict[str, Any]) -> None:
    """Run a plan; `results` holds the inputs by name and receives every layer's result (N, C, H, W)."""
    for layer in layers:
        match layer:
            case Conv():
                y = modules[_key(layer.name)](results[layer.source])
                if layer.add:
                    y = y + results[layer.add]
                results[layer.name] = functional.relu(y) if layer.relu else y
            case Pool():
                results[layer.name] = results[layer.source].mean((2, 3), keepdim=True)
            case Resize():
                results[layer.name] = functional.interpolate(
                    results[layer.source], scale_factor=layer.factor, mode="bilinear"
                )
            case Shuffle():
                results[layer.name] = functional.pixel_shuffle(results[layer.source], 2)
            case Concat():
                results[layer.name] = torch.cat([results[source] for source in layer.sources], 1)


def rgb_input(bgr: Any) -> Any:
    """Return the RGB branch's input (N, 3, H, W) float32 from frames (N, H, W, 3) uint8 BGR."""
    rgb = bgr.permute(0, 3, 1, 2).flip(1).float() / 255
    return (rgb - torch.tensor(RGB_MEAN).view(3, 1, 1)) / torch.tensor(RGB_STD).view(3, 1, 1)


def depth_input(counts: Any) -> Any:
    """Return the depth branch's input (N, 3, H, W) float32 from depth (N, H, W) in counts of 65535 per km."""
    metres = counts.float()[:, None] * (FAR_PLANE_M / 65535)
    channels = [torch.log(torch.clamp(metres, min=1) / REFERENCE_DEPTH_M)]
    near = torch.clamp(metres, max=DEPTH_LIMIT_M)
    for block, unit, limit in CONTRASTS:
        mean = upsample(functional.avg_pool2d(near, block), block)
        channels.append(torch.clamp((near - mean) / unit, -limit, limit))
    return torch.cat(channels, 1)


def upsample(maps: Any, factor: int, phase: tuple[int, int] = (0, 0), step: int = 1) -> Any:
    """Return maps (N, C, H, W) interpolated to (N, C, H·factor/step, W·factor/step).

    With a `step`, only every so-manieth row and column of the full resolution is computed, from
    `phase` on.
    """
    rows = torch.from_numpy(upsampling(maps.shape[2], factor)[phase[0] :: step].copy())
    columns = torch.from_numpy(upsampling(maps.shape[3], factor)[phase[1] :: step].T.copy())
    return rows @ (maps @ columns)


def folded_weights(layers: Sequence[Layer], modules: Any) -> Weights:
    """Return kernels and biases with the normalisation's running statistics folded in, in float64."""
    weights = {}
    for layer in convolutions(tuple(layers)):
        parts = modules[_key(layer.name)]
        kernel = parts[0].weight.detach().double().contiguous().numpy()
        if layer.norm:
            norm = parts[1]
            scale = (norm.weight.detach().double() / (norm.running_var.double() + norm.eps).sqrt()).numpy()
            bias = norm.bias.detach().double().numpy() - norm.running_mean.double().numpy() * scale
            kernel = kernel * scale[:, None, None, None]
        else:
            bias = parts[0].bias.detach().double().numpy()
        weights[layer.name] = (kernel.astype(np.float32), bias.astype(np.float32))
    return weights
