"""Conversion between the image messages of a bag and the arrays of a frame."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np

from sunset.classes import CLASS_OF_CARLA_ID, IGNORED
from sunset.data.conventions import Reading
from sunset.data.pixels import COLOUR_JPEG, COLOUR_PNG, DEPTH_PNG, FAR, LABEL_PNG, bgr_of, picture, raw_pixels
from sunset.errors import DataError
from sunset.files.compression import zstd
from sunset.images import Pixels
from sunset_ros.interfaces import deserialize, serialize
from sunset_ros.interfaces.sensor_msgs.msg import CompressedImage, Image
from sunset_ros.interfaces.stamps import ns_of, stamp_of
from sunset_ros.interfaces.std_msgs.msg import Header

TOPICS: Final = MappingProxyType({"/rgb_raw": "bgr8", "/depth_raw": "16UC1", "/gt_segmentation": "8UC1"})
"""The topics of a bag and the encodings in which their images are written."""

IMAGE: Final = Image.__ros_name__
COMPRESSED_IMAGE: Final = CompressedImage.__ros_name__

_ZSTD: Final = b"\x28\xb5\x2f\xfd"
_PNG: Final = b"\x89PNG"


@dataclass(frozen=True, slots=True)
class Sensor:
    """The accepted images of a sensor: encodings of an `Image`, pictures of a `CompressedImage`.

    Transports are suffixes of the topic by image_transport; the first transport that has messages is read.
    """

    encodings: tuple[str, ...]
    pictures: tuple[str, ...]
    transports: tuple[str, ...] = ("", "/compressed")

    def topic(self, topic: str, counts: Mapping[str, int]) -> str:
        """Return the recorded name of the sensor's topic, or `topic` itself.

        `counts` are the numbers of messages of all recorded topics; all 0 if they were not counted.
        """
        names = [topic + transport for transport in self.transports if topic + transport in counts]
        return min(names, key=lambda name: not counts[name], default=topic)


SENSORS: Final = MappingProxyType(
    {
        "/rgb_raw": Sensor(("bgr8", "rgb8", "bgra8", "rgba8"), (COLOUR_JPEG, COLOUR_PNG)),
        "/depth_raw": Sensor(
            ("16UC1", "mono16", "32FC1"), (DEPTH_PNG,), ("", "/compressedDepth", "/compressed")
        ),
        "/gt_segmentation": Sensor(("8UC1", "mono8"), (LABEL_PNG,)),
    }
)
"""By topic, in the order of a frame's images."""


@dataclass(frozen=True, slots=True)
class Recorded:
    """A message's image: its time, its encoding or compressed format, and pixels as in a `Frame`."""

    stamp_ns: int
    encoding: str
    pixels: Pixels


def decoded(raw: bytes | memoryview, kind: str, topic: str, place: str, reading: Reading) -> Recorded:
    """Return the image in a serialized message of the type `IMAGE` or `COMPRESSED_IMAGE`.

    Raises:
        DataError: its encoding is not accepted, or it is damaged; `place` names the image.
    """
    plain = zstd.decompress(raw) if bytes(raw[:4]) == _ZSTD else raw
    message: Image | CompressedImage
    if kind == IMAGE:
        message = deserialize(plain, Image)
        encoding = order = message.encoding
        pixels = raw_pixels(message, place, SENSORS[topic].encodings)
    else:
        message = deserialize(plain, CompressedImage)
        encoding, order = message.format, "bgr8"  # the order of decoded pictures
        pixels = _unpacked(message, topic, place)
    if topic == "/rgb_raw":
        pixels = bgr_of(pixels, order)
    elif topic == "/depth_raw":
        pixels = reading.depth(pixels)
    else:
        pixels = reading.labels(pixels, place)
    pixels.flags.writeable = False
    return Recorded(ns_of(message.header.stamp), encoding, pixels)


def is_known(pixels: Pixels, topic: str) -> bool:
    """Return whether any depth, or any class, in an image of a topic is known."""
    if topic == "/depth_raw":
        return bool((pixels < FAR).any())
    return topic == "/gt_segmentation" and bool((CLASS_OF_CARLA_ID.take(pixels) != IGNORED).any())


def _unpacked(message: CompressedImage, topic: str, place: str) -> Pixels:
    data = message.data.tobytes()
    if topic == "/depth_raw":
        if message.format.startswith("32FC1"):
            raise DataError(
                f"The image {place} must hold depth as it was measured, got {message.format!r}, which holds "
                "rounded reciprocals: record the uncompressed topic."
            )
        # compressedDepth puts a header before the picture
        data = data[max(data.find(_PNG), 0) :]
    return picture(data, place, SENSORS[topic].pictures)


def serialized(image: Pixels, encoding: str, stamp_ns: int) -> bytes:
    """Return a serialized `sensor_msgs/msg/Image` of an image (H, W) or (H, W, channels) in its encoding's type."""
    little = np.ascontiguousarray(image, dtype=image.dtype.newbyteorder("<"))
    return serialize(
        Image(
            header=Header(stamp=stamp_of(stamp_ns), frame_id="camera"),
            height=image.shape[0],
            width=image.shape[1],
            encoding=encoding,
            step=little[0].nbytes,
            data=little.reshape(-1).view(np.uint8),
        )
    )
