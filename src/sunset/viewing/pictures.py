"""The pictures of a page: each once, small enough for the page to be sent around, and the labels without loss."""

import hashlib
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
from sunset.image_digests import Pixels, digest_of
from sunset.processes.workers import Progress, processors
from sunset.recording import StoredImage
from sunset.system import TRUTH_TOPIC
from sunset.viewing.document import DepthScale, PicturesView
from sunset.viewing.labels import pack

_QUALITIES: Final = {80: 1.0, 70: 0.8, 60: 0.7, 50: 0.62}
"""Quality of WebP → about how large a picture is, compared with the first one."""
_WIDEST: Final = 640
"""Pixels of a row that are enough for a page."""
_BYTES_PER_PIXEL: Final = 0.6
"""Of all pictures of a frame together, about."""
_LEAST: Final = 0.6
"""Colour and depth keep at least this share of the labels' width and height."""
_SAMPLED: Final = 10
"""Of so many frames, one is looked at to see how large all pictures will be."""
_SURPLUS: Final = 1.02
"""By what they may be larger than that."""
_WAITING: Final = 64
"""Pictures that wait to be encoded."""
_MEASURED: Final = 19
"""Of so many pictures, the loss of one is measured if it is of colour; a prime, since kinds take turns."""
LABELS: Final = "8UC1"
"""The encoding of labels."""
_DEPTH: Final = "16UC1"
_RARE: Final = 0.0005
_COLOURS: Final = 9
"""Of the depth's scale, that the legend shows."""
_PERCENTILES: Final = (1, 99)
_MARGIN: Final = 1.15
"""The first image's depths, times and over this, are the limits of the scale."""


class Source(NamedTuple):
    """Where images of a run come from.

    Attributes:
        images: returns them in order of time, whenever it is called.
        frames: how many frames there are, about.
        wanted: whether images of a topic are shown.
    """

    images: Callable[[], Iterable[StoredImage]]
    frames: int
    wanted: Callable[[str], bool]


class _Encoded(NamedTuple):
    """A picture.

    Attributes:
        counts: of labels, the number of pixels of every class index (256,).
        loss: of some pictures of colour, by how much its pixels differ from the original's on average, of 255.
    """

    data: bytes
    counts: npt.NDArray[np.int64] | None = None
    loss: float | None = None


class Placed(NamedTuple):
    """An image of a run, the place of its picture among all, and the digest of its pixels when that is known."""

    topic: str
    encoding: str
    stamp_ns: int
    place: int
    digest: bytes = b""


@dataclass(frozen=True, slots=True)
class _Settings:
    """How pictures are stored.

    Attributes:
        scale: the share of their width and height that labels keep.
        shrink: of that, the share that colour and depth keep.
        quality: of colour and depth.
    """

    scale: float
    shrink: float = 1.0
    quality: int = max(_QUALITIES)

    def reduced(self, plain: int, lossy: int, budget: int) -> "_Settings":
        """Return settings with which pictures will fit that took so many bytes, without and with loss.

        Labels stay as they are as long as that is possible.
        """
        share = max(budget - plain, 0) / max(lossy, 1)
        for quality, size in _QUALITIES.items():
            if quality < self.quality and size / _QUALITIES[self.quality] <= share:
                return replace(self, quality=quality)
        shrink = self.shrink * min(sqrt(share), 0.95) * 0.97
        if shrink >= _LEAST:
            return replace(self, shrink=shrink)
        return replace(self, scale=self.scale * min(sqrt(budget / (plain + lossy)), 0.95) * 0.97)


class _Album:
    """Pictures that are encoded by several threads while more are added."""

    def __init__(self, settings: _Settings, pool: ThreadPoolExecutor) -> None:
        self._settings = settings
        self._pool = pool
        self._places: dict[bytes, int] = {}
        self._encoded: list[Future[_Encoded]] = []
        self._digests: list[Future[bytes]] = []
        self.original: tuple[int, int] | None = None
        self.depth: DepthScale | None = None
        self._shades = np.zeros(65536, np.uint8)

    def size(self, shrink: float = 1.0) -> tuple[int, int]:
        """Return height and width of the pictures as they are stored."""
        height, width = self.original or (1, 1)
        scale = self._settings.scale * shrink
        return max(round(height * scale), 1), max(round(width * scale), 1)

    def add(self, image: StoredImage) -> int:
        """Return the place of an image's picture, which is new only if no other has the same pixels."""
        mapped = image.topic == TRUTH_TOPIC
        key = hashlib.blake2b(image.png, digest_size=16, salt=bytes([mapped])).digest()
        if key in self._places:
            return self._places[key]
        if self.original is None:
            self.original = image.pixels.shape[:2]
        if image.encoding == _DEPTH and self.depth is None:
            self.depth = _depth_scale(image.pixels)
            self._shades = _depth_shades(self.depth)
        place = self._places[key] = len(self._encoded)
        self._digests.append(self._pool.submit(_digest, image))
        if image.encoding == LABELS:
            self._encoded.append(self._pool.submit(self._packed, image, self.size()))
        else:
            self._encoded.append(
                self._pool.submit(
                    self._compressed, image, self.size(self._settings.shrink), place % _MEASURED == 0
                )
            )
        if place >= _WAITING:
            self._encoded[place - _WAITING].result()
        return place

    def _packed(self, image: StoredImage, size: tuple[int, int]) -> _Encoded:
        classes = CLASS_OF_CARLA_ID[image.pixels] if image.topic == TRUTH_TOPIC else image.pixels
        labels = _resized(classes, size, cv2.INTER_NEAREST)
        return _Encoded(pack(labels), counts=np.bincount(labels.reshape(-1), minlength=256))

    def _compressed(self, image: StoredImage, size: tuple[int, int], is_measured: bool) -> _Encoded:
        if image.encoding == _DEPTH:
            depth = _resized(image.pixels, size, cv2.INTER_NEAREST)
            shown = cv2.applyColorMap(self._shades[depth], cv2.COLORMAP_VIRIDIS)
            return _Encoded(_webp(shown, self._settings.quality))
        original = _resized(image.pixels, size, cv2.INTER_AREA)
        data = _webp(original, self._settings.quality)
        if not is_measured:
            return _Encoded(data)
        stored = np.asarray(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR), np.int16)
        return _Encoded(data, loss=float(np.abs(original - stored).mean()))

    def with_digest(self, one: Placed) -> Placed:
        """Return where an image's picture is, with the digest of its pixels."""
        return one._replace(digest=self._digests[one.place].result())

    def sizes(self) -> tuple[int, int]:
        """Return how many bytes the pictures without loss take, and those with it."""
        encoded = [one.result() for one in self._encoded]
        plain = sum(len(one.data) for one in encoded if one.counts is not None)
        return plain, sum(len(one.data) for one in encoded) - plain

    def view(self) -> PicturesView:
        """Return the pictures as the page has them."""
        encoded = [one.result() for one in self._encoded]
        height, width = self.size()
        return PicturesView(
            width=width,
            height=height,
            note=self._note([one.loss for one in encoded if one.loss is not None]),
            depth=self.depth,
            classes=_frequent([one.counts for one in encoded if one.counts is not None]),
            data=[b64encode(one.data).decode() for one in encoded],
        )

    def _note(self, losses: Sequence[float]) -> str:
        """Return how pictures differ from the originals."""
        original, size, shrunk = self.original or self.size(), self.size(), self.size(self._settings.shrink)
        parts = [
            "Labels and truth are exact"
            if size == original
            else f"Labels and truth are {_by(original, size)}"
        ]
        shown = "" if shrunk == original else f"{_by(original, shrunk)}, and "
        loss = f": their pixels differ by {sum(losses) / len(losses):.1f} of 255 on average" if losses else ""
        parts.append(f"colour and depth are {shown}WebP of quality {self._settings.quality}{loss}")
        return "; ".join(parts) + "."


def _digest(image: StoredImage) -> bytes:
    return digest_of(image.pixels.data)


def _by(original: tuple[int, int], size: tuple[int, int]) -> str:
    return f"scaled down from {original[1]} × {original[0]} to {size[1]} × {size[0]} pixels"


def _frequent(counts: Sequence[npt.NDArray[np.int64]]) -> list[int]:
    """Return the class indices that more than `_RARE` of the labels' pixels have, the frequent ones first."""
    total = np.sum([np.zeros(256, np.int64), *counts], axis=0)[: len(CLASSES)]
    order = np.argsort(-total, kind="stable")
    return [int(index) for index in order if total[index] > _RARE * total.sum()]


def make_pictures(
    sources: Sequence[Source], budget: int, progress: Progress | None = None
) -> tuple[PicturesView, list[list[Placed]]]:
    """Return the pictures of some runs, and for each run where those of its images are.

    Args:
        sources: the runs.
        budget: how many bytes all pictures together may have; if they have more, they are made again in a lower
            quality, and then smaller.
        progress: called with (frames done, frames in all), for one run after the other.

    Raises:
        RecordError: images are missing or damaged, or are too many.
    """
    frames = sum(source.frames for source in sources)
    settings = _first_settings(sources, frames, budget)
    with ThreadPoolExecutor(processors()) as pool:
        album = _Album(settings, pool)
        for every in (_SAMPLED, 1):  # an album that will do keeps what was sampled
            while True:
                told = None if every > 1 else progress
                placed = [list(_placed(source, album, every, told)) for source in sources]
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
        return album.view(), [list(map(album.with_digest, of_run)) for of_run in placed]


def _first_settings(sources: Sequence[Source], frames: int, budget: int) -> _Settings:
    """Return settings that may do, by the number of pixels."""
    first = next((image for source in sources for image in source.images()), None)
    height, width = first.pixels.shape[:2] if first else (1, 1)
    in_all = _BYTES_PER_PIXEL * height * width * max(frames, 1)
    return _Settings(min(1.0, _WIDEST / width, 1.5 * sqrt(budget / in_all)))


def _placed(source: Source, album: _Album, every: int, progress: Progress | None) -> Iterator[Placed]:
    """Add the images of one of so many frames of a run to an album, and yield where they are."""
    stamps: dict[int, int] = {}
    for image in source.images():
        if not source.wanted(image.topic) or stamps.setdefault(image.stamp_ns, len(stamps)) % every:
            continue
        yield Placed(image.topic, image.encoding, image.stamp_ns, album.add(image))
        if progress is not None:
            progress(min(len(stamps), source.frames), source.frames)


def _resized(pixels: Pixels, size: tuple[int, int], interpolation: int) -> Pixels:
    if pixels.shape[:2] == size:
        return pixels
    resized: Pixels = cv2.resize(pixels, size[::-1], interpolation=interpolation)
    return resized


def _webp(bgr: Pixels, quality: int) -> bytes:
    encoded: bytes = cv2.imencode(".webp", bgr, [cv2.IMWRITE_WEBP_QUALITY, quality])[1].tobytes()
    return encoded


def _depth_scale(depth: Pixels) -> DepthScale:
    """Return a scale for the depths of a flight, by its first image."""
    near, far = np.percentile(depth, _PERCENTILES) / DEPTH_COUNTS_PER_METRE
    near, far = max(float(near) / _MARGIN, 0.1), min(float(far) * _MARGIN, 1000.0)
    far = max(far, 2 * near)
    steps = np.linspace(255, 0, _COLOURS).astype(np.uint8).reshape(1, -1)
    colours = cv2.applyColorMap(steps, cv2.COLORMAP_VIRIDIS)[0]
    texts = [f"#{red:02x}{green:02x}{blue:02x}" for blue, green, red in colours.tolist()]
    return DepthScale(round(near, 2), round(far, 2), texts)


def _depth_shades(scale: DepthScale) -> npt.NDArray[np.uint8]:
    """Return the place on the scale of colours (65536,) of every depth in counts; near ones are light."""
    metres = np.maximum(np.arange(65536), 1) / DEPTH_COUNTS_PER_METRE
    share = np.log(metres / scale.near) / np.log(scale.far / scale.near)
    shades: npt.NDArray[np.uint8] = (255 * (1 - np.clip(share, 0, 1))).astype(np.uint8)
    return shades
