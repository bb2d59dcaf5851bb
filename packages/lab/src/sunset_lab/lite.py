"""The architecture `lite`: a DeepLabV3 that segments a frame in milliseconds on a single core.

Every branch is a DeepLabV3: a light residual backbone down to stride 16, atrous spatial pyramid
pooling with a global-pooling branch (Chen et al., "Rethinking Atrous Convolution for Semantic Image
Segmentation", 2017), and a classifier. Cars are ten pixels long from 50 m, so the pyramid's output is
refined by the backbone's features at strides 8 and 4 before the classifier, as DeepLabV3+ does (Chen et
al., 2018), and the classifier gives each of its pixels four sets of logits, for stride 2 (Shi et al.,
"Real-Time Single Image and Video Super-Resolution Using an Efficient Sub-Pixel Convolutional Neural
Network", 2016). Late fusion concatenates the logits of both branches and merges them by three 1x1
convolutions.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Final

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError
from sunset_lab.architecture import Concat, Conv, Layer, Pool, Resize, Shuffle, check_widths, merge

_CLASSES: Final = len(CLASSES)


@dataclass(frozen=True, slots=True)
class LiteShape:
    """The widths of a branch of `lite`, in channels, at least 16.

    Attributes:
        stem: channels at stride 2.
        widths: channels at strides 4, 8 and 16.
        blocks: residual blocks at strides 4, 8 and 16.
        pyramid: channels of each branch of the pyramid pooling.
        rates: dilations of the pyramid's 3x3 convolutions.
        skips: channels taken from strides 4 and 8 into the decoder.
        decoder: channels of the decoder.
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

    stem: int = 24
    widths: tuple[int, int, int] = (48, 96, 160)
    blocks: tuple[int, int, int] = (1, 2, 2)
    pyramid: int = 64
    rates: tuple[int, ...] = (2, 4, 6)
    skips: tuple[int, int] = (24, 32)
    decoder: int = 48

    def __post_init__(self) -> None:
        check_widths(self.stem, *self.widths, self.pyramid, *self.skips, self.decoder)

    def branch(self, modality: str, output_stride: int | None = None) -> tuple[Layer, ...]:
        """Return the layers of a branch: `<modality>.input` (3 channels) → `<modality>.logits` at stride 2.

        >>> layers = LiteShape().branch("rgb")
        >>> layers[0].name, layers[-1].name
        ('rgb.stem', 'rgb.logits')
        """
        if output_stride not in {None, self.stride}:
            raise InvalidInputError(f"The output stride of 'lite' is {self.stride}, got {output_stride}.")
        p = f"{modality}."
        return (*_backbone(p, self), *_pyramid(p, self), *_decoder(p, self))

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


def _block(name: str, source: str, channels: tuple[int, int], stride: int) -> Iterator[Layer]:
    """A basic residual block: two 3x3 convolutions and a shortcut."""
    shortcut = source
    if stride != 1 or channels[0] != channels[1]:
        shortcut = f"{name}.shortcut"
        yield _conv(shortcut, source, channels, kernel=1, stride=stride, relu=False)
    yield _conv(f"{name}.in", source, channels, stride=stride)
    yield _conv(name, f"{name}.in", (channels[1], channels[1]), add=shortcut)


def _backbone(p: str, shape: LiteShape) -> Iterator[Layer]:
    yield _conv(f"{p}stem", f"{p}input", (3, shape.stem), stride=2)
    source, width = f"{p}stem", shape.stem
    for stride, out, blocks in zip((4, 8, 16), shape.widths, shape.blocks, strict=True):
        for index in range(blocks):
            name = f"{p}stride{stride}" + ("" if index == blocks - 1 else f".block{index}")
            yield from _block(name, source, (width, out), 2 if index == 0 else 1)
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
