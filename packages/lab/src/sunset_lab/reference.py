"""The architecture `reference`: the paper's DeepLabV3 with a ResNet50 for each sensor, fused late.

A branch is a ResNet50 (He et al., "Deep Residual Learning for Image Recognition", 2015; the stride of a
block in its 3x3 convolution) whose last two stages keep stride 8 by dilation, atrous spatial pyramid
pooling with rates 12, 24 and 36 and global pooling, and a classifier (Chen et al., "Rethinking Atrous
Convolution for Semantic Image Segmentation", 2017). Modules have the names of torchvision's
`deeplabv3_resnet50` without auxiliary classifier; in the fusion, the names of SynDrone's benchmark: `rgb.*`,
`dth.*` and `merge.*`, the last over the logits interpolated to full size.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Final

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError
from sunset_lab.architecture import Concat, Conv, Layer, MaxPool, Pool, Spread, check_widths, merge

_CLASSES: Final = len(CLASSES)
_STRIDES: Final = (8, 16, 32)
_EXPANSION: Final = 4

BRANCH_PREFIXES: Final = {"rgb": "rgb.", "depth": "dth."}
"""The prefixes of the fusion's module names, by branch."""


@dataclass(frozen=True, slots=True)
class ReferenceShape:
    """The widths of a branch of `reference`, in channels, at least 16.

    Attributes:
        width: channels of the stem and of the first stage's inner convolutions; each stage doubles it.
        blocks: residual blocks of each stage.
        pyramid: channels of each branch of the pyramid pooling, and of the classifier.
        rates: dilations of the pyramid's 3x3 convolutions at stride 8.
    """

    name: ClassVar = "deeplabv3_resnet50"
    """The architecture's name."""
    description: ClassVar = (
        "DeepLabV3 with a ResNet50 at output stride 8 and atrous spatial pyramid pooling with rates 12, 24 "
        "and 36: one network for the colour image, one for the depth image, and both with their logits "
        "interpolated to full size, concatenated and merged by 1x1 convolutions."
    )
    """A paragraph for the model's card."""
    stride: ClassVar = 8
    """Pixels of the frame for each logit of a branch, in both directions."""

    width: int = 64
    blocks: tuple[int, int, int, int] = (3, 4, 6, 3)
    pyramid: int = 256
    rates: tuple[int, int, int] = (12, 24, 36)

    def __post_init__(self) -> None:
        check_widths(self.width, self.pyramid)

    def branch(self, modality: str, output_stride: int | None = None) -> tuple[Layer, ...]:
        """Return the layers of a branch of the fusion; the output stride is 8, 16 or 32."""
        return self.network(f"{modality}.", BRANCH_PREFIXES[modality], output_stride)

    def network(self, name: str, modules: str, output_stride: int | None = None) -> tuple[Layer, ...]:
        """Return the layers `<name>input` → `<name>logits`, with `modules` as the prefix of the modules' names.

        >>> [layer.weights for layer in ReferenceShape().network("", "")[:3:2]]
        ['backbone.conv1', 'backbone.layer1.0.downsample.0']
        """
        output_stride = self.stride if output_stride is None else output_stride
        if output_stride not in _STRIDES:
            raise InvalidInputError(f"The output stride must be 8, 16 or 32, got {output_stride}.")
        rates = tuple(rate * self.stride // output_stride for rate in self.rates)
        return (
            *_backbone(modules, f"{name}input", self, output_stride),
            *_head(modules, f"{name}logits", self, rates),
        )

    def merge(self) -> tuple[Layer, ...]:
        """Return the layers of late fusion, at full size."""
        return merge(self.stride)


def _backbone(p: str, source: str, shape: ReferenceShape, output_stride: int) -> Iterator[Layer]:
    b = f"{p}backbone."
    yield Conv(f"{b}conv1", source, (3, shape.width), f"{b}conv1", f"{b}bn1", kernel=7, stride=2)
    yield MaxPool(f"{b}maxpool", f"{b}conv1")
    source, wide = f"{b}maxpool", shape.width
    reached, dilation = 4, 1
    for stage, blocks in enumerate(shape.blocks):
        inner = shape.width << stage
        stride, first = (1 if stage == 0 else 2), dilation
        if stride > 1 and reached == output_stride:
            stride, dilation = 1, 2 * dilation  # the stage's first block still has the dilation before
        reached *= stride
        for index in range(blocks):
            name = f"{b}layer{stage + 1}.{index}"
            start = index == 0
            yield from _block(
                name,
                source,
                (wide, inner),
                stride=stride if start else 1,
                dilation=first if start else dilation,
                shortcut=start,
            )
            source, wide = name, _EXPANSION * inner


def _block(
    name: str, source: str, channels: tuple[int, int], *, stride: int, dilation: int, shortcut: bool
) -> Iterator[Layer]:
    """A bottleneck: convolutions 1x1, 3x3, 1x1 to four times the channels, and a shortcut."""
    wide, inner = channels
    out, added = _EXPANSION * inner, source
    if shortcut:
        added, path = f"{name}.downsample", f"{name}.downsample"
        modules = (f"{path}.0", f"{path}.1")
        yield Conv(added, source, (wide, out), *modules, kernel=1, stride=stride, relu=False)
    one, two, three = (f"{name}.conv{index}" for index in (1, 2, 3))
    yield Conv(one, source, (wide, inner), one, f"{name}.bn1", kernel=1)
    yield Conv(two, one, (inner, inner), two, f"{name}.bn2", stride=stride, dilation=dilation)
    yield Conv(name, two, (inner, out), three, f"{name}.bn3", kernel=1, add=added)


def _head(p: str, result: str, shape: ReferenceShape, rates: tuple[int, ...]) -> Iterator[Layer]:
    source = f"{p}backbone.layer4.{shape.blocks[3] - 1}"
    c, width = f"{p}classifier.", shape.pyramid
    channels = (_EXPANSION * shape.width << 3, width)
    parts = [f"{c}0.convs.{index}" for index in range(5)]
    yield Conv(parts[0], source, channels, f"{parts[0]}.0", f"{parts[0]}.1", kernel=1)
    for part, rate in zip(parts[1:4], rates, strict=True):
        yield Conv(part, source, channels, f"{part}.0", f"{part}.1", dilation=rate)
    yield Pool(f"{c}mean", source)
    yield Conv(f"{c}global", f"{c}mean", channels, f"{parts[4]}.1", f"{parts[4]}.2", kernel=1)
    yield Spread(parts[4], f"{c}global", source)
    yield Concat(f"{c}all", tuple(parts))
    project = (f"{c}0.project.0", f"{c}0.project.1")
    yield Conv(f"{c}0", f"{c}all", (5 * width, width), *project, kernel=1, dropout=0.5)
    yield Conv(f"{c}1", f"{c}0", (width, width), f"{c}1", f"{c}2")
    yield Conv(result, f"{c}1", (width, _CLASSES), f"{c}4", kernel=1, relu=False)
