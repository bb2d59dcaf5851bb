"""The pictures of a page: each once, small enough for the page to be sent around, and the labels without loss."""

import hashlib
from base64 import b64encode
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any, Final, NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from sunset.classes import CLASS_OF_CARLA_ID, CLASSES
from sunset.faults import DEPTH_COUNTS_PER_METRE
from sunset.recording import StoredImage
from sunset.system import TRUTH_TOPIC
from sunset.viewing.document import DepthScale, PicturesView
from sunset.viewing.labels import pack
from sunset.workers import Progress, processors

_Pixels = npt.NDArray[Any]

_QUALITIES: Final = {80: 1.0, 70: 0.82, 60: 0.74, 50: 0.66}
"""Quality of WebP → about how large a picture is, compared with the first one."""
_WIDEST: Final = 640
"""Pixels of a row that are enough for a page."""
_BYTES_PER_PIXEL: Final = 0.6
"""Of all pictures of a frame together, about."""
_WAITING: Final = 64
"""Pictures that wait to be encoded."""
_MEASURED: Final = 20
"""Of so many pictures of colour, the loss of one is measured."""
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
    """A picture, and the number of pixels of every class index (256,), which are 0 but of labels."""

    data: bytes
    counts: npt.NDArray[np.int64]


class Placed(NamedTuple):
    """An image of a run, and the place of its picture among all."""

    topic: str
    stamp_ns: int
    place: int


@dataclass(frozen=True, slots=True)
class _Settings:
    """How pictures are stored: in what share of their width and height, and in which quality."""

    scale: float
    quality: int

    def reduced(self, plain: int, lossy: int, budget: int) -> "_Settings":
        """Return settings with which pictures will fit that took so many bytes, without and with loss."""
        share = max(budget - plain, 0) / max(lossy, 1) * _QUALITIES[self.quality]
        for quality, size in _QUALITIES.items():
            if quality < self.quality and size <= share:
                return replace(self, quality=quality)
        return replace(self, scale=self.scale * min(sqrt(budget / (plain + lossy)), 0.95) * 0.97)


class _Album:
    """Pictures that are encoded by several threads while more are added."""

    def __init__(self, settings: _Settings, pool: ThreadPoolExecutor) -> None:
        self._settings = settings
        self._pool = pool
        self._places: dict[bytes, int] = {}
        self._encoded: list[Future[_Encoded]] = []
        self._lossy: list[bool] = []
        self._losses: list[Future[float]] = []
        self.original: tuple[int, int] | None = None
        self.depth: DepthScale | None = None
        self._shades = np.zeros(65536, np.uint8)

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of the pictures as they are stored."""
        height, width = self.original or (1, 1)
        scale = min(self._settings.scale, _WIDEST / width)
        return max(round(height * scale), 1), max(round(width * scale), 1)

    def add(self, image: StoredImage) -> int:
        """Return the place of an image's picture, which is new only if no other has the same pixels."""
        mapped = image.topic == TRUTH_TOPIC
        key = hashlib.blake2b(image.png, digest_size=16, salt=bytes([mapped])).digest()
        if key in self._places:
            return self._places[key]
        if self.original is None:
            self.original = image.pixels.shape[:2]
        if image.encoding == "16UC1" and self.depth is None:
            self.depth = _depth_scale(image.pixels)
            self._shades = _depth_shades(self.depth)
        place = self._places[key] = len(self._encoded)
        is_label = image.encoding == "8UC1"
        self._lossy.append(not is_label)
        self._encoded.append(self._pool.submit(self._encode, image, self.size))
        if image.encoding == "bgr8" and place % _MEASURED == 0:
            self._losses.append(self._pool.submit(self._loss, image, self.size))
        if place >= _WAITING:
            self._encoded[place - _WAITING].result()
        return place

    def _encode(self, image: StoredImage, size: tuple[int, int]) -> _Encoded:
        if image.encoding == "8UC1":
            classes = CLASS_OF_CARLA_ID[image.pixels] if image.topic == TRUTH_TOPIC else image.pixels
            labels = _resized(classes, size, cv2.INTER_NEAREST)
            return _Encoded(pack(labels), np.bincount(labels.reshape(-1), minlength=256))
        return _Encoded(_webp(self._coloured(image, size), self._settings.quality), np.zeros(256, np.int64))

    def _coloured(self, image: StoredImage, size: tuple[int, int]) -> _Pixels:
        if image.encoding == "16UC1":
            depth = _resized(image.pixels, size, cv2.INTER_NEAREST)
            coloured: _Pixels = cv2.applyColorMap(self._shades[depth], cv2.COLORMAP_VIRIDIS)
            return coloured
        return _resized(image.pixels, size, cv2.INTER_AREA)

    def _loss(self, image: StoredImage, size: tuple[int, int]) -> float:
        """Return by how much the pixels of a picture differ from what was encoded, on average."""
        original = self._coloured(image, size)
        encoded = np.frombuffer(_webp(original, self._settings.quality), np.uint8)
        stored = np.asarray(cv2.imdecode(encoded, cv2.IMREAD_COLOR), np.int16)
        return float(np.abs(original - stored).mean())

    def sizes(self) -> tuple[int, int]:
        """Return how many bytes the pictures without loss take, and those with it."""
        sizes = [len(one.result().data) for one in self._encoded]
        lossy = sum(size for size, is_lossy in zip(sizes, self._lossy, strict=True) if is_lossy)
        return sum(sizes) - lossy, lossy

    def view(self) -> PicturesView:
        """Return the pictures as the page has them."""
        height, width = self.size
        return PicturesView(
            width=width,
            height=height,
            note=self._note(),
            depth=self.depth,
            classes=self._classes(),
            data=[b64encode(one.result().data).decode() for one in self._encoded],
        )

    def _classes(self) -> list[int]:
        """Return the class indices that more than `_RARE` of the labels' pixels have, the frequent ones first."""
        counts = np.sum([one.result().counts for one in self._encoded], axis=0)[: len(CLASSES)]
        order = np.argsort(-counts, kind="stable")
        return [int(index) for index in order if counts[index] > _RARE * counts.sum()]

    def _note(self) -> str:
        losses = [one.result() for one in self._losses]
        loss = f", by {sum(losses) / len(losses):.1f} of 255 on average" if losses else ""
        height, width = self.original or self.size
        scaled = (
            ""
            if (height, width) == self.size
            else f"Pictures are scaled down from {width} × {height} to {self.size[1]} × {self.size[0]} pixels. "
        )
        exact = "Labels and truth are exact" + (" at that size" if scaled else "")
        return (
            f"{scaled}{exact}; colour and depth are WebP of quality {self._settings.quality}, whose pixels differ "
            f"from the originals{loss}."
        )


def make_pictures(
    sources: Sequence[Source], budget: int, progress: Progress | None = None
) -> tuple[PicturesView, list[list[Placed]]]:
    """Return the pictures of some runs, and for each run where those of its images are.

    Args:
        sources: the runs.
        budget: how many bytes all pictures together may have; if they have more, they are made again in a lower
            quality, and then smaller.
        progress: called with (frames done, frames in all).

    Raises:
        RecordError: images are missing or damaged.
    """
    frames = sum(source.frames for source in sources)
    settings: _Settings | None = None
    with ThreadPoolExecutor(processors()) as pool:
        while True:
            settings = settings or _first_settings(sources, frames, budget)
            album = _Album(settings, pool)
            placed: list[list[Placed]] = []
            stamps: set[tuple[int, int]] = set()
            for number, source in enumerate(sources):
                placed.append([])
                for image in source.images():
                    if not source.wanted(image.topic):
                        continue
                    placed[-1].append(Placed(image.topic, image.stamp_ns, album.add(image)))
                    stamps.add((number, image.stamp_ns))
                    if progress is not None:
                        progress(min(len(stamps), frames), frames)
            plain, lossy = album.sizes()
            if plain + lossy <= budget:
                return album.view(), placed
            settings = settings.reduced(plain, lossy, budget)


def _first_settings(sources: Sequence[Source], frames: int, budget: int) -> _Settings:
    """Return settings that may do, by the number of pixels."""
    first = next((image for source in sources for image in source.images()), None)
    pixels = first.pixels.shape[0] * first.pixels.shape[1] if first else 1
    return _Settings(
        min(1.0, 1.3 * sqrt(budget / (_BYTES_PER_PIXEL * pixels * max(frames, 1)))), max(_QUALITIES)
    )


def _resized(pixels: _Pixels, size: tuple[int, int], interpolation: int) -> _Pixels:
    if pixels.shape[:2] == size:
        return pixels
    resized: _Pixels = cv2.resize(pixels, size[::-1], interpolation=interpolation)
    return resized


def _webp(bgr: _Pixels, quality: int) -> bytes:
    encoded: bytes = cv2.imencode(".webp", bgr, [cv2.IMWRITE_WEBP_QUALITY, quality])[1].tobytes()
    return encoded


def _depth_scale(depth: _Pixels) -> DepthScale:
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
