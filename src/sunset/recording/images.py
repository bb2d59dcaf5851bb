"""The images of a run in a second bag beside its record, which ROS 2 viewers open.

The bag also has each number of the blackboard on its own topic, for plots. It is not part of the record's digest, since
the record has the digest of every image.
"""

import struct
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeAlias, cast

import cv2
import numpy as np
import numpy.typing as npt

from sunset.classes import CLASS_OF_CARLA_ID, PALETTE
from sunset.errors import RecordError
from sunset.image_messages import digest_of_data
from sunset.images import digest_of
from sunset.recording._bag import BagWriter, Payload, RecordedMessage, read_bag
from sunset.system import RESULT_TOPIC, TRUTH_TOPIC
from sunset.system_interfaces.msg import ImageDigest, SensorFusion, SetBlackboardGroup
from sunset_ros.interfaces import Message, serialize, type_name
from sunset_ros.interfaces.sensor_msgs.msg import CompressedImage, Image
from sunset_ros.interfaces.stamps import ns_of
from sunset_ros.interfaces.std_msgs.msg import Float64
from sunset_ros.parameter import scalar_of

IMAGES_FILE: Final = "images.mcap"
"""The file of a record with its images, if they were kept."""

_SUFFIX: Final = "/compressed"  # the suffix of image_transport for topics with compressed images
_TYPE: Final = type_name(CompressedImage)
_LAYOUTS: Final = {"bgr8": (np.uint8, 3), "16UC1": (np.uint16, 1), "8UC1": (np.uint8, 1)}
"""Encoding → type and number of channels of images that are compressed; others are stored as they are."""
_PNG: Final = (
    cv2.IMWRITE_PNG_COMPRESSION,
    0,  # the bag compresses it
    cv2.IMWRITE_PNG_FILTER,
    cv2.IMWRITE_PNG_FILTER_SUB,  # a choice for every row takes six times as long, for a bag of the same size
)
_REMEMBERED: Final = 16  # PNG files that are kept for the same pixels on another topic

# A PNG file: a signature, and chunks of length, type, data and checksum (PNG 3, sections 5 and 11.2)
_SIGNATURE: Final = 8
_BODY: Final = 33  # the end of the first chunk, IHDR
_COLOUR_TYPE: Final = 25  # the place of the colour type in IHDR
_GRAY, _INDEXED = 0, 3

_Pixels: TypeAlias = npt.NDArray[np.uint8] | npt.NDArray[np.uint16]


@dataclass(frozen=True, slots=True)
class StoredImage:
    """An image that was kept.

    Attributes:
        topic: the full name of the topic; the sensor fusion's images are on `rgb` and `depth` below its topic.
        time_ns: when the image left its publisher, in nanoseconds on the experiment's clock.
        stamp_ns: the stamp of its header.
        encoding: as in `sensor_msgs/msg/Image`.
        png: the image as a PNG file.
    """

    topic: str
    time_ns: int
    stamp_ns: int
    encoding: str
    png: bytes

    @property
    def pixels(self) -> _Pixels:
        """The pixels: `bgr8` (H, W, 3) uint8, `16UC1` (H, W) uint16, `8UC1` (H, W) uint8.

        Raises:
            RecordError: the file is damaged, or does not fit its encoding.
        """
        decoded = None
        if len(self.png) > _BODY:
            png = np.frombuffer(_without_palette(self.png), np.uint8)
            with suppress(cv2.error):
                decoded = cv2.imdecode(png, cv2.IMREAD_UNCHANGED)
        kind, channels = _LAYOUTS.get(self.encoding, (None, 0))
        shape = (channels,) if channels > 1 else ()
        if decoded is None or decoded.dtype != kind or decoded.shape[2:] != shape:
            raise RecordError(f"The image on {self.topic} at {self.time_ns} ns is damaged.")
        return cast("_Pixels", decoded)


class ImageWriter(BagWriter):
    """Writes the images of a run, or of the topics that are wanted, into a bag in an existing folder."""

    def __init__(self, folder: Path, wanted: Callable[[str], bool] | None = None) -> None:
        super().__init__(folder, IMAGES_FILE)
        self._wanted = wanted
        self._pngs: dict[tuple[object, ...], bytes] = {}

    def add(self, topic: str, time_ns: int, message: Message) -> None:
        """Keep the images of a message, or the numbers of the blackboard."""
        if isinstance(message, Image):
            self._write_image(topic, time_ns, message)
        elif isinstance(message, SensorFusion):
            self._write_image(f"{topic}/rgb", time_ns, message.rgb)
            self._write_image(f"{topic}/depth", time_ns, message.depth)
        elif isinstance(message, SetBlackboardGroup):
            for entry in message.bb_params:
                value = scalar_of(entry.value)
                if isinstance(value, bool | int | float):
                    self._put(f"/symptoms/{entry.name}", time_ns, Float64(data=float(value)))

    def _write_image(self, topic: str, time_ns: int, image: Image) -> None:
        if self._wanted is not None and not self._wanted(topic):
            return
        pixels = _pixels_of(image)
        if pixels is None:
            self._put(topic, time_ns, image)
            return
        key = digest_of_data(image), image.encoding, *pixels.shape, image.step
        if key not in self._pngs:
            self._pngs[key] = cv2.imencode(".png", pixels, _PNG)[1].tobytes()
            self._pngs = dict(list(self._pngs.items())[-_REMEMBERED:])
        png = self._pngs[key]
        if topic in _PALETTES:
            png = _with_palette(png, _PALETTES[topic])
        kind, data = f"{image.encoding}; png compressed ", np.frombuffer(png, np.uint8)
        self._put(topic + _SUFFIX, time_ns, CompressedImage(header=image.header, format=kind, data=data))

    def _put(self, topic: str, time_ns: int, message: Message) -> None:
        self.write(Payload(topic, type_name(type(message)), time_ns, serialize(message)))


def without_pixels(message: Message) -> Message:
    """Return a message with digests in place of images, as records have it."""
    if isinstance(message, Image):
        return _digest_message(message, digest_of_data(message))
    if isinstance(message, SensorFusion):
        parts = digest_of_data(message.depth), digest_of_data(message.rgb)
        modality = bytes([message.modality.fusion_type])
        fused = _digest_message(message.rgb, digest_of(b"".join([*parts, modality])))
        fused.header = message.header
        return fused
    return message


def _digest_message(image: Image, digest: bytes) -> ImageDigest:
    return ImageDigest(
        header=image.header, height=image.height, width=image.width, encoding=image.encoding, digest=digest
    )


def image_digests(messages: Iterable[RecordedMessage]) -> set[tuple[str, int, bytes]]:
    """Return topic, stamp in nanoseconds and digest of each image in a record's messages."""
    return {
        (recorded.topic, ns_of(recorded.message.header.stamp), bytes(recorded.message.digest))
        for recorded in messages
        if isinstance(recorded.message, ImageDigest)
    }


def read_images(folder: Path) -> Iterator[StoredImage]:
    """Return the images of a run in order of time.

    Raises:
        RecordError: the images were not kept, or the file is damaged.
    """
    if not (folder / IMAGES_FILE).exists():
        raise RecordError(f"The record {folder} has no images: run it with --images.")
    for payload in read_bag(folder, IMAGES_FILE):
        if payload.type == _TYPE:
            message = cast("CompressedImage", payload.decoded().message)
            yield StoredImage(
                topic=payload.topic.removesuffix(_SUFFIX),
                time_ns=payload.time_ns,
                stamp_ns=ns_of(message.header.stamp),
                encoding=message.format.partition(";")[0],
                png=message.data.tobytes(),
            )


def _pixels_of(image: Image) -> _Pixels | None:
    """Return the pixels of an image (H, W, channels); None if PNG cannot store them."""
    if image.encoding not in _LAYOUTS or image.is_bigendian:
        return None
    kind, channels = _LAYOUTS[image.encoding]
    width = image.width * channels * np.dtype(kind).itemsize
    step = image.step or width
    if not 0 < width <= step or not 0 < image.height * step <= image.data.size:
        return None
    rows = image.data[: image.height * step].reshape(image.height, step)[:, :width]
    return np.ascontiguousarray(rows).view(kind).reshape(image.height, image.width, channels)


_PALETTES: Final = {RESULT_TOPIC: PALETTE.tobytes(), TRUTH_TOPIC: PALETTE[CLASS_OF_CARLA_ID].tobytes()}
"""Topic → the colours of 256 labels, as a PNG palette."""


def _with_palette(png: bytes, palette: bytes) -> bytes:
    """Return a PNG file with its gray values as indices into a palette."""
    return _head(png, _INDEXED) + _chunk(b"PLTE" + palette) + png[_BODY:]


def _without_palette(png: bytes) -> bytes:
    """Return a PNG file with its indices into a palette of 256 colours as gray values; others are unchanged."""
    if png[_COLOUR_TYPE : _COLOUR_TYPE + 1] != bytes([_INDEXED]):
        return png
    return _head(png, _GRAY) + png[_BODY + len(_chunk(b"PLTE" + bytes(3 * 256))) :]


def _head(png: bytes, colour_type: int) -> bytes:
    """Return the beginning of a PNG file, with another colour type."""
    header = png[_SIGNATURE + 4 : _COLOUR_TYPE] + bytes([colour_type]) + png[_COLOUR_TYPE + 1 : _BODY - 4]
    return png[:_SIGNATURE] + _chunk(header)


def _chunk(content: bytes) -> bytes:
    return struct.pack(">I", len(content) - 4) + content + struct.pack(">I", zlib.crc32(content))
