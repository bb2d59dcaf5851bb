"""The architectures of networks, as plans of layers.

Their widths are at least 16 channels everywhere: with fewer, torch 2.13's convolutions on CPUs (1x1 kernels, stride 2)
wrote beyond their memory.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Final

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError
from sunset_lab.architecture import Concat, Conv, Layer, MaxPool, Pool, Resize, Shuffle, Spread, merge

_CLASSES: Final = len(CLASSES)
_STRIDES: Final = (8, 16, 32)
_EXPANSION: Final = 4


@dataclass(frozen=True, slots=True)
class LiteShape:
    """A DeepLabV3 that segments a frame in milliseconds on a single core.

    Every branch is a DeepLabV3: a light residual backbone down to stride 16, atrous spatial pyramid pooling with a
    global-pooling branch (Chen et al., "Rethinking Atrous Convolution for Semantic Image Segmentation", 2017), and a
    classifier. Cars are ten pixels long from 50 m, so the pyramid's output is refined by the backbone's features at
    strides 8 and 4 before the classifier, as DeepLabV3+ does (Chen et al., 2018), and the classifier gives each of its
    pixels four sets of logits, for stride 2 (Shi et al., "Real-Time Single Image and Video Super-Resolution Using an
    Efficient Sub-Pixel Convolutional Neural Network", 2016). Late fusion concatenates the logits of both branches and
    merges them by three 1x1 convolutions.
    """

    name: ClassVar = "lite"
    """The architecture's name."""
    description: ClassVar = (
        "DeepLabV3 (atrous spatial pyramid pooling with global pooling) on a light residual backbone, with "
        "skips from strides 8 and 4 and a sub-pixel classifier at stride 2. One network for the colour image, "
        "one for the depth image, and both with their logits concatenated and merged by 1x1 convolutions."
    )
    """A paragraph for the model's card."""
    stride: ClassVar = 2
    """Pixels of the frame for each logit, in both directions."""

    stem: int = 24  # channels at stride 2
    widths: tuple[int, int, int] = (48, 96, 160)  # channels at strides 4, 8 and 16
    blocks: tuple[int, int, int] = (1, 2, 2)  # residual blocks at strides 4, 8 and 16
    pyramid: int = 64  # channels of each branch of the pyramid pooling
    rates: tuple[int, ...] = (2, 4, 6)  # dilations of the pyramid's 3x3 convolutions
    skips: tuple[int, int] = (24, 32)  # channels taken from strides 4 and 8 into the decoder
    decoder: int = 48  # channels of the decoder

    def branch(self, modality: str, output_stride: int | None = None) -> tuple[Layer, ...]:
        """Return the layers of a branch: `<modality>.input` (3 channels) → `<modality>.logits` at stride 2.

        >>> layers = LiteShape().branch("rgb")
        >>> layers[0].name, layers[-1].name
        ('rgb.stem', 'rgb.logits')
        """
        if output_stride not in {None, self.stride}:
            raise InvalidInputError(f"The output stride of 'lite' is {self.stride}, got {output_stride}.")
        p = f"{modality}."
        return (*_lite_backbone(p, self), *_pyramid(p, self), *_decoder(p, self))

    def merge(self) -> tuple[Layer, ...]:
        """Return the layers of late fusion, at stride 2."""
        return merge(1)


def _conv(
    name: str,
    source: str,
    channels: tuple[int, int],
    *,
    kernel: int = 3,
    stride: int = 1,
    dilation: int = 1,
    norm: bool = True,
    add: str = "",
    relu: bool = True,
) -> Conv:
    """A convolution whose modules are named after its result."""
    norms = f"{name}.norm" if norm else ""
    return Conv(name, source, channels, f"{name}.conv", norms, kernel, stride, dilation, add, relu)


def _lite_block(name: str, source: str, channels: tuple[int, int], stride: int) -> Iterator[Layer]:
    """A basic residual block: two 3x3 convolutions and a shortcut."""
    shortcut = source
    if stride != 1 or channels[0] != channels[1]:
        shortcut = f"{name}.shortcut"
        yield _conv(shortcut, source, channels, kernel=1, stride=stride, relu=False)
    yield _conv(f"{name}.in", source, channels, stride=stride)
    yield _conv(name, f"{name}.in", (channels[1], channels[1]), add=shortcut)


def _lite_backbone(p: str, shape: LiteShape) -> Iterator[Layer]:
    yield _conv(f"{p}stem", f"{p}input", (3, shape.stem), stride=2)
    source, width = f"{p}stem", shape.stem
    for stride, out, blocks in zip((4, 8, 16), shape.widths, shape.blocks, strict=True):
        for index in range(blocks):
            name = f"{p}stride{stride}" + ("" if index == blocks - 1 else f".block{index}")
            yield from _lite_block(name, source, (width, out), 2 if index == 0 else 1)
            source, width = name, out


def _pyramid(p: str, shape: LiteShape) -> Iterator[Layer]:
    source, channels = f"{p}stride16", (shape.widths[2], shape.pyramid)
    yield _conv(f"{p}aspp.rate0", source, channels, kernel=1)
    for rate in shape.rates:
        yield _conv(f"{p}aspp.rate{rate}", source, channels, dilation=rate)
    rates = (0, *shape.rates)
    yield Concat(f"{p}aspp.all", tuple(f"{p}aspp.rate{rate}" for rate in rates))
    yield Pool(f"{p}aspp.mean", source)
    yield _conv(f"{p}aspp.global", f"{p}aspp.mean", channels, kernel=1, norm=False)
    # The projection of concatenated maps is a sum of projections: the constant map is added, not tiled.
    last = (shape.pyramid, shape.pyramid)
    yield _conv(f"{p}aspp.context", f"{p}aspp.global", last, kernel=1, norm=False, relu=False)
    wide = (shape.pyramid * len(rates), shape.pyramid)
    yield _conv(f"{p}aspp", f"{p}aspp.all", wide, kernel=1, add=f"{p}aspp.context")


def _decoder(p: str, shape: LiteShape) -> Iterator[Layer]:
    source, width = f"{p}aspp", shape.pyramid
    levels = (
        (8, shape.widths[1], shape.skips[1], shape.pyramid),
        (4, shape.widths[0], shape.skips[0], shape.decoder),
    )
    for stride, channels, skip, out in levels:
        yield Resize(f"{p}up{stride}", source, 2)
        yield _conv(f"{p}skip{stride}", f"{p}stride{stride}", (channels, skip), kernel=1)
        yield Concat(f"{p}both{stride}", (f"{p}up{stride}", f"{p}skip{stride}"))
        source, width = f"{p}decoder{stride}", width + skip
        yield _conv(source, f"{p}both{stride}", (width, out))
        width = out
    yield _conv(f"{p}classifier", source, (width, 4 * _CLASSES), kernel=1, norm=False, relu=False)
    yield Shuffle(f"{p}logits", f"{p}classifier")


@dataclass(frozen=True, slots=True)
class ReferenceShape:
    """The paper's DeepLabV3 with a ResNet50 for each sensor, fused late.

    A branch is a ResNet50 (He et al., "Deep Residual Learning for Image Recognition", 2015; the stride of a block in
    its 3x3 convolution) whose last two stages keep stride 8 by dilation, atrous spatial pyramid pooling with rates 12,
    24 and 36 and global pooling, and a classifier (Chen et al., 2017). Modules have the names of torchvision's
    `deeplabv3_resnet50` without auxiliary classifier; in the fusion, the names of SynDrone's benchmark: `rgb.*`,
    `dth.*` and `merge.*`, the last over the logits interpolated to full size.
    """

    name: ClassVar = "deeplabv3_resnet50"
    description: ClassVar = (
        "DeepLabV3 with a ResNet50 at output stride 8 and atrous spatial pyramid pooling with rates 12, 24 "
        "and 36: one network for the colour image, one for the depth image, and both with their logits "
        "interpolated to full size, concatenated and merged by 1x1 convolutions."
    )
    stride: ClassVar = 8
    """Pixels of the frame for each logit of a branch, in both directions."""

    width: int = 64  # channels of the stem and of the first stage's inner convolutions; each stage doubles it
    blocks: tuple[int, int, int, int] = (3, 4, 6, 3)  # residual blocks of each stage
    pyramid: int = 256  # channels of each branch of the pyramid pooling, and of the classifier
    rates: tuple[int, int, int] = (12, 24, 36)  # dilations of the pyramid's 3x3 convolutions at stride 8

    def branch(self, modality: str, output_stride: int | None = None) -> tuple[Layer, ...]:
        """Return the layers of a branch of the fusion; the output stride is 8, 16 or 32."""
        return self.network(f"{modality}.", {"rgb": "rgb.", "depth": "dth."}[modality], output_stride)

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
