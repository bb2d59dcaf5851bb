"""The networks in torch: plans of `architecture` are run, and their weights returned as arrays."""

import hashlib
import math
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, reduce
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn
from torch.nn import functional

from sunset.classes import CLASSES
from sunset_lab.architecture import (
    CONTRASTS,
    DEPTH_LIMIT_M,
    FAR_PLANE_M,
    REFERENCE_DEPTH_M,
    RGB_MEAN,
    RGB_STD,
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
from sunset_lab.frames import FrameSet

_Array: TypeAlias = npt.NDArray[np.float32]

_OUTLIERS: Final = 1e-4
"""The share of a frame's sampled values that may lie outside the range of 8 bits on either side."""


def build(layers: Sequence[Layer]) -> nn.Module:
    """Return a torch module with random weights for a plan, by the plan's names; `forward` runs the plan.

    The weights are drawn from torch's global generator.
    """
    root = nn.Module()
    for layer in convolutions(layers):
        conv = nn.Conv2d(*layer.channels, layer.kernel, bias=not layer.norm)
        if layer.norm or layer.relu:
            nn.init.kaiming_normal_(conv.weight, mode="fan_out", nonlinearity="relu")
        else:
            nn.init.normal_(conv.weight, std=0.01)  # logits begin near zero
        _place(root, layer.weights, conv)
        if layer.norm:
            norm = nn.BatchNorm2d(layer.channels[1])
            if layer.add:
                nn.init.constant_(norm.weight, 0.5)  # a block begins near its shortcut
            _place(root, layer.norm, norm)
    return root.to(memory_format=torch.channels_last)


def _place(root: nn.Module, path: str, module: nn.Module) -> None:
    *parents, name = path.split(".")
    for parent in parents:
        if parent not in dict(root.named_children()):
            root.add_module(parent, nn.Module())
        root = root.get_submodule(parent)
    root.add_module(name, module)


def forward(layers: Sequence[Layer], modules: nn.Module, results: dict[str, Tensor]) -> None:
    """Run a plan; `results` holds the inputs by name and receives every layer's result (N, C, H, W).

    Where a convolution has an addition, `<name>.conv` receives the result before it. The mode of `modules` controls
    normalisation and dropout.
    """
    for layer in layers:
        match layer:
            case Conv():
                results[layer.name] = _convolve(layer, modules, results)
            case MaxPool():
                results[layer.name] = functional.max_pool2d(results[layer.source], 3, 2, 1)
            case Pool():
                results[layer.name] = results[layer.source].mean((2, 3), keepdim=True)
            case Spread():
                results[layer.name] = results[layer.source].expand(-1, -1, *results[layer.like].shape[2:])
            case Resize():
                y = functional.interpolate(results[layer.source], scale_factor=layer.factor, mode="bilinear")
                results[layer.name] = functional.relu(y) if layer.relu else y
            case Shuffle():
                results[layer.name] = functional.pixel_shuffle(results[layer.source], 2)
            case Concat():
                results[layer.name] = torch.cat([results[source] for source in layer.sources], 1)


def _convolve(layer: Conv, modules: nn.Module, results: dict[str, Tensor]) -> Tensor:
    conv, source = _module(modules, layer.weights), results[layer.source]
    height, width = source.shape[2:]
    kernel = conv.weight[:, :, layer.taps(height), layer.taps(width)]
    padding = (layer.padding(height), layer.padding(width))
    y = functional.conv2d(source, kernel, conv.bias, layer.stride, padding, layer.dilation)
    if layer.norm:
        y = _module(modules, layer.norm)(y)
    if layer.add:
        results[f"{layer.name}.conv"] = y
        y = y + results[layer.add]
    if layer.relu:
        y = functional.relu(y)
    return functional.dropout(y, layer.dropout, modules.training) if layer.dropout else y


def _module(modules: nn.Module, path: str) -> nn.Module:
    """Return a module by its path; `get_submodule` cannot be compiled with a module called `global`."""
    return reduce(getattr, path.split("."), modules)


def rgb_input(bgr: Tensor) -> Tensor:
    """Return the RGB branch's input (N, 3, H, W) float32 from frames (N, H, W, 3) uint8 BGR."""
    rgb = bgr.permute(0, 3, 1, 2).flip(1).float() / 255
    return (rgb - _by_channel(RGB_MEAN, rgb.device)) / _by_channel(RGB_STD, rgb.device)


@lru_cache
def _by_channel(values: tuple[float, ...], device: torch.device) -> Tensor:
    """Return numbers as (C, 1, 1) on a device, sent to it once."""
    return torch.tensor(values, device=device).view(-1, 1, 1)


def depth_input(counts: Tensor) -> Tensor:
    """Return the depth branch's input (N, 3, H, W) float32 from depth (N, H, W) in counts of 65535 per km."""
    metres = counts.float()[:, None] * (FAR_PLANE_M / 65535)
    channels = [torch.log(torch.clamp(metres, min=1) / REFERENCE_DEPTH_M)]
    near = torch.clamp(metres, max=DEPTH_LIMIT_M)
    for block, unit, limit in CONTRASTS:
        mean = upsample(functional.avg_pool2d(near, block), block)
        channels.append(torch.clamp((near - mean) / unit, -limit, limit))
    return torch.cat(channels, 1)


def frame_inputs(bgr: npt.NDArray[np.uint8], depth: npt.NDArray[np.uint16]) -> dict[str, Tensor]:
    """Return both branches' inputs, `rgb.input` and `depth.input`, of frames (N, H, W, 3) and (N, H, W)."""
    return {
        "rgb.input": rgb_input(torch.from_numpy(np.array(bgr))),
        "depth.input": depth_input(torch.from_numpy(depth.astype(np.float32))),
    }


def upsample(
    maps: Tensor,
    factor: int,
    phase: tuple[int, int] = (0, 0),
    step: int = 1,
    size: tuple[int, int] | None = None,
) -> Tensor:
    """Return maps (N, C, H, W) interpolated to (N, C, H·factor/step, W·factor/step).

    With a `step` of n, only every n-th row and column of the full resolution is computed, from `phase` on. With a
    `size`, the result at full resolution is cropped to it.
    """
    height, width = size or (maps.shape[2] * factor, maps.shape[3] * factor)
    rows = _interpolation(maps.shape[2], factor, range(phase[0], height, step), maps.device)
    columns = _interpolation(maps.shape[3], factor, range(phase[1], width, step), maps.device, across=True)
    return rows @ (maps @ columns)


@lru_cache(maxsize=64)
def _interpolation(
    size: int, factor: int, wanted: range, device: torch.device, *, across: bool = False
) -> Tensor:
    """Return rows of the interpolation matrix on a device, sent to it once; as columns if `across`."""
    matrix = upsampling(size, factor)[wanted]
    return torch.from_numpy((matrix.T if across else matrix).copy()).to(device)


def folded_weights(layers: Sequence[Layer], modules: nn.Module) -> dict[str, tuple[_Array, _Array]]:
    """Return each convolution's kernel (out, in, k, k) and bias (out,), with the normalisation folded in."""
    weights = {}
    for layer in convolutions(layers):
        conv = modules.get_submodule(layer.weights)
        kernel = conv.weight.detach().double().contiguous().numpy()
        if layer.norm:
            norm = modules.get_submodule(layer.norm)
            scale = (norm.weight.detach().double() / (norm.running_var.double() + norm.eps).sqrt()).numpy()
            bias = norm.bias.detach().double().numpy() - norm.running_mean.double().numpy() * scale
            kernel = kernel * scale[:, None, None, None]
        else:
            bias = conv.bias.detach().double().numpy()
        weights[layer.name] = (kernel.astype(np.float32), bias.astype(np.float32))
    return weights


def unfold(
    layers: Sequence[Layer],
    modules: nn.Module,
    weights: Mapping[str, tuple[_Array, _Array]],
    results: dict[str, Tensor],
) -> None:
    """Write weights from `folded_weights` into modules for further training.

    The plan's results do not change. Normalisation gets the statistics of the results on some frames, and kernels the
    norm that `build` gives them, which the step size of Adam assumes.

    The modules are in evaluation mode. `results` holds the plan's inputs on the frames, and receives every layer's
    result.
    """
    with torch.no_grad():
        for layer in layers:
            if isinstance(layer, Conv):
                conv = modules.get_submodule(layer.weights)
                kernel, bias = (torch.from_numpy(array) for array in weights[layer.name])
                conv.weight.copy_(kernel)
                if layer.norm:
                    _normalise(layer, modules, bias, results)
                else:
                    conv.bias.copy_(bias)
            forward([layer], modules, results)


def _normalise(layer: Conv, modules: nn.Module, bias: Tensor, results: Mapping[str, Tensor]) -> None:
    """Scale a kernel, and set its normalisation so that the results on some frames stay the same."""
    kernel, norm = modules.get_submodule(layer.weights).weight, modules.get_submodule(layer.norm)
    plain = {layer.source: results[layer.source]}
    forward([replace(layer, norm="", add="", relu=False)], modules, plain)
    variance, mean = torch.var_mean(plain[layer.name], (0, 2, 3), correction=0)
    inputs, outputs = layer.channels
    size = kernel.flatten(1).norm(dim=1)
    scale = torch.where(size > 0, math.sqrt(2 * inputs / outputs) / size, 1.0)
    kernel.mul_(scale[:, None, None, None])
    norm.running_mean.copy_(mean * scale)
    norm.running_var.copy_(variance * scale**2)
    norm.weight.copy_((norm.running_var + norm.eps).sqrt() / scale)
    norm.bias.copy_(bias + mean)


def shift_logits(
    networks: Mapping[str, Sequence[Layer]], modules: nn.Module, shift: npt.NDArray[np.float32]
) -> None:
    """Add `shift` (28,) to the logits of every class, in the biases of networks.

    `networks` are the plans of branches, and of the merging layers as "fusion", whose logits are also shifted once: its
    first layer subtracts the shift of the branches.
    """
    added = torch.from_numpy(shift)
    with torch.no_grad():
        for name, layers in networks.items():
            first, *_, last = (modules.get_submodule(layer.weights) for layer in convolutions(layers))
            if name == "fusion":
                first.bias -= (first.weight[:, :, 0, 0] * added.repeat(2)).sum(1)
            pixels = len(last.bias) // len(added)  # of each logit of the last layer
            last.bias += added.repeat_interleave(pixels)


def start_from_the_sum(modules: nn.Module) -> None:
    """Initialise the merging layers as about the sum of both branches' logits, a simple fusion.

    The logits are raised for the layers with a ReLU, and lowered again by the last layer.
    """
    raised, weight = 10.0, 0.6
    layers = [modules.get_submodule(f"merge.{index}") for index in (0, 2, 4)]
    both = torch.eye(2 * len(CLASSES))
    means = [both, both, weight * (both[: len(CLASSES)] + both[len(CLASSES) :])]
    with torch.no_grad():
        for layer, mean, bias in zip(layers, means, (raised, 0.0, -2 * weight * raised), strict=True):
            layer.weight.normal_(std=0.002).add_(mean[:, :, None, None].to(layer.weight.device))
            layer.bias.fill_(bias)


def ranges(layers: Sequence[Layer], modules: nn.Module, frames: FrameSet) -> dict[str, tuple[float, float]]:
    """Return the ranges of the results that are stored in 8 bits, sampled on at most 32 frames.

    A branch's input and first convolution, its logits and the late fusion stay in float. `layers` is the plan of all
    branches, and `modules` are in evaluation mode.
    """
    names = sorted(_rounded(layers))
    few, limits = frames.spread_out(32), []
    for index in range(len(few)):
        results = frame_inputs(few.bgr[index : index + 1], few.depth[index : index + 1])
        with torch.no_grad():
            forward(layers, modules, results)
        values = (results[name].numpy().ravel() for name in names)
        limits.append([np.quantile(v[:: 1 + v.size // 50_000], (_OUTLIERS, 1 - _OUTLIERS)) for v in values])
    lowest, highest = np.min(limits, axis=0)[:, 0], np.max(limits, axis=0)[:, 1]
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


def digest_of_weights(weights: Mapping[str, Tensor]) -> str:
    """Return a short checksum of tensors."""
    digest = hashlib.sha256()
    for name, value in weights.items():
        digest.update(name.encode() + value.contiguous().numpy().tobytes())
    return digest.hexdigest()[:12]


def check_archive(path: Path, damaged: Exception) -> None:
    """Raise `damaged` unless a zip archive's entries match their checksums, which torch does not check."""
    try:
        with zipfile.ZipFile(path) as archive:
            entry = archive.testzip()
    except (EOFError, RuntimeError, ValueError, zipfile.BadZipFile, zlib.error) as error:
        raise damaged from error
    if entry is not None:
        raise damaged
