"""Networks as plain data: a plan of layers, run by torch in training and written as ONNX for inference.

A plan names every layer's result, and for layers with weights the torch modules that hold them. The same
weights can be run by several plans: with strides instead of dilations, say, where a training begins.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, TypeAlias

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError

_CLASSES: Final = len(CLASSES)
LEAST_WIDTH: Final = 16
"""Below this many channels, torch 2.13's convolutions for CPUs were seen to write beyond their memory
(1x1 kernels, stride 2)."""


@dataclass(frozen=True, slots=True)
class Region:
    """Rows of a source, and those of a kernel that see them, without any padding; or columns."""

    source: slice
    taps: slice


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

    def taps(self, size: int) -> slice:
        """Return which rows of the kernel see more than padding in a source of so many rows; or columns.

        >>> Conv("y", "x", (8, 8), "w", dilation=24).taps(18)
        slice(1, 2, None)
        """
        centre = self.kernel // 2
        reach = min(centre, (size - 1) // self.dilation)
        return slice(centre - reach, centre + reach + 1)

    def padding(self, size: int) -> int:
        """Return how many rows of zeros those rows of the kernel need on each side; or columns."""
        return self.dilation * (self.kernel // 2 - int(self.taps(size).start))

    def regions(self, size: int) -> tuple[Region, ...]:
        """Return the regions of so many rows of a result, or columns, each of which sees its own rows of a 3x3 kernel.

        >>> regions = Conv("y", "x", (8, 8), "w", dilation=12).regions(18)
        >>> [(region.source.start, region.source.stop, region.taps.start, region.taps.stop) for region in regions]
        [(0, 18, 1, 3), (6, 12, 1, 2), (0, 18, 0, 2)]
        """
        d = self.dilation
        regions = []
        for start, stop in pairwise(sorted({0, d, size - d, size})):
            low, high = int(start >= d), int(stop <= size - d)
            regions.append(Region(slice(start - low * d, stop + high * d), slice(1 - low, 2 + high)))
        return tuple(regions)

    def worth_cutting(self, size: int) -> bool:
        """Return whether computing the regions one by one saves an eighth of the products, or more."""
        if self.taps(size) != slice(0, 3) or self.stride != 1 or self.add:
            return False
        # two rows of the kernel miss as many rows as the dilation says
        return 8 * 2 * self.dilation >= 3 * size


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
    """Bilinear interpolation by a whole factor, then ReLU if asked for."""

    name: str
    source: str
    factor: int
    relu: bool = False


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


def merge(factor: int) -> tuple[Layer, ...]:
    """Return the layers of late fusion: 1x1 convolutions 56 → 56 → 56 → 28 over both branches' logits.

    The first is linear and interpolation is, too: interpolating what it gives, by a factor, instead of what it
    takes gives the same, and takes less.
    """
    wide = (2 * _CLASSES, 2 * _CLASSES)
    return (
        Concat("fusion.both", ("rgb.logits", "depth.logits")),
        Conv("fusion.first.coarse", "fusion.both", wide, "merge.0", kernel=1, relu=False),
        Resize("fusion.first", "fusion.first.coarse", factor, relu=True),
        Conv("fusion.second", "fusion.first", wide, "merge.2", kernel=1),
        Conv("fusion.logits", "fusion.second", (wide[0], _CLASSES), "merge.4", kernel=1, relu=False),
    )


def convolutions(layers: Iterable[Layer]) -> Iterator[Conv]:
    """Return the layers that have weights."""
    return (layer for layer in layers if isinstance(layer, Conv))


def rounded(layers: Sequence[Layer]) -> set[str]:
    """Return the names of the results that can do with 8 bits: all but a branch's logits and what comes after them."""
    names = set()
    for layer in layers:
        if isinstance(layer, Conv) and layer.norm:
            names |= {layer.name, f"{layer.name}.conv"} if layer.add else {layer.name}
        elif isinstance(layer, MaxPool | Pool | Spread | Concat):
            names.add(layer.name)
    return names
