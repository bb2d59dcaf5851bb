"""Conversion of recorded pixels to a frame's: message encodings, picture files, units, sizes.

Errors are `DataError`s that name the image.
"""

import os
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Final, TypeVar

import cv2
import numpy as np
import numpy.typing as npt

from sunset.errors import DataError
from sunset.images import Pixels
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_town import DEPTH_RANGE_M, Frame

T = TypeVar("T")

FAR: Final = 65535
"""The depth count of points 1000 m away or further, and of unknown depth."""

COLOUR_JPEG: Final = "8-bit colour JPEG"
COLOUR_PNG: Final = "8-bit colour PNG"
DEPTH_PNG: Final = "16-bit greyscale PNG"
LABEL_PNG: Final = "8-bit greyscale PNG"

_ENCODINGS: Final = {
    "bgr8": ("u1", 3),
    "rgb8": ("u1", 3),
    "bgra8": ("u1", 4),
    "rgba8": ("u1", 4),
    "16UC1": ("u2", 1),
    "mono16": ("u2", 1),
    "32FC1": ("f4", 1),
    "8UC1": ("u1", 1),
    "mono8": ("u1", 1),
}
"""Encoding of a `sensor_msgs/msg/Image` → type of a value, values a pixel."""

_JPEG: Final = b"\xff\xd8\xff"
_PNG: Final = b"\x89PNG\r\n\x1a\n"
_ENDS: Final = (b"\xff\xd9", b"IEND\xaeB`\x82")
"""The last bytes of a JPEG and of a PNG."""
_PNG_COLOURS: Final = {0: "greyscale", 2: "colour", 3: "palette", 4: "greyscale-alpha", 6: "colour-alpha"}


def dimensions(size: tuple[int, int]) -> str:
    """Return (height, width) as text.

    >>> dimensions((144, 256))
    '256x144'
    """
    return f"{size[1]}x{size[0]}"


def raw_pixels(message: Image, place: str, encodings: Collection[str]) -> Pixels:
    """Return the pixels of a `sensor_msgs/msg/Image`, (H, W) or (H, W, channels), in this machine's byte order.

    Rows may be padded.

    Raises:
        DataError: it has another encoding, or less data than its size needs; `place` names the image.
    """
    if message.encoding not in encodings:
        raise DataError(
            f"The image {place} must have the encoding {_either(encodings)}, got {message.encoding!r}; "
            "convert it while recording."
        )
    kind, channels = _ENCODINGS[message.encoding]
    dtype = np.dtype(kind).newbyteorder(">" if message.is_bigendian else "<")
    height, row = message.height, message.width * channels * dtype.itemsize
    step = message.step or row
    if not height * row or step < row or len(message.data) < height * step:
        raise DataError(
            f"The image {place} must have at least one pixel, and {height} rows of at least {row} bytes, got "
            f"{len(message.data)} bytes in rows of {step}; record it again."
        )
    rows = message.data[: height * step].reshape(height, step)[:, :row]
    pixels = np.ascontiguousarray(rows).view(dtype).astype(np.dtype(kind), copy=False)
    return pixels.reshape(height, -1, channels) if channels > 1 else pixels


def read_picture(path: Path, kinds: Collection[str]) -> Pixels:
    """Return the `picture` in a file.

    Raises:
        DataError: it cannot be read, is of another kind, truncated or damaged.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise DataError(f"The image {path} cannot be read: {error.strerror}; copy it again.") from error
    return picture(data, str(path), kinds)


def read_ahead(read: Callable[[T], Frame], items: Iterable[T], *, jobs: int | None = None) -> Iterator[Frame]:
    """Yield `read(item)` for each item, in order; `jobs` threads, by default one a processor, read ahead.

    Their number changes no byte.
    """
    workers = jobs or os.cpu_count() or 1
    left = iter(items)
    with ThreadPoolExecutor(workers) as pool:
        pending = deque(pool.submit(read, item) for item in islice(left, 2 * workers))
        try:
            while pending:
                yield pending.popleft().result()
                pending.extend(pool.submit(read, item) for item in islice(left, 1))
        finally:
            pool.shutdown(cancel_futures=True)


def picture(data: bytes, place: str, kinds: Collection[str]) -> Pixels:
    """Return the pixels of a JPEG or PNG file, (H, W) or (H, W, 3) in the order blue, green, red.

    Kinds are of `COLOUR_JPEG`, `COLOUR_PNG`, `DEPTH_PNG`, `LABEL_PNG`.

    Raises:
        DataError: it is of another kind, truncated or damaged; `place` names the image.
    """
    kind, pixels = _kind(data), None
    if kind in kinds:
        # the decoder takes half a JPEG for a whole one; a writer may have filled its last block with zeros
        if not data.rstrip(b"\0").endswith(_ENDS):
            raise _damage_error(place, "it ends before the picture does")
        with suppress(cv2.error):
            pixels = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
        if pixels is None:
            raise _damage_error(place, "the decoder gives up")
        if kind == COLOUR_JPEG and not pixels.shape[2:]:
            kind = "8-bit greyscale JPEG"
    if kind not in kinds or pixels is None:
        raise DataError(
            f"The image {place} must be of the kind {_either(kinds)}, got {kind}; "
            "take it from its source unconverted."
        )
    return np.asarray(pixels)


def _kind(data: bytes) -> str:
    if data.startswith(_JPEG):
        return COLOUR_JPEG
    if data.startswith(_PNG) and len(data) > 25:  # noqa: PLR2004  the header's bit depth and colour type
        return f"{data[24]}-bit {_PNG_COLOURS.get(data[25], 'unknown')} PNG"
    return "neither JPEG nor PNG" if data else "no data"


def _damage_error(place: str, reason: str) -> DataError:
    return DataError(
        f"The image {place} must be a whole picture, got a damaged one: {reason}; copy it again."
    )


def _either(names: Collection[str]) -> str:
    *others, last = names
    return f"{', '.join(others)} or {last}" if others else last


def bgr_of(pixels: Pixels, encoding: str) -> npt.NDArray[np.uint8]:
    """Return colour pixels (H, W, 3 or 4) of an encoding as (H, W, 3) in the order blue, green, red."""
    ordered = pixels[..., 2::-1] if encoding.startswith("rgb") else pixels[..., :3]
    return np.ascontiguousarray(ordered)


def counts_of_metres(metres: npt.NDArray[np.float32]) -> npt.NDArray[np.uint16]:
    """Return depths in metres as counts of 1000 / 65535 m.

    Depths beyond 1000 m and unknown depths (NaN, +inf) become `FAR`; too near ones (-inf, REP 117) become 0.

    >>> counts_of_metres(np.array([0, 500, 2000, np.nan, -np.inf], dtype=np.float32)).tolist()
    [0, 32768, 65535, 65535, 0]
    """
    known = np.nan_to_num(metres, nan=DEPTH_RANGE_M, posinf=DEPTH_RANGE_M, neginf=0.0)
    return np.rint(known.clip(0, DEPTH_RANGE_M) * (FAR / DEPTH_RANGE_M)).astype(np.uint16)


def resample(frame: Frame, size: tuple[int, int]) -> Frame:
    """Return a frame in another size, given as height and width in pixels.

    Where the shapes differ, the largest central part of the wanted shape is taken, without distortion. A colour
    pixel becomes the mean over its area; depth and label are taken at the pixel's centre, so that the three stay
    aligned and no new depth or id arises.
    """
    if frame.size == size:
        return frame
    top, left, height, width = _central(frame.size, size)
    window = slice(top, top + height), slice(left, left + width)
    # the source pixel under the centre of each wanted pixel, in whole numbers: 2i + 1 half pixels
    rows = top + (2 * np.arange(size[0]) + 1) * height // (2 * size[0])
    columns = left + (2 * np.arange(size[1]) + 1) * width // (2 * size[1])
    chosen = np.ix_(rows, columns)
    rgb = cv2.resize(frame.rgb[window], (size[1], size[0]), interpolation=cv2.INTER_AREA)
    return Frame(np.asarray(rgb), frame.depth[chosen], frame.labels[chosen])


def _central(size: tuple[int, int], shape: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return top, left, height and width of the largest central part of `size` with the shape of `shape`."""
    height = min(size[0], max(1, round(size[1] * shape[0] / shape[1])))
    width = min(size[1], max(1, round(size[0] * shape[1] / shape[0])))
    return (size[0] - height) // 2, (size[1] - width) // 2, height, width
