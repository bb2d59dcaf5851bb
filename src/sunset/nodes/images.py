"""Conversion between `sensor_msgs/msg/Image` and arrays.

An array of a message is a view of its data, which is read-only once it has been published. A message of an array
shares its memory: do not write to it afterwards.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.errors import DataError
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.stamps import ns_of
from sunset_ros.interfaces.std_msgs.msg import Header

BGR: Final = "bgr8"
DEPTH: Final = "16UC1"
METRES: Final = "32FC1"
LABELS: Final = "8UC1"


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


def image_of_bgr(header: Header, bgr: npt.NDArray[np.uint8]) -> Image:
    """Return a (H, W, 3) array as a `bgr8` message."""
    return _image(header, bgr, BGR, 3)


def image_of_depth(header: Header, depth: npt.NDArray[np.uint16]) -> Image:
    """Return a (H, W) array as a `16UC1` message."""
    return _image(header, depth.astype("<u2", copy=False), DEPTH, 2)


def image_of_metres(header: Header, metres: npt.NDArray[np.float32]) -> Image:
    """Return a (H, W) array as a `32FC1` message."""
    return _image(header, metres.astype("<f4", copy=False), METRES, 4)


def image_of_labels(header: Header, labels: npt.NDArray[np.uint8]) -> Image:
    """Return a (H, W) array as an `8UC1` message."""
    return _image(header, labels, LABELS, 1)


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


def _image(header: Header, array: npt.NDArray[np.generic], encoding: str, bytes_per_pixel: int) -> Image:
    height, width = array.shape[:2]
    return Image(
        header=header,
        height=height,
        width=width,
        encoding=encoding,
        step=width * bytes_per_pixel,
        data=np.ascontiguousarray(array).reshape(-1).view(np.uint8),
    )
