"""Conversion between `sensor_msgs/msg/Image` and images.

Nodes work on a `LazyImage` of a message, and publish a message whose `data` are computed when they are read. Arrays of
messages are views of their data, which is read-only once it has been published. A message of an array shares its
memory: do not write to it afterwards.
"""

from collections.abc import Callable
from copy import copy
from typing import Final, Self, cast

import numpy as np
import numpy.typing as npt

from sunset.errors import DataError
from sunset.images import LazyImage, Pixels, digest_of
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.stamps import ns_of
from sunset_ros.interfaces.std_msgs.msg import Header

BGR: Final = "bgr8"
DEPTH: Final = "16UC1"
METRES: Final = "32FC1"
LABELS: Final = "8UC1"


class LazyMessage(Image):  # noqa: PLW1641  as all messages
    """A message of an image whose `data` are computed when they are read."""

    __slots__ = ("_data", "_made", "image")

    def __init__(self, header: Header, image: LazyImage, encoding: str, bytes_per_pixel: int) -> None:
        self.header = header
        self.height, self.width = image.size
        self.encoding = encoding
        self.is_bigendian = 0
        self.step = self.width * bytes_per_pixel
        self.image: LazyImage | None = image
        """The image; None after other data were assigned."""
        self._data: npt.NDArray[np.uint8] | None = None
        self._made = self._layout

    @property
    def data(self) -> npt.NDArray[np.uint8]:
        """The pixels' bytes."""
        if self._data is None:
            self._data = _flat(cast("LazyImage", self.image).pixels)
        return self._data

    @data.setter
    def data(self, value: npt.NDArray[np.uint8]) -> None:
        self._data, self.image, self._made = value, None, ()

    def copy(self) -> Self:
        """Return a copy that shares the image."""
        if self.image is None:
            return super().copy()
        new = object.__new__(type(self))
        new.header = self.header.copy()
        new.height, new.width, new.step = self.height, self.width, self.step
        new.encoding, new.is_bigendian = self.encoding, self.is_bigendian
        new.image, new._data, new._made = self.image, self._data, self._made
        return new

    @property
    def unchanged_image(self) -> LazyImage | None:
        """The image, unless a field that says what the data mean was changed."""
        return self.image if self._made == self._layout else None

    @property
    def _layout(self) -> tuple[object, ...]:
        return self.height, self.width, self.encoding, self.is_bigendian, self.step

    def plain(self) -> Image:
        """Return the same message, with its data."""
        return Image(**{name: getattr(self, name) for name in self.__ros_fields__})

    def __eq__(self, other: object) -> bool:
        return self.plain() == (other.plain() if isinstance(other, LazyMessage) else other)

    def __repr__(self) -> str:
        return repr(self.plain())

    def __reduce__(self) -> tuple[object, ...]:
        return copy, (self.plain(),)


def stamp_ns(header: Header) -> int:
    """Return a header's stamp in nanoseconds."""
    return ns_of(header.stamp)


def array_of_bgr(image: Image) -> npt.NDArray[np.uint8]:
    """Return a `bgr8` image as (H, W, 3), without a copy; raise a `DataError` if it is not a whole one."""
    return _rows(image, BGR, 3).reshape(image.height, image.width, 3)


def array_of_depth(image: Image) -> npt.NDArray[np.uint16]:
    """Return a `16UC1` image as (H, W), as `array_of_bgr`; big-endian images are copied."""
    rows = _rows(image, DEPTH, 2)
    counts = np.ascontiguousarray(rows).view(">u2" if image.is_bigendian else "<u2")
    native: npt.NDArray[np.uint16] = counts.astype(np.uint16, copy=False)
    return native


def array_of_labels(image: Image) -> npt.NDArray[np.uint8]:
    """Return an `8UC1` image as (H, W), as `array_of_bgr`."""
    return _rows(image, LABELS, 1)


def bgr_of(image: Image) -> LazyImage:
    """Return a `bgr8` image, (H, W, 3) uint8; raise a `DataError` if it is not a whole one."""
    return _lazy(image, BGR, array_of_bgr)


def depth_of(image: Image) -> LazyImage:
    """Return a `16UC1` image, (H, W) uint16, as `bgr_of`."""
    return _lazy(image, DEPTH, array_of_depth)


def labels_of(image: Image) -> LazyImage:
    """Return an `8UC1` image, (H, W) uint8, as `bgr_of`."""
    return _lazy(image, LABELS, array_of_labels)


def digest_of_data(image: Image) -> bytes:
    """Return the digest of an image's data, as `digest_of`."""
    lazy = _lazy_image(image)
    return digest_of(image.data) if lazy is None else lazy.digest


def image_of_bgr(header: Header, bgr: LazyImage | npt.NDArray[np.uint8]) -> Image:
    """Return a (H, W, 3) image as a `bgr8` message."""
    return _image(header, bgr, BGR, 3)


def image_of_depth(header: Header, depth: LazyImage | npt.NDArray[np.uint16]) -> Image:
    """Return a (H, W) image as a `16UC1` message."""
    return _image(header, depth, DEPTH, 2)


def image_of_metres(header: Header, metres: npt.NDArray[np.float32]) -> Image:
    """Return a (H, W) image as a `32FC1` message."""
    return _image(header, metres, METRES, 4)


def image_of_labels(header: Header, labels: LazyImage | npt.NDArray[np.uint8]) -> Image:
    """Return a (H, W) image as an `8UC1` message."""
    return _image(header, labels, LABELS, 1)


def _lazy_image(image: Image) -> LazyImage | None:
    """Return the image of a message that a node has made of it and nobody has changed."""
    return image.unchanged_image if isinstance(image, LazyMessage) else None


def _lazy(image: Image, encoding: str, array_of: Callable[[Image], Pixels]) -> LazyImage:
    lazy = _lazy_image(image) if image.encoding == encoding else None
    return lazy or LazyImage.of(array_of(image))


def _rows(image: Image, encoding: str, bytes_per_pixel: int) -> npt.NDArray[np.uint8]:
    """Return the bytes as (H, W * bytes_per_pixel), without padding of rows.

    Raises:
        DataError: the image has another encoding, or less data than its size needs.
    """
    if image.encoding != encoding:
        raise DataError(f"An image must have the encoding {encoding} here, got {image.encoding!r}.")
    width = image.width * bytes_per_pixel
    step = image.step or width
    if step < width or image.data.size < step * image.height:
        raise DataError(
            f"A {encoding} image of {image.width} x {image.height} pixels in rows of {step} bytes cannot "
            f"have {image.data.size} bytes."
        )
    rows = image.data[: step * image.height].reshape(image.height, step)
    return rows[:, :width]


def _image(header: Header, image: LazyImage | Pixels, encoding: str, bytes_per_pixel: int) -> Image:
    if isinstance(image, LazyImage):
        return LazyMessage(header, image, encoding, bytes_per_pixel)
    height, width = image.shape[:2]
    step = width * bytes_per_pixel
    return Image(header=header, height=height, width=width, encoding=encoding, step=step, data=_flat(image))


def _flat(pixels: Pixels) -> npt.NDArray[np.uint8]:
    """Return the bytes of pixels, in little-endian order."""
    little = pixels.astype(pixels.dtype.newbyteorder("<"), copy=False)
    return np.ascontiguousarray(little).reshape(-1).view(np.uint8)
