"""The frames of a flight as lazy images."""

from dataclasses import dataclass
from math import prod
from typing import TYPE_CHECKING, Final

from sunset.images import ImageCache, LazyImage

if TYPE_CHECKING:
    from sunset.data import BagReader

_BYTES_PER_PIXEL: Final = 6
"""Colour, depth and label."""
_MOST_KEPT: Final = 128 << 20
"""The most bytes of frames that are kept."""


@dataclass(frozen=True, slots=True)
class LazyFrame:
    """A frame: colours (H, W, 3) uint8, depth (H, W) uint16 and recorded labels (H, W) uint8."""

    rgb: LazyImage
    depth: LazyImage
    labels: LazyImage


class LazyFrames:
    """The frames of a bag, for the bag player.

    Args:
        bag: the bag.
        cache: where what is measured on frames is looked up; None to compute it each time.
    """

    def __init__(self, bag: "BagReader", cache: ImageCache | None) -> None:
        self.bag: Final = bag
        """The bag."""
        self._cache = cache
        self._kept: tuple[LazyFrame, ...] = ()

    def frame(self, index: int) -> LazyFrame:
        """Return the frame of an index, which is read again each time, unless `keep` was called."""
        return self._kept[index] if self._kept else self._read(index)

    def keep(self) -> None:
        """Keep all frames and their digests, also for forked processes, if they take 128 MiB at most."""
        if not self._kept and len(self.bag) * prod(self.bag.size) * _BYTES_PER_PIXEL <= _MOST_KEPT:
            self._kept = tuple(map(self._read, range(len(self.bag))))
            for frame in self._kept:
                for image in (frame.rgb, frame.depth, frame.labels):
                    _ = image.digest  # known to forked processes, too

    def _read(self, index: int) -> LazyFrame:
        frame = self.bag.frame(index)
        return LazyFrame(
            *(LazyImage.of(each, self._cache) for each in (frame.rgb, frame.depth, frame.labels))
        )
