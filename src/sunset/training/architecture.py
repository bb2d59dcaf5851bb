"""Networks as plain data: a plan of layers, run by torch in training and written as ONNX for inference.

A plan names every layer's result, and for layers with weights the torch modules that hold them. The same
weights can be run by several plans: with strides instead of dilations, say, where a training begins.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, TypeAlias

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError

__all__ = [
    "LEAST_WIDTH",
    "Concat",
    "Conv",
    "Layer",
    "MaxPool",
    "Pool",
    "Resize",
    "Shuffle",
    "Spread",
    "check_widths",
    "convolutions",
    "merge",
]

_CLASSES: Final = len(CLASSES)
LEAST_WIDTH: Final = 16
"""Below this many channels, torch 2.13's convolutions for CPUs were seen to write beyond their memory
(1x1 kernels, stride 2)."""


@dataclass(frozen=True, slots=True)
class Conv:
    """A convolution, then normalisation, an addition, ReLU, and in training dropout; the last four if asked for.

    Attributes:
        name: names the result.
        source: the result that is convolved.
        channels: channels in, channels out.
        weights: the module of the kernel, and of the bias if there is no normalisation.
        norm: the module of the batch normalisation, or none.
        kernel: odd; the source is padded with zeros to keep its size.
        add: a result that is added, of the same shape or of one pixel.
        dropout: the share of values that training sets to 0.
    """

    name: str
    source: str
    channels: tuple[int, int]
    weights: str
    norm: str = ""
    kernel: int = 3
    stride: int = 1
    dilation: int = 1
    add: str = ""
    relu: bool = True
    dropout: float = 0.0

    @property
    def padding(self) -> int:
        """Rows and columns of zeros on each side."""
        return self.dilation * (self.kernel // 2)


@dataclass(frozen=True, slots=True)
class MaxPool:
    """The greatest of 3x3 pixels around every second one."""

    name: str
    source: str


@dataclass(frozen=True, slots=True)
class Pool:
    """The mean over all pixels, one pixel large."""

    name: str
    source: str


@dataclass(frozen=True, slots=True)
class Spread:
    """One pixel, repeated to the size of another result."""

    name: str
    source: str
    like: str


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


Layer: TypeAlias = Conv | MaxPool | Pool | Spread | Resize | Concat | Shuffle


def check_widths(*widths: int) -> None:
    """Refuse widths that cannot be trained.

    Raises:
        InvalidInputError: one is less than `LEAST_WIDTH`.
    """
    if min(widths) < LEAST_WIDTH:
        raise InvalidInputError(
            f"A network must have at least {LEAST_WIDTH} channels everywhere, got {min(widths)}."
        )


def merge(rgb: str, depth: str) -> tuple[Layer, ...]:
    """Return the layers of late fusion: 1x1 convolutions 56 → 56 → 56 → 28 over two branches' logits."""
    wide = 2 * _CLASSES
    return (
        Concat("fusion.both", (rgb, depth)),
        Conv("fusion.first", "fusion.both", (wide, wide), weights="merge.0", kernel=1),
        Conv("fusion.second", "fusion.first", (wide, wide), weights="merge.2", kernel=1),
        Conv("fusion.logits", "fusion.second", (wide, _CLASSES), weights="merge.4", kernel=1, relu=False),
    )


def convolutions(layers: tuple[Layer, ...]) -> Iterator[Conv]:
    """Yield the layers that have weights."""
    for layer in layers:
        if isinstance(layer, Conv):
            yield layer
