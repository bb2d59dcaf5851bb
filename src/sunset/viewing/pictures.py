"""The pictures of a page: each once, within a number of bytes, and labels without loss if possible."""

import hashlib
import zlib
from base64 import b64encode
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from math import sqrt
from typing import Final, NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from sunset.classes import CLASS_OF_CARLA_ID, CLASSES
from sunset.errors import RecordError
from sunset.faults import DEPTH_COUNTS_PER_METRE
from sunset.images import Pixels
from sunset.processes.workers import Progress, processors
from sunset.recording import StoredImage
from sunset.system import TRUTH_TOPIC

LABELS: Final = "8UC1"
"""The encoding of labels."""
_DEPTH: Final = "16UC1"

_QUALITIES: Final = {80: 1.0, 70: 0.8, 60: 0.7, 50: 0.62}
"""Quality of WebP → approximate size of a picture, relative to the first."""
_WIDEST: Final = 640  # pixels of a row that suffice for a page
_BYTES_PER_PIXEL: Final = 0.6  # of all pictures of a frame together, approximately
_SAMPLED: Final = 10  # the size of all pictures is estimated from each tenth frame
_SURPLUS: Final = 1.02  # the margin of this estimate
_WAITING: Final = 64  # pictures that wait to be encoded
_LONGEST_STRETCH: Final = 65535  # the largest number of pixels in two bytes
_RARE: Final = 0.0005  # the share of pixels below which the legend leaves a class out
_COLOURS: Final = 9  # colours of the depth's scale in the legend
_PERCENTILES: Final = (1, 99)
_MARGIN: Final = 1.15
"""The limits of the scale are these percentiles of the first image's depths, divided and multiplied by the margin."""


@dataclass(frozen=True, slots=True)
class DepthScale:
    """The colours of depths from `near` to `far` [m], evenly spaced on a logarithmic scale."""

    near: float
    far: float
    colours: list[str]


@dataclass(frozen=True, slots=True)
class PicturesView:
    """All pictures of the page, each once, and the indices of the visible classes, the frequent classes first.

    The size is the labels'. The data are WebP of colour and depth, and packed labels, in base64.
    """

    width: int
    height: int
    note: str
    depth: DepthScale | None
    classes: list[int]
    data: list[str]


class Source(NamedTuple):
    """A function that returns a run's images in order of time, their frames, about, and the topics that are shown."""

    images: Callable[[], Iterable[StoredImage]]
    frames: int
    wanted: Callable[[str], bool]


class Placed(NamedTuple):
    """An image of a run, and the index of its picture."""

    topic: str
    encoding: str
    stamp_ns: int
    place: int


class _Encoded(NamedTuple):
    """A picture, and of labels the pixels of each class (256,)."""

    data: bytes
    counts: npt.NDArray[np.int64] | None = None


@dataclass(frozen=True, slots=True)
class _Settings:
    """The share of width and height that pictures keep, and the quality of colour and depth."""

    scale: float
    quality: int = max(_QUALITIES)

    def reduced(self, plain: int, lossy: int, budget: int) -> "_Settings":
        """Return settings for pictures that took these bytes, without and with loss; all shrink last."""
        share = max(budget - plain, 0) / max(lossy, 1)
        for quality, size in _QUALITIES.items():
            if quality < self.quality and size / _QUALITIES[self.quality] <= share:
                return replace(self, quality=quality)
        return replace(self, scale=self.scale * min(sqrt(budget / (plain + lossy)), 0.95) * 0.97)


class _Album:
    """Pictures that several threads encode while more are added."""

    def __init__(self, settings: _Settings, pool: ThreadPoolExecutor) -> None:
        self._settings = settings
        self._pool = pool
        self._places: dict[bytes, int] = {}
        self._encoded: list[Future[_Encoded]] = []
        self._original: tuple[int, int] | None = None
        self._depth: DepthScale | None = None
        self._shades = np.zeros(65536, np.uint8)

    def size(self) -> tuple[int, int]:
        """Return height and width of the stored pictures."""
        height, width = self._original or (1, 1)
        return max(round(height * self._settings.scale), 1), max(round(width * self._settings.scale), 1)

    def add(self, image: StoredImage) -> int:
        """Return the index of an image's picture, which images with the same pixels share."""
        mapped = image.topic == TRUTH_TOPIC
        key = hashlib.blake2b(image.png, digest_size=16, salt=bytes([mapped])).digest()
        if key in self._places:
            return self._places[key]
        if self._original is None:
            self._original = image.pixels.shape[:2]
        if image.encoding == _DEPTH and self._depth is None:
            self._depth = _depth_scale(image.pixels)
            self._shades = _depth_shades(self._depth)
        place = self._places[key] = len(self._encoded)
        if image.encoding == LABELS:
            encoded = self._pool.submit(_packed, image, self.size())
        else:
            encoded = self._pool.submit(self._compressed, image, self.size())
        self._encoded.append(encoded)
        if place >= _WAITING:
            self._encoded[place - _WAITING].result()
        return place

    def _compressed(self, image: StoredImage, size: tuple[int, int]) -> _Encoded:
        if image.encoding == _DEPTH:
            depth = _resized(image.pixels, size, cv2.INTER_NEAREST)
            shown = cv2.applyColorMap(self._shades[depth], cv2.COLORMAP_VIRIDIS)
            return _Encoded(_webp(shown, self._settings.quality))
        return _Encoded(_webp(_resized(image.pixels, size, cv2.INTER_AREA), self._settings.quality))

    def sizes(self) -> tuple[int, int]:
        """Return the bytes of all pictures without loss, and of all pictures with loss."""
        encoded = [future.result() for future in self._encoded]
        plain = sum(len(picture.data) for picture in encoded if picture.counts is not None)
        return plain, sum(len(picture.data) for picture in encoded) - plain

    def view(self) -> PicturesView:
        """Return the pictures for the page."""
        encoded = [future.result() for future in self._encoded]
        height, width = self.size()
        return PicturesView(
            width=width,
            height=height,
            note=self._note(),
            depth=self._depth,
            classes=_frequent([picture.counts for picture in encoded if picture.counts is not None]),
            data=[b64encode(picture.data).decode() for picture in encoded],
        )

    def _note(self) -> str:
        old, new = self._original or self.size(), self.size()
        labels = "exact"
        if new != old:
            labels = f"scaled down from {old[1]} × {old[0]} to {new[1]} × {new[0]} pixels"
        return (
            f"Labels and truth are {labels}; colour and depth are WebP of quality {self._settings.quality}."
        )


def make_pictures(
    sources: Sequence[Source], budget: int, progress: Progress | None = None
) -> tuple[PicturesView, list[list[Placed]]]:
    """Return the pictures of some runs, and the places of each run's images.

    Args:
        sources: the runs.
        budget: the bytes of all pictures; larger pictures are made again with lower quality, and then smaller.
        progress: called with (frames done, frames in all), for a run after the other.

    Raises:
        RecordError: images are missing, damaged, or too many.
    """
    frames = sum(source.frames for source in sources)
    settings = _first_settings(sources, frames, budget)
    with ThreadPoolExecutor(processors()) as pool:
        album = _Album(settings, pool)
        for every in (_SAMPLED, 1):  # an album that fits keeps the sample
            while True:
                update = None if every > 1 else progress
                placed = [list(_placed(source, album, every, update)) for source in sources]
                surplus = _SURPLUS if every > 1 else 1
                plain, lossy = (round(size * every * surplus) for size in album.sizes())
                if plain + lossy <= budget:
                    break
                if album.size() == (1, 1):
                    raise RecordError(
                        f"The images of {frames} frames have no room in a page: show a shorter run."
                    )
                settings = settings.reduced(plain, lossy, budget)
                album = _Album(settings, pool)
        return album.view(), placed


def _first_settings(sources: Sequence[Source], frames: int, budget: int) -> _Settings:
    first = next((image for source in sources for image in source.images()), None)
    height, width = first.pixels.shape[:2] if first else (1, 1)
    in_all = _BYTES_PER_PIXEL * height * width * max(frames, 1)
    return _Settings(min(1.0, _WIDEST / width, 1.5 * sqrt(budget / in_all)))


def _placed(source: Source, album: _Album, every: int, progress: Progress | None) -> Iterator[Placed]:
    """Add the images of a run to an album, all or a sample of the frames, and yield their places."""
    stamps: dict[int, int] = {}
    for image in source.images():
        if not source.wanted(image.topic) or stamps.setdefault(image.stamp_ns, len(stamps)) % every:
            continue
        yield Placed(image.topic, image.encoding, image.stamp_ns, album.add(image))
        if progress is not None:
            progress(min(len(stamps), source.frames), source.frames)


def pack_labels(labels: npt.NDArray[np.uint8]) -> bytes:
    """Return an image (H, W) of class indices, packed for the page's script.

    Browsers may change pixels that a script reads from a picture, so the result is not a picture. It consists of the
    class indices of stretches of equal pixels, row after row, the low bytes of the stretches' lengths, and the high
    bytes, deflated (RFC 1951).
    """
    pixels = labels.reshape(-1)
    changes = np.flatnonzero(np.diff(pixels)) + 1
    starts = np.union1d(np.concatenate([[0], changes]), np.arange(0, pixels.size, _LONGEST_STRETCH))
    lengths = np.diff(np.append(starts, pixels.size)).astype("<u2")
    low, high = lengths.view(np.uint8)[::2], lengths.view(np.uint8)[1::2]
    packer = zlib.compressobj(9, wbits=-zlib.MAX_WBITS)
    return packer.compress(pixels[starts].tobytes() + low.tobytes() + high.tobytes()) + packer.flush()


def _packed(image: StoredImage, size: tuple[int, int]) -> _Encoded:
    classes = CLASS_OF_CARLA_ID[image.pixels] if image.topic == TRUTH_TOPIC else image.pixels
    labels = _resized(classes, size, cv2.INTER_NEAREST)
    return _Encoded(pack_labels(labels), counts=np.bincount(labels.reshape(-1), minlength=256))


def _frequent(counts: Sequence[npt.NDArray[np.int64]]) -> list[int]:
    total = np.sum([np.zeros(256, np.int64), *counts], axis=0)[: len(CLASSES)]
    order = np.argsort(-total, kind="stable")
    return [int(index) for index in order if total[index] > _RARE * total.sum()]


def _resized(pixels: Pixels, size: tuple[int, int], interpolation: int) -> Pixels:
    if pixels.shape[:2] == size:
        return pixels
    resized: Pixels = cv2.resize(pixels, size[::-1], interpolation=interpolation)
    return resized


def _webp(bgr: Pixels, quality: int) -> bytes:
    encoded: bytes = cv2.imencode(".webp", bgr, [cv2.IMWRITE_WEBP_QUALITY, quality])[1].tobytes()
    return encoded


def _depth_scale(depth: Pixels) -> DepthScale:
    """Return the scale for a flight with this first image of depth."""
    near, far = np.percentile(depth, _PERCENTILES) / DEPTH_COUNTS_PER_METRE
    near, far = max(float(near) / _MARGIN, 0.1), min(float(far) * _MARGIN, 1000.0)
    far = max(far, 2 * near)
    steps = np.linspace(255, 0, _COLOURS).astype(np.uint8).reshape(1, -1)
    colours = cv2.applyColorMap(steps, cv2.COLORMAP_VIRIDIS)[0]
    texts = [f"#{red:02x}{green:02x}{blue:02x}" for blue, green, red in colours.tolist()]
    return DepthScale(round(near, 2), round(far, 2), texts)


def _depth_shades(scale: DepthScale) -> npt.NDArray[np.uint8]:
    """Return the index (65536,) in the colour map of every depth in counts; near depths are light."""
    metres = np.maximum(np.arange(65536), 1) / DEPTH_COUNTS_PER_METRE
    share = np.log(metres / scale.near) / np.log(scale.far / scale.near)
    shades: npt.NDArray[np.uint8] = (255 * (1 - np.clip(share, 0, 1))).astype(np.uint8)
    return shades
