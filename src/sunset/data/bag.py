"""Flight bags: rosbag2 recordings of colour, depth and labels, written and read.

A bag holds `sensor_msgs/msg/Image` messages on three topics, one of each per frame, paired by the stamps of
their headers: `/rgb_raw` (bgr8), `/depth_raw` (16UC1) and `/gt_segmentation` (8UC1).
"""

import tempfile
import weakref
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Self

import numpy as np
import numpy.typing as npt
from rosbags.interfaces import Connection
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from sunset.data.frame import Frame
from sunset.errors import DataError, InvalidInputError, OutputError

__all__ = ["TOPICS", "BagReader", "read_bag", "write_bag"]

TOPICS: Final = MappingProxyType({"/rgb_raw": "bgr8", "/depth_raw": "16UC1", "/gt_segmentation": "8UC1"})
"""The topics of a bag and the encodings of their images."""

IMAGE: Final = "sensor_msgs/msg/Image"
REMEDY: Final = "record or render the bag again"
NANO: Final = 1_000_000_000
_DTYPES: Final = {"bgr8": ("<u1", 3), "16UC1": ("<u2", 1), "8UC1": ("<u1", 1)}
_STORE: Final = get_typestore(Stores.ROS2_JAZZY)


def write_bag(
    folder: Path, frames: Iterable[Frame], stamps_ns: Sequence[int], *, storage: str = "mcap"
) -> Path:
    """Write a bag, all of it or nothing, and return its folder; the same frames give the same bytes.

    Args:
        folder: to be made; its name becomes that of the file in it.
        frames: in the order of their stamps, all of one size.
        stamps_ns: time of each frame in nanoseconds, from 0, strictly increasing.
        storage: "mcap" or "sqlite3".

    Raises:
        InvalidInputError: frames and stamps are not as many, a stamp is not later than the one before, or the
            storage is unknown.
        OutputError: the folder exists or cannot be written.
    """
    if storage.upper() not in StoragePlugin.__members__:
        raise InvalidInputError(f"A bag's storage must be mcap or sqlite3, got {storage!r}.")
    if any(stamp < 0 for stamp in stamps_ns) or any(np.diff(np.asarray(stamps_ns, dtype=np.int64)) <= 0):
        raise InvalidInputError("A bag's stamps must be from 0 on and strictly increasing, got others.")
    if folder.exists():
        raise OutputError(f"The bag {folder} cannot be written because it exists: choose another folder.")
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".writing-", dir=folder.parent) as draft:
            made = Path(draft) / folder.name
            _write(made, frames, stamps_ns, StoragePlugin[storage.upper()])
            made.rename(folder)
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(f"The bag {folder} cannot be written: {reason}; choose another place.") from error
    return folder


def _write(folder: Path, frames: Iterable[Frame], stamps_ns: Sequence[int], plugin: StoragePlugin) -> None:
    written = 0
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        connections = [writer.add_connection(topic, IMAGE, typestore=_STORE) for topic in TOPICS]
        for frame in frames:
            if written < len(stamps_ns):
                images: tuple[npt.NDArray[Any], ...] = (frame.rgb, frame.depth, frame.labels)
                for connection, image in zip(connections, images, strict=True):
                    stamp = int(stamps_ns[written])
                    writer.write(connection, stamp, _serialized(image, TOPICS[connection.topic], stamp))
            written += 1
        if written != len(stamps_ns):
            raise InvalidInputError(
                f"A bag needs one stamp per frame, got {len(stamps_ns)} for {written} frames."
            )


def _serialized(image: npt.NDArray[Any], encoding: str, stamp_ns: int) -> memoryview:
    types = _STORE.types
    stamp = types["builtin_interfaces/msg/Time"](sec=stamp_ns // NANO, nanosec=stamp_ns % NANO)
    dtype, channels = _DTYPES[encoding]
    height, width = image.shape[:2]
    message = types[IMAGE](
        header=types["std_msgs/msg/Header"](stamp=stamp, frame_id="camera"),
        height=height,
        width=width,
        encoding=encoding,
        is_bigendian=0,
        step=width * channels * np.dtype(dtype).itemsize,
        data=np.ascontiguousarray(image, dtype=dtype).reshape(-1).view(np.uint8),
    )
    return _STORE.serialize_cdr(message, IMAGE)


@contextmanager
def _translated(path: Path) -> Iterator[None]:
    """Turn whatever the bag library raises about a broken file into one `DataError`."""
    try:
        yield
    except DataError:
        raise
    except Exception as error:  # the library raises a dozen kinds on broken files, none documented
        what = str(error).splitlines()[0].rstrip(".") if str(error) else type(error).__name__
        raise DataError(f"The bag {path} cannot be read as a rosbag2: {what}; {REMEDY}.") from error


@dataclass(frozen=True, slots=True)
class _Entry:
    """Where one message is: its time in the bag, and the stamp and size that it carries."""

    logged_ns: int
    stamp_ns: int
    size: tuple[int, int]


class BagReader:
    """A bag that was opened and checked; made by `read_bag`.

    Frames are read when they are asked for, none is kept. Use it as a context manager, or `close` it.
    """

    def __init__(self, path: Path, reader: Reader, index: Mapping[str, Sequence[_Entry]]) -> None:
        self._path = path
        self._reader = reader
        self._index = index
        first = next(iter(index.values()))
        self._stamps = tuple(entry.stamp_ns for entry in first)
        self._size = first[0].size
        # a reader that nobody closed gives its file back with its memory
        weakref.finalize(self, _close, reader)

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self._stamps)

    def __repr__(self) -> str:
        return f"BagReader({str(self._path)!r}, frames={len(self)}, size={self._size})"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the bag's file; frames can no longer be read."""
        _close(self._reader)

    @property
    def path(self) -> Path:
        """The bag's folder or file."""
        return self._path

    @property
    def stamps_ns(self) -> tuple[int, ...]:
        """The frames' times in nanoseconds, strictly increasing."""
        return self._stamps

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of every frame in pixels."""
        return self._size

    def frame(self, index: int) -> Frame:
        """Return one frame; its arrays are read-only.

        Args:
            index: in [0, len(self)).

        Raises:
            IndexError: there is no frame of this index.
            DataError: the file was closed, or changed since it was opened.
        """
        if not 0 <= index < len(self):
            raise IndexError(f"The bag {self._path} has frames 0 to {len(self) - 1}, got {index}.")
        images: dict[str, npt.NDArray[Any]] = {}
        with _translated(self._path):
            times = {entries[index].logged_ns for entries in self._index.values()}
            for time in sorted(times):
                for connection, _, raw in self._reader.messages(_connections(self._reader), time, time + 1):
                    message = _STORE.deserialize_cdr(raw, IMAGE)
                    if _stamp(message) == self._stamps[index]:
                        images[connection.topic] = _array(message)
        if len(images) != len(TOPICS):
            raise DataError(
                f"The bag {self._path} changed after it was opened: frame {index} is gone; open it again."
            )
        rgb, depth, labels = (images[topic] for topic in TOPICS)
        return Frame(rgb, depth, labels)


def _connections(reader: Reader) -> list[Connection]:
    return [connection for connection in reader.connections if connection.topic in TOPICS]


def _stamp(message: Any) -> int:
    return int(message.header.stamp.sec) * NANO + int(message.header.stamp.nanosec)


def _array(message: Any) -> npt.NDArray[Any]:
    """Return an image message's pixels, read-only: (H, W, 3) for bgr8, (H, W) else."""
    dtype, channels = _DTYPES[message.encoding]
    rows = message.data.reshape(message.height, message.step)
    pixels = np.ascontiguousarray(rows[:, : message.width * channels * np.dtype(dtype).itemsize])
    image = pixels.view(np.dtype(dtype).newbyteorder(">" if message.is_bigendian else "<"))
    image = image.astype(dtype, copy=False)
    if channels > 1:
        image = image.reshape(message.height, message.width, channels)
    image.flags.writeable = False
    return image


def _close(reader: Reader) -> None:
    if reader.is_open:
        reader.close()


def read_bag(path: Path) -> BagReader:
    """Open a bag, in MCAP or sqlite3 storage, and check all of it.

    Args:
        path: the bag's folder, or the `.mcap` or `.db3` file itself.

    Raises:
        DataError: it is missing or unreadable, or is no recording of the three topics with the same number
            of images, the same stamps, the right encodings, and one size.
    """
    if not path.exists():
        raise DataError(f"There is no bag at {path}: give the folder of a rosbag2 recording.")
    with _translated(path):
        reader = Reader(path)
        reader.open()
        try:
            index = _index(path, reader)
            _check_pairing(path, index)
        except BaseException:
            reader.close()
            raise
    return BagReader(path, reader, index)


def _index(path: Path, reader: Reader) -> dict[str, list[_Entry]]:
    """Read every message once and return where each topic's are, by stamp."""
    index: dict[str, list[_Entry]] = {topic: [] for topic in TOPICS}
    for connection in _connections(reader):
        if connection.msgtype != IMAGE:
            raise DataError(
                f"The bag {path} must have {IMAGE} on {connection.topic}, got {connection.msgtype}; {REMEDY}."
            )
    present = {connection.topic for connection in reader.connections}
    for topic in TOPICS:
        if topic not in present:
            found = ", ".join(sorted(present)) or "none"
            raise DataError(f"The bag {path} must have the topic {topic}, got {found}; {REMEDY}.")
    for connection, logged_ns, raw in reader.messages(_connections(reader)):
        message: Any = _STORE.deserialize_cdr(raw, IMAGE)
        entry = _Entry(logged_ns, _stamp(message), (int(message.height), int(message.width)))
        place = f"message {len(index[connection.topic])} on {connection.topic}"
        _check_image(path, place, message, TOPICS[connection.topic])
        index[connection.topic].append(entry)
    return {topic: sorted(entries, key=lambda entry: entry.stamp_ns) for topic, entries in index.items()}


def _check_image(path: Path, place: str, message: Any, encoding: str) -> None:
    if message.encoding != encoding:
        raise DataError(
            f"The bag {path} must have encoding {encoding} in {place}, got {message.encoding!r}; {REMEDY}."
        )
    dtype, channels = _DTYPES[encoding]
    row = message.width * channels * np.dtype(dtype).itemsize
    expected = message.height * message.step
    if not row or message.step < row or len(message.data) != expected:
        raise DataError(
            f"The bag {path} must have {message.height} rows of at least {row} bytes in {place}, "
            f"got {len(message.data)} bytes in rows of {message.step}; {REMEDY}."
        )


def _check_pairing(path: Path, index: Mapping[str, Sequence[_Entry]]) -> None:
    """Check that the three topics tell of the same moments in images of one size."""
    counts = {topic: len(entries) for topic, entries in index.items()}
    told = ", ".join(f"{count} on {topic}" for topic, count in counts.items())
    if len(set(counts.values())) > 1:
        raise DataError(f"The bag {path} must have as many images on every topic, got {told}; {REMEDY}.")
    if not all(counts.values()):
        raise DataError(f"The bag {path} must have at least one frame, got {told}; {REMEDY}.")
    first = index["/rgb_raw"]
    for topic, entries in index.items():
        for number, (entry, other) in enumerate(zip(entries, first, strict=True)):
            if entry.stamp_ns != other.stamp_ns:
                raise DataError(
                    f"The bag {path} must have the stamps of /rgb_raw on {topic}, got {entry.stamp_ns} ns "
                    f"for {other.stamp_ns} ns at frame {number}; {REMEDY}."
                )
            if entry.size != first[0].size:
                raise DataError(
                    f"The bag {path} must have images of one size, {_pixels(first[0].size)}, got "
                    f"{_pixels(entry.size)} on {topic} at frame {number}; {REMEDY}."
                )
            if number and entry.stamp_ns == entries[number - 1].stamp_ns:
                raise DataError(
                    f"The bag {path} must have every stamp once, got {entry.stamp_ns} ns twice "
                    f"on {topic}; {REMEDY}."
                )


def _pixels(size: tuple[int, int]) -> str:
    return f"{size[1]}x{size[0]}"
