"""The networks as plain data: one plan, run by torch in training and written as ONNX for inference.

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
from typing import Final, TypeAlias

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError

__all__ = [
    "Concat",
    "Conv",
    "Layer",
    "NetworkShape",
    "Pool",
    "Resize",
    "Shuffle",
    "branch",
    "convolutions",
    "merge",
]

_CLASSES: Final = len(CLASSES)
_LEAST_WIDTH: Final = 16


@dataclass(frozen=True, slots=True)
class Conv:
    """A convolution, then normalisation, then an addition, then ReLU; the last three if asked for.

    Attributes:
        name: names the result.
        source: the result that is convolved.
        channels: channels in, channels out.
        kernel: 1 or 3, padded with zeros to keep the size.
        norm: batch normalisation instead of a bias.
        add: a result that is added, of the same shape or of one pixel.
    """

    name: str
    source: str
    channels: tuple[int, int]
    kernel: int = 3
    stride: int = 1
    dilation: int = 1
    norm: bool = True
    add: str = ""
    relu: bool = True


@dataclass(frozen=True, slots=True)
class Pool:
    """The mean over all pixels, one pixel large."""

    name: str
    source: str


@dataclass(frozen=True, slots=True)
class Resize:
    """Bilinear interpolation by a whole factor."""

    name: str
    source: str
    factor: int


@dataclass(frozen=True, slots=True)
class Concat:
    """Channels of several results, one behind the other."""

    name: str
    sources: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Shuffle:
    """Every 2x2 channels become 2x2 pixels of one channel."""

    name: str
    source: str


Layer: TypeAlias = Conv | Pool | Resize | Concat | Shuffle


@dataclass(frozen=True, slots=True)
class NetworkShape:
    """The widths of a branch, in channels; none may be less than 16.

    Below that, torch 2.13's convolutions for CPUs were seen to write beyond their memory (1x1 kernels, stride 2).

    Attributes:
        stem: channels at stride 2.
        widths: channels at strides 4, 8 and 16.
        blocks: residual blocks at strides 4, 8 and 16.
        pyramid: channels of each branch of the pyramid pooling.
        rates: dilations of the pyramid's 3x3 convolutions.
        skips: channels taken from strides 4 and 8 into the decoder.
        decoder: channels of the decoder.
    """

    stem: int = 24
    widths: tuple[int, int, int] = (48, 96, 160)
    blocks: tuple[int, int, int] = (1, 2, 2)
    pyramid: int = 64
    rates: tuple[int, ...] = (2, 4, 6)
    skips: tuple[int, int] = (24, 32)
    decoder: int = 48

    def __post_init__(self) -> None:
        """Refuse widths that cannot be trained."""
        least = min(self.stem, *self.widths, self.pyramid, *self.skips, self.decoder)
        if least < _LEAST_WIDTH:
            raise InvalidInputError(
                f"A network must have at least {_LEAST_WIDTH} channels everywhere, got {least}."
            )


def _block(name: str, source: str, channels: tuple[int, int], stride: int) -> Iterator[Layer]:
    """A basic residual block: two 3x3 convolutions and a shortcut."""
    shortcut = source
    if stride != 1 or channels[0] != channels[1]:
        shortcut = f"{name}.shortcut"
        yield Conv(shortcut, source, channels, kernel=1, stride=stride, relu=False)
    yield Conv(f"{name}.in", source, channels, stride=stride)
    yield Conv(name, f"{name}.in", (channels[1], channels[1]), add=shortcut)


def _backbone(p: str, shape: NetworkShape) -> Iterator[Layer]:
    yield Conv(f"{p}stem", f"{p}input", (3, shape.stem), stride=2)
    source, width = f"{p}stem", shape.stem
    for stride, out, blocks in zip((4, 8, 16), shape.widths, shape.blocks, strict=True):
        for index in range(blocks):
            name = f"{p}stride{stride}" + ("" if index == blocks - 1 else f".block{index}")
            yield from _block(name, source, (width, out), 2 if index == 0 else 1)
            source, width = name, out


def _pyramid(p: str, shape: NetworkShape) -> Iterator[Layer]:
    source, channels = f"{p}stride16", (shape.widths[2], shape.pyramid)
    yield Conv(f"{p}aspp.rate0", source, channels, kernel=1)
    for rate in shape.rates:
        yield Conv(f"{p}aspp.rate{rate}", source, channels, dilation=rate)
    rates = (0, *shape.rates)
    yield Concat(f"{p}aspp.all", tuple(f"{p}aspp.rate{rate}" for rate in rates))
    yield Pool(f"{p}aspp.mean", source)
    yield Conv(f"{p}aspp.global", f"{p}aspp.mean", channels, kernel=1, norm=False)
    # The projection of concatenated maps is a sum of projections: the constant map is added, not tiled.
    last = (shape.pyramid, shape.pyramid)
    yield Conv(f"{p}aspp.context", f"{p}aspp.global", last, kernel=1, norm=False, relu=False)
    wide = (shape.pyramid * len(rates), shape.pyramid)
    yield Conv(f"{p}aspp", f"{p}aspp.all", wide, kernel=1, add=f"{p}aspp.context")


def _decoder(p: str, shape: NetworkShape) -> Iterator[Layer]:
    source, width = f"{p}aspp", shape.pyramid
    levels = (
        (8, shape.widths[1], shape.skips[1], shape.pyramid),
        (4, shape.widths[0], shape.skips[0], shape.decoder),
    )
    for stride, channels, skip, out in levels:
        yield Resize(f"{p}up{stride}", source, 2)
        yield Conv(f"{p}skip{stride}", f"{p}stride{stride}", (channels, skip), kernel=1)
        yield Concat(f"{p}both{stride}", (f"{p}up{stride}", f"{p}skip{stride}"))
        source, width = f"{p}decoder{stride}", width + skip
        yield Conv(source, f"{p}both{stride}", (width, out))
        width = out
    yield Conv(f"{p}classifier", source, (width, 4 * _CLASSES), kernel=1, norm=False, relu=False)
    yield Shuffle(f"{p}logits", f"{p}classifier")


def branch(name: str, shape: NetworkShape) -> tuple[Layer, ...]:
    """Return the layers of one branch: `<name>.input` (3 channels) → `<name>.logits` at stride 2.

    >>> layers = branch("rgb", NetworkShape())
    >>> layers[0].name, layers[-1].name
    ('rgb.stem', 'rgb.logits')
    """
    p = f"{name}."
    return (*_backbone(p, shape), *_pyramid(p, shape), *_decoder(p, shape))


def merge(sources: tuple[str, ...]) -> tuple[Layer, ...]:
    """Return the layers of late fusion: 1x1 convolutions 56 → 56 → 56 → 28 over all branches' logits."""
    wide = _CLASSES * len(sources)
    return (
        Concat("fusion.all", tuple(f"{source}.logits" for source in sources)),
        Conv("fusion.first", "fusion.all", (wide, wide), kernel=1, norm=False),
        Conv("fusion.second", "fusion.first", (wide, wide), kernel=1, norm=False),
        Conv("fusion.logits", "fusion.second", (wide, _CLASSES), kernel=1, norm=False, relu=False),
    )


def convolutions(layers: tuple[Layer, ...]) -> Iterator[Conv]:
    """Yield the layers that have weights."""
    for layer in layers:
        if isinstance(layer, Conv):
            yield layer
