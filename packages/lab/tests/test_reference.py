"""The reference's weights are torchvision's `deeplabv3_resnet50`'s: names, shapes, geometry."""

from collections.abc import Iterator
from typing import Any

import pytest

from sunset_lab import MODALITIES, TrainingConfig
from sunset_lab.architecture import convolutions
from sunset_lab.shapes import ReferenceShape

pytestmark = pytest.mark.thorough

torch = pytest.importorskip("torch")

from sunset_lab.network import build, forward  # noqa: E402  needs torch

# torchvision publishes 42,004,074 parameters with 21 classes and the auxiliary classifier, which is a 3x3
# convolution 1024 → 256 with normalisation and a 1x1 convolution with bias; each class more takes 256 and 1.
BRANCH = 42_004_074 - (1024 * 256 * 9 + 2 * 256 + 21 * 257) + 7 * 257


def conv(name: str, out: int, into: int, kernel: int) -> Iterator[tuple[str, tuple[int, ...]]]:
    yield f"{name}.weight", (out, into, kernel, kernel)


def norm(name: str, width: int) -> Iterator[tuple[str, tuple[int, ...]]]:
    for part in ("weight", "bias", "running_mean", "running_var"):
        yield f"{name}.{part}", (width,)
    yield f"{name}.num_batches_tracked", ()


def published(prefix: str = "") -> Iterator[tuple[str, tuple[int, ...]]]:
    """Names and shapes of a state dict of torchvision's network, by rule."""
    b, c = f"{prefix}backbone.", f"{prefix}classifier."
    yield from conv(f"{b}conv1", 64, 3, 7)
    yield from norm(f"{b}bn1", 64)
    wide = 64
    for stage, (inner, blocks) in enumerate(((64, 3), (128, 4), (256, 6), (512, 3)), start=1):
        for index in range(blocks):
            name = f"{b}layer{stage}.{index}"
            yield from conv(f"{name}.conv1", inner, wide, 1)
            yield from norm(f"{name}.bn1", inner)
            yield from conv(f"{name}.conv2", inner, inner, 3)
            yield from norm(f"{name}.bn2", inner)
            yield from conv(f"{name}.conv3", 4 * inner, inner, 1)
            yield from norm(f"{name}.bn3", 4 * inner)
            if index == 0:
                yield from conv(f"{name}.downsample.0", 4 * inner, wide, 1)
                yield from norm(f"{name}.downsample.1", 4 * inner)
            wide = 4 * inner
    for index, kernel, at in ((0, 1, 0), (1, 3, 0), (2, 3, 0), (3, 3, 0), (4, 1, 1)):
        yield from conv(f"{c}0.convs.{index}.{at}", 256, 2048, kernel)
        yield from norm(f"{c}0.convs.{index}.{at + 1}", 256)
    yield from conv(f"{c}0.project.0", 256, 1280, 1)
    yield from norm(f"{c}0.project.1", 256)
    yield from conv(f"{c}1", 256, 256, 3)
    yield from norm(f"{c}2", 256)
    yield from conv(f"{c}4", 28, 256, 1)
    yield f"{c}4.bias", (28,)


def shapes(modules: Any) -> dict[str, tuple[int, ...]]:
    return {name: tuple(value.shape) for name, value in modules.state_dict().items()}


def test_a_branch_has_the_published_names_shapes_and_number_of_parameters() -> None:
    with torch.device("meta"):
        modules = build(ReferenceShape().network("rgb.", ""))
    assert shapes(modules) == dict(published())
    assert sum(p.numel() for p in modules.parameters()) == BRANCH == 39_640_668


def test_the_fusion_has_both_branches_and_three_convolutions_56_56_56_28() -> None:
    with torch.device("meta"):
        modules = build(TrainingConfig(shape=ReferenceShape()).plan(MODALITIES))
    merging: dict[str, tuple[int, ...]] = {}
    for name, out in (("merge.0", 56), ("merge.2", 56), ("merge.4", 28)):
        merging |= {f"{name}.weight": (out, 56, 1, 1), f"{name}.bias": (out,)}
    assert shapes(modules) == dict(published("rgb.")) | dict(published("dth.")) | merging
    assert sum(p.numel() for p in modules.parameters()) == 2 * BRANCH + 2 * 56 * 57 + 28 * 57


@pytest.mark.parametrize(
    ("output_stride", "strides", "dilations", "rates"),
    [
        (8, (1, 2, 1, 1), ((1, 1), (1, 1), (1, 2), (2, 4)), (12, 24, 36)),
        (16, (1, 2, 2, 1), ((1, 1), (1, 1), (1, 1), (1, 2)), (6, 12, 18)),
        (32, (1, 2, 2, 2), ((1, 1), (1, 1), (1, 1), (1, 1)), (3, 6, 9)),
    ],
)
def test_stages_keep_their_resolution_by_dilation_as_torchvisions_do(
    output_stride: int,
    strides: tuple[int, ...],
    dilations: tuple[tuple[int, int], ...],
    rates: tuple[int, ...],
) -> None:
    layers = {layer.weights: layer for layer in convolutions(ReferenceShape().network("", "", output_stride))}
    for stage, (stride, (first, rest)) in enumerate(zip(strides, dilations, strict=True), start=1):
        start = layers[f"backbone.layer{stage}.0.conv2"]
        assert (start.stride, start.dilation) == (stride, first)
        assert layers[f"backbone.layer{stage}.0.downsample.0"].stride == stride
        assert layers[f"backbone.layer{stage}.0.conv1"].stride == 1
        following = layers[f"backbone.layer{stage}.1.conv2"]
        assert (following.stride, following.dilation) == (1, rest)
    found = tuple(layers[f"classifier.0.convs.{index}.0"].dilation for index in (1, 2, 3))
    assert found == rates


def test_kernels_without_their_dead_rows_and_columns_give_the_same() -> None:
    torch.manual_seed(0)
    shape = ReferenceShape(16, (1, 1, 1, 1), pyramid=16)
    layers = shape.network("", "")
    modules = build(layers).eval()
    results = {"input": torch.randn(1, 3, 144, 256)}
    with torch.no_grad():
        forward(layers, modules, results)
        source, rate24 = results["backbone.layer4.0"], modules.get_submodule("classifier.0.convs.2.0")
        plain = torch.nn.functional.conv2d(source, rate24.weight, padding=24, dilation=24)
        normalised = modules.get_submodule("classifier.0.convs.2.1")(plain).relu()
    assert source.shape[2:] == (18, 32)
    assert torch.allclose(results["classifier.0.convs.2"], normalised, atol=1e-5)
    assert results["logits"].shape == (1, 28, 18, 32)
