"""Flight bags: rosbag2 recordings of colour, depth and labels, written and read.

A bag holds images on three topics, `/rgb_raw`, `/depth_raw` and `/gt_segmentation`, that belong together by
the stamps of their headers. `write_bag` writes a bag; `read_bag` reads bags of ROS 2 tools, too.
"""

import sqlite3
import tempfile
import weakref
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import zip_longest
from pathlib import Path
from typing import Final, Self

import numpy as np
import numpy.typing as npt
from rosbags.interfaces import Connection
from rosbags.rosbag2 import Reader, StoragePlugin, Writer

from sunset.data.bag_images import (
    COMPRESSED_IMAGE,
    IMAGE,
    SENSORS,
    TOPICS,
    Recorded,
    decoded,
    is_known,
    serialized,
)
from sunset.data.bag_paths import REMEDY, check_bag_path, connections_of, reopened, translated
from sunset.data.conventions import SYNDRONE, Reading
from sunset.data.pixels import dimensions, resample
from sunset.errors import DataError, InvalidInputError, OutputError
from sunset.files.outputs import flush, unwritable
from sunset.images import Pixels
from sunset_ros.interfaces import message_definition, type_hash
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_town import Frame

__all__ = ["TOPICS", "BagReader", "read_bag", "write_bag"]

_TRUTH: Final = "/gt_segmentation"


def write_bag(path: Path, frames: Iterable[Frame], stamps_ns: Sequence[int]) -> Path:
    """Write a bag completely or not at all, and return its path; the same frames give the same bytes.

    Args:
        path: a rosbag2 folder in MCAP, or a single file if it ends in `.mcap` or `.db3`.
        frames: in the order of their stamps, all of the same size.
        stamps_ns: time of each frame in nanoseconds, from 0, strictly increasing.

    Raises:
        InvalidInputError: the numbers of frames and stamps differ, or stamps do not increase.
        OutputError: the path exists or cannot be written.
    """
    alone = path.suffix in {".mcap", ".db3"}
    plugin = StoragePlugin.SQLITE3 if path.suffix == ".db3" else StoragePlugin.MCAP
    if any(stamp < 0 for stamp in stamps_ns) or any(np.diff(np.asarray(stamps_ns, dtype=np.int64)) <= 0):
        raise InvalidInputError("A bag's stamps must be from 0 on and strictly increasing, got others.")
    if path.exists():
        raise OutputError(f"The bag {path} cannot be written because it exists: choose another name.")
    if path.suffix == ".db3" and set("#?%") & set(str(path.absolute())):  # sqlite3 takes a path as a URI
        raise OutputError(f"A bag in sqlite3 must lie under a path without #, ? and %, got {path}: use MCAP.")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".writing-", dir=path.parent) as draft:
            folder = Path(draft) / (path.stem if alone else path.name)
            _write(folder, frames, stamps_ns, plugin)
            flush(folder)
            (folder / path.name if alone else folder).rename(path)
    except sqlite3.Error as error:
        raise OutputError(f"The bag {path} cannot be written: {error}; name another place.") from error
    except OSError as error:
        raise unwritable(f"The bag {path}", error) from error
    return path


def _write(folder: Path, frames: Iterable[Frame], stamps_ns: Sequence[int], plugin: StoragePlugin) -> None:
    definition, digest = message_definition(Image), type_hash(Image)
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        connections = [
            writer.add_connection(topic, IMAGE, msgdef=definition, rihs01=digest) for topic in TOPICS
        ]
        for frame, stamp in zip_longest(frames, map(int, stamps_ns)):
            if frame is None or stamp is None:
                raise InvalidInputError("A bag needs one stamp per frame, got more of either.")
            images: tuple[Pixels, ...] = (frame.rgb, frame.depth, frame.labels)
            for connection, image in zip(connections, images, strict=True):
                writer.write(connection, stamp, serialized(image, TOPICS[connection.topic], stamp))


@dataclass(frozen=True, slots=True)
class _Entry:
    """An image in a bag: its time in the bag, its header's stamp, and whether any depth or class in it is known."""

    logged_ns: int
    stamp_ns: int
    known: bool


class BagReader:
    """An opened and checked bag, as returned by `read_bag`.

    Threads and forked processes may share it. Use it as a context manager, or `close` it.
    """

    def __init__(self, path: Path, reader: Reader, size: tuple[int, int] | None, reading: Reading) -> None:
        self.path: Final = path
        """The bag's folder or file."""
        self._reader, self._reading = reader, reading
        # a reader that was not closed closes its file when it is deleted
        weakref.finalize(self, _close, reader)
        connections = connections_of(reader)
        counts: Counter[str] = Counter()
        for connection in connections:
            counts[connection.topic] += connection.msgcount
        self._sources = {sensor.topic(topic, counts): topic for topic, sensor in SENSORS.items()}
        self._wanted = [connection for connection in connections if connection.topic in self._sources]
        self.topics: Final = self._checked_topics()
        """Type and number of messages of every topic in the bag."""
        self.recorded_size = (0, 0)
        """Height and width of the images in the bag in pixels."""
        self._encodings: dict[str, set[str]] = {name: set() for name in self._sources}
        self._entries: dict[str, list[_Entry]] = {topic: [] for topic in TOPICS}
        for connection, logged_ns, raw in reader.messages(self._wanted):
            self._add(connection, logged_ns, raw)
        self._check_counts()
        self._moments = self._matched()
        self.size: Final = size or self.recorded_size
        """Height and width of the returned frames in pixels."""

    def __len__(self) -> int:
        return len(self._moments)

    def __repr__(self) -> str:
        return f"BagReader({str(self.path)!r}, frames={len(self)}, size={self.size})"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the bag's file; frames can no longer be read."""
        _close(self._reader)

    @cached_property
    def stamps_ns(self) -> tuple[int, ...]:
        """The stamps of the frames' colour images in nanoseconds, strictly increasing."""
        return tuple(rgb.stamp_ns for rgb, *_ in self._moments)

    @property
    def encodings(self) -> Mapping[str, str]:
        """The encodings of the images on each recorded topic."""
        return {topic: ", ".join(sorted(names)) for topic, names in self._encodings.items() if names}

    @property
    def dropped(self) -> Mapping[str, int]:
        """Number of images of each of `TOPICS` outside frames: without a partner, or recorded twice."""
        frames = Counter(topic for moment in self._moments for topic, _ in zip(TOPICS, moment, strict=False))
        return {topic: len(entries) - frames[topic] for topic, entries in self._entries.items()}

    @property
    def unlabelled(self) -> int:
        """Number of frames without an image of labels, or without a pixel of a class in it."""
        return sum(not any(entry.known for entry in moment[2:]) for moment in self._moments)

    def frame(self, index: int) -> Frame:
        """Return the frame of an index in [0, len(self)); its arrays are read-only.

        Raises:
            IndexError: the index is out of range.
            DataError: the file was closed, or changed since it was opened.
        """
        if not 0 <= index < len(self):
            raise IndexError(f"The bag {self.path} has frames 0 to {len(self) - 1}, got {index}.")
        wanted = dict(zip(TOPICS, self._moments[index], strict=False))
        images: dict[str, Recorded] = {}
        with translated(self.path, opened=True), reopened(self._reader) as reader:
            for time in sorted({entry.logged_ns for entry in wanted.values()}):
                for connection, _, raw in reader.messages(self._wanted, time, time + 1):
                    topic = self._sources[connection.topic]
                    image = self._decoded(raw, connection, f"of frame {index}")
                    if topic in wanted and image.stamp_ns == wanted[topic].stamp_ns:
                        images.setdefault(topic, image)
        if len(images) != len(wanted):
            raise DataError(
                f"The bag {self.path} changed after it was opened: frame {index} is gone; open it again."
            )
        rgb, depth, *labels = (images[topic].pixels for topic in wanted)
        frame = resample(
            Frame(rgb, depth, labels[0] if labels else np.zeros(depth.shape, np.uint8)), self.size
        )
        for array in (frame.rgb, frame.depth, frame.labels):
            array.flags.writeable = False
        return frame

    def _decoded(self, raw: bytes, connection: Connection, which: str) -> Recorded:
        place = f"{which} on {connection.topic} of the bag {self.path}"
        return decoded(raw, connection.msgtype, self._sources[connection.topic], place, self._reading)

    def _checked_topics(self) -> Mapping[str, tuple[str, int]]:
        """Return all topics with their types and numbers of messages, after a check of the needed topics."""
        topics: dict[str, tuple[str, int]] = {}
        for connection in sorted(self._reader.connections, key=lambda connection: connection.topic):
            count = topics.get(connection.topic, ("", 0))[1] + connection.msgcount
            topics[connection.topic] = connection.msgtype, count
        for connection in self._wanted:
            if connection.msgtype not in {IMAGE, COMPRESSED_IMAGE}:
                raise DataError(
                    f"The bag {self.path} must have {IMAGE} or {COMPRESSED_IMAGE} on {connection.topic}, "
                    f"got {connection.msgtype}; record the camera's images."
                )
        for name, topic in self._sources.items():
            if name not in topics and topic != _TRUTH:
                raise DataError(
                    f"The bag {self.path} must have the topic {name}, got {', '.join(topics) or 'none'}; "
                    "record it, or remap what stands for it."
                )
        return topics

    def _add(self, connection: Connection, logged_ns: int, raw: bytes) -> None:
        topic = self._sources[connection.topic]
        number = len(self._entries[topic])
        image = self._decoded(raw, connection, f"{number}")
        size = image.pixels.shape[0], image.pixels.shape[1]
        self.recorded_size = self.recorded_size if any(self.recorded_size) else size
        if size != self.recorded_size:
            raise DataError(
                f"The image {number} on {connection.topic} of the bag {self.path} must have the size of those before "
                f"it, {dimensions(self.recorded_size)}, got {dimensions(size)}; record colour, depth and labels "
                "aligned and of one size."
            )
        self._encodings[connection.topic].add(image.encoding)
        self._entries[topic].append(_Entry(logged_ns, image.stamp_ns, is_known(image.pixels, topic)))

    def _check_counts(self) -> None:
        """Check that all images of the metadata are there, and some on every topic."""
        counts = {topic: len(entries) for topic, entries in self._entries.items()}
        for name, topic in self._sources.items():
            expected, got = self.topics.get(name, ("", 0))[1], counts[topic]
            if got < expected:
                raise DataError(
                    f"The bag {self.path} must have the {expected} images on {name} that its metadata tells of, "
                    f"got {got}; {REMEDY}, or let 'ros2 bag reindex' count what is there."
                )
        if not all(count for topic, count in counts.items() if topic != _TRUTH):
            found = ", ".join(f"{count} on {topic}" for topic, count in counts.items())
            raise DataError(f"The bag {self.path} must have at least one frame, got {found}; {REMEDY}.")

    def _matched(self) -> list[tuple[_Entry, ...]]:
        """Return the images of each frame, in the order of their stamps; two images of a frame without labels."""
        firsts = [self._firsts(topic) for topic in TOPICS]
        stamps = [[entry.stamp_ns for entry in entries] for entries in firsts]
        matches, labels = pair(*stamps[:2]), {row[0]: row[1] for row in pair(stamps[0], stamps[2])}
        if not matches or (stamps[2] and not labels):
            own_stamps = ((topic, own) for topic, own in zip(TOPICS, stamps, strict=True) if own)
            spans = "; ".join(f"{topic} from {own[0]} to {own[-1]} ns" for topic, own in own_stamps)
            raise DataError(
                f"The bag {self.path} must have images of one moment on all three topics, got none "
                f"({spans}); synchronise the cameras' clocks."
            )
        moments = [
            (firsts[0][rgb], firsts[1][depth], *([firsts[2][labels[rgb]]] if rgb in labels else []))
            for rgb, depth in matches
        ]
        if not any(moment[1].known for moment in moments):
            name = next(name for name, topic in self._sources.items() if topic == "/depth_raw")
            raise DataError(
                f"The bag {self.path} must have some depth below 1000 m on {name}, got none in any frame; "
                "check the depth camera and its units."
            )
        return moments

    def _firsts(self, topic: str) -> list[_Entry]:
        """Return the images of a topic by stamp; of images with the same stamp, the first recorded."""
        entries = self._entries[topic]
        firsts = {entry.stamp_ns: entry for entry in reversed(entries)}
        if len(firsts) == 1 < len(entries):
            raise DataError(
                f"The bag {self.path} must have images of several moments on {topic}, got {entries[0].stamp_ns} ns as "
                f"the stamp of all {len(entries)}: let the camera's driver set the stamps."
            )
        return sorted(firsts.values(), key=lambda entry: entry.stamp_ns)


def _close(reader: Reader) -> None:
    if reader.is_open:
        reader.close()


def read_bag(path: Path, *, size: tuple[int, int] | None = None, reading: Reading = SYNDRONE) -> BagReader:
    """Open a bag and check all of it.

    It may be any rosbag2 in MCAP or sqlite3 storage, compressed or not, in a file or several, with the topics or
    image_transport's versions of them. Images are paired by their stamps; labels may be missing.

    Args:
        path: the bag's folder, or its `.mcap` or `.db3` file.
        size: height and width in pixels to which frames are resampled; None for the size of the recording.
        reading: convention of the values of labels and depths.

    Raises:
        DataError: the bag is missing, unreadable or not closed, lacks topics or images of its metadata, has other
            encodings or several sizes, or its images do not belong together or have no known depth.
    """
    with translated(path):
        check_bag_path(path)
        reader = Reader(path.absolute())  # it is opened again, maybe from another folder
        reader.open()
        try:
            return BagReader(path, reader, size, reading)
        except BaseException:
            reader.close()
            raise


_LONE_PERIOD_NS: Final = 100_000_000
"""The assumed period of a single image."""

Stamps = npt.NDArray[np.int64]


def pair(first: Sequence[int], *others: Sequence[int]) -> list[tuple[int, ...]]:
    """Return for each moment, in order, the position of its stamp in each sensor's stamps.

    Two stamps match if each is the nearest to the other and they are less than half a period of the first
    sensor apart (its median distance of stamps); incomplete moments are left out. Stamps are in nanoseconds, and
    increase.

    >>> pair([0, 100, 200], [1, 198], [0, 100, 201])
    [(0, 0, 0), (2, 1, 2)]
    """
    if not first or not all(others):
        return []
    own = np.asarray(first, dtype=np.int64)
    period = float(np.median(np.diff(own))) if len(own) > 1 else _LONE_PERIOD_NS
    complete = np.ones(len(own), dtype=bool)
    columns = [np.arange(len(own))]
    for other in others:
        theirs = np.asarray(other, dtype=np.int64)
        nearest = _nearest(own, theirs)
        mutual = _nearest(theirs, own)[nearest] == columns[0]
        complete &= mutual & (2 * np.abs(theirs[nearest] - own) < period)
        columns.append(nearest)
    return [tuple(row) for row in np.stack(columns, axis=1)[complete].tolist()]


def _nearest(wanted: Stamps, given: Stamps) -> npt.NDArray[np.intp]:
    """Return for each wanted stamp the position of the nearest given stamp; of two as near, the earlier."""
    right = np.minimum(np.searchsorted(given, wanted), len(given) - 1)
    left = np.maximum(right - 1, 0)
    return np.where(wanted - given[left] <= given[right] - wanted, left, right)
