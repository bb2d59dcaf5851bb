"""Networks as plain data: a plan of layers, which torch runs in training and ONNX Runtime in inference; their inputs.

A plan names the result of every layer, and the torch modules that hold the weights. Several plans can run the same
weights: for example, the first phase of a training uses strides in place of dilations.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

from sunset.classes import CLASSES

_CLASSES: Final = len(CLASSES)
WIDTH: Final = 256
HEIGHT: Final = 144

RGB_MEAN: Final = (0.485, 0.456, 0.406)
RGB_STD: Final = (0.229, 0.224, 0.225)

FAR_PLANE_M: Final = 1000.0
"""The depth of 65535 counts."""

REFERENCE_DEPTH_M: Final = 50.0
"""Channel 0 of the depth input is the logarithm of the depth over this."""

DEPTH_LIMIT_M: Final = 200.0
"""Larger depths count as this depth in the local contrasts."""

CONTRASTS: Final = ((16, 5.0, 2.0), (8, 1.0, 2.0))
"""Channels 1 and 2: depth minus its mean over blocks of so many pixels (interpolated), in units of so many metres,
cut at so many units. A car is 1.5 m high at a distance of 50 m: it only shows locally."""


@dataclass(frozen=True, slots=True)
class Conv:
    """A convolution with optional normalisation, addition, ReLU and, in training, dropout, in this order."""

    name: str
    source: str  # the result that is convolved
    channels: tuple[int, int]  # in, out
    weights: str  # the module of the kernel, and of the bias if there is no normalisation
    norm: str = ""  # the module of the batch normalisation; empty without normalisation
    kernel: int = 3  # odd; the source is padded with zeros to keep its size
    stride: int = 1
    dilation: int = 1
    add: str = ""  # a result to add, of the same shape or of a single pixel
    relu: bool = True
    dropout: float = 0.0  # the share of values that training sets to 0

    def taps(self, size: int) -> slice:
        """Return the rows of the kernel that see more than padding in a source of `size` rows; or columns.

        >>> Conv("y", "x", (8, 8), "w", dilation=24).taps(18)
        slice(1, 2, None)
        """
        centre = self.kernel // 2
        reach = min(centre, (size - 1) // self.dilation)
        return slice(centre - reach, centre + reach + 1)

    def padding(self, size: int) -> int:
        """Return the rows of zeros that `taps` needs on each side; or columns."""
        return self.dilation * (self.kernel // 2 - int(self.taps(size).start))

    def regions(self, size: int) -> tuple[tuple[slice, slice], ...]:
        """Return the regions of a result of `size` rows, each of which sees other rows of a 3x3 kernel; or columns.

        Each is the rows of the source, and the rows of the kernel that see them without padding.

        >>> regions = Conv("y", "x", (8, 8), "w", dilation=12).regions(18)
        >>> [(source.start, source.stop, taps.start, taps.stop) for source, taps in regions]
        [(0, 18, 1, 3), (6, 12, 1, 2), (0, 18, 0, 2)]
        """
        d = self.dilation
        regions = []
        for start, stop in pairwise(sorted({0, d, size - d, size})):
            low, high = int(start >= d), int(stop <= size - d)
            regions.append((slice(start - low * d, stop + high * d), slice(1 - low, 2 + high)))
        return tuple(regions)

    def worth_cutting(self, size: int) -> bool:
        """Return whether computing the regions separately saves an eighth of the products, or more."""
        if self.taps(size) != slice(0, 3) or self.stride != 1 or self.add:
            return False
        # two of the kernel's three rows miss as many rows as the dilation
        return 8 * 2 * self.dilation >= 3 * size


@dataclass(frozen=True, slots=True)
class _Unary:
    """A layer of one source without weights."""

    name: str
    source: str


class MaxPool(_Unary):
    """The maximum over 3x3 pixels with stride 2."""


class Pool(_Unary):
    """The mean over all pixels, as a single pixel."""


class Shuffle(_Unary):
    """Each group of four channels as 2x2 pixels of one channel."""


@dataclass(frozen=True, slots=True)
class Spread(_Unary):
    """A single pixel, repeated to the size of another result."""

    like: str


@dataclass(frozen=True, slots=True)
class Resize(_Unary):
    """Bilinear interpolation by a whole factor, with an optional ReLU."""

    factor: int
    relu: bool = False


@dataclass(frozen=True, slots=True)
class Concat:
    """The channels of several results."""

    name: str
    sources: tuple[str, ...]


Layer: TypeAlias = Conv | MaxPool | Pool | Spread | Resize | Concat | Shuffle


def merge(factor: int) -> tuple[Layer, ...]:
    """Return the layers of late fusion: 1x1 convolutions 56 → 56 → 56 → 28 over the logits of both branches.

    The first convolution is linear, like the interpolation by `factor`, so interpolating its result is the same as
    interpolating its source, and faster.
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
    """Return the layers with weights."""
    return (layer for layer in layers if isinstance(layer, Conv))


def upsampling(size: int, factor: int) -> npt.NDArray[np.float32]:
    """Return the matrix (size · factor, size) float32 of bilinear interpolation along one axis.

    Pixels are areas: the centres of the first and last coarse pixel lie inside, and the border repeats beyond them
    (torch's `align_corners=False`).

    >>> upsampling(2, 2).tolist()
    [[1.0, 0.0], [0.75, 0.25], [0.25, 0.75], [0.0, 1.0]]
    """
    centres = (np.arange(size * factor) + 0.5) / factor - 0.5
    low = np.floor(centres).astype(int)
    fraction = centres - low
    matrix = np.zeros((size * factor, size), dtype=np.float32)
    rows = np.arange(size * factor)
    np.add.at(matrix, (rows, np.clip(low, 0, size - 1)), 1 - fraction)
    np.add.at(matrix, (rows, np.clip(low + 1, 0, size - 1)), fraction)
    return matrix
