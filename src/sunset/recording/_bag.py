"""Messages as they are recorded: written to a rosbag2, read back and decoded."""

import hashlib
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from msgspec import Struct
from rosbags.interfaces import Connection
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer

from sunset.errors import InterfaceError, RecordError, shortage
from sunset.system_interfaces.msg import ImageDigest
from sunset_ros.interfaces import (
    Message,
    deserialize,
    get_message,
    message_definition,
    type_hash,
    type_name,
)

_FILE: Final = "messages.mcap"
_METADATA: Final = "metadata.yaml"

_DISTRO: Final = "jazzy"  # the first distribution whose bags have this form
_DIGEST: Final = "/digest"
"""The suffix of topics with digests; ROS 2 tools expect images on the images' own topics."""
BAG_FILES: Final = (_FILE, _METADATA)
"""The files of the bag in a record's folder."""


@dataclass(frozen=True, slots=True)
class RecordedMessage:
    """A message in a record.

    Attributes:
        topic: the full name of the topic.
        time_ns: when the message left its publisher, in nanoseconds on the experiment's clock.
        message: the content; in place of an image, a `system_interfaces/msg/ImageDigest`.
    """

    topic: str
    time_ns: int
    message: Message


class Payload(Struct, frozen=True, array_like=True, gc=False):
    """A message as a record stores it: with the name of its type, and its CDR."""

    topic: str
    type: str
    time_ns: int
    cdr: bytes

    def decoded(self) -> RecordedMessage:
        """Return the message.

        Raises:
            RecordError: the type is unknown, or the bytes do not fit it.
        """
        try:
            return RecordedMessage(self.topic, self.time_ns, deserialize(self.cdr, get_message(self.type)))
        except InterfaceError as error:
            raise RecordError(
                f"The message on {self.topic} at {self.time_ns} ns is damaged: {error}"
            ) from error


def digest_of(payloads: Iterable[Payload]) -> str:
    """Return the SHA-256 over topic, type, time and bytes of all messages in order, in hexadecimal."""
    digest = hashlib.sha256()
    for payload in payloads:
        head = f"{payload.topic} {payload.type} {payload.time_ns} {len(payload.cdr)}\n"
        digest.update(head.encode() + payload.cdr)
    return digest.hexdigest()


def _stored_topic(topic: str, name: str) -> str:
    """Return the name of a topic in a record's bag, given the name of its messages' type."""
    return topic + _DIGEST if name == type_name(ImageDigest) else topic


class BagWriter:
    """Writes messages into a bag's file, which appears in an existing folder when it is closed.

    The bytes depend on the messages, and on the versions of `rosbags` and its compressor. `files` are the file's name,
    and optionally the name of the bag's metadata.
    """

    def __init__(self, folder: Path, *files: str) -> None:
        # rosbags names the files after their folder, so this name must be constant
        self._folder, self._own, self._files = folder, folder / Path(files[0]).stem, files
        self._connections: dict[tuple[str, str], Connection] = {}
        self._writer = Writer(self._own, version=9, storage_plugin=StoragePlugin.MCAP)
        self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        self._writer.open()

    def add_topic(self, topic: str, name: str) -> Connection:
        """Add a topic for messages of the named type."""
        kind = get_message(name)
        connection = self._writer.add_connection(
            _stored_topic(topic, name),
            name,
            msgdef=message_definition(kind),
            rihs01=type_hash(kind),
        )  # without a profile of QoS, `ros2 bag play` offers the default
        self._connections[topic, name] = connection
        return connection

    def write(self, payload: Payload) -> None:
        """Write a message."""
        connection = self._connections.get((payload.topic, payload.type))
        connection = connection or self.add_topic(payload.topic, payload.type)
        self._writer.write(connection, payload.time_ns, payload.cdr)

    def close(self) -> None:
        """Complete the bag's file and move it to its folder."""
        self._writer.close()
        metadata = self._own / _METADATA
        text = metadata.read_text(encoding="utf-8")
        metadata.write_text(text.replace("ros_distro: rosbags", f"ros_distro: {_DISTRO}"), encoding="utf-8")
        for name in self._files:
            (self._own / name).rename(self._folder / name)
        shutil.rmtree(self._own)

    def abort(self) -> None:
        """Close the file if it is incomplete."""
        with suppress(OSError):
            self._writer.abort()


def write_bag(folder: Path, payloads: Sequence[Payload]) -> None:
    """Write messages, in order of time, as a rosbag2 into an existing folder."""
    bag = BagWriter(folder, *BAG_FILES)
    try:
        for topic, name in sorted({(payload.topic, payload.type) for payload in payloads}):
            bag.add_topic(topic, name)
        for payload in payloads:
            bag.write(payload)
        bag.close()
    finally:
        bag.abort()


def read_bag(folder: Path, name: str = _FILE) -> Iterator[Payload]:
    """Return the messages in a file of a record, in order of time.

    Raises:
        RecordError: the file is missing, truncated or damaged.
    """
    file = folder / name
    if not file.exists():
        raise RecordError(f"The record {folder} is incomplete: {name} is missing.")
    try:
        with Reader(file) as reader:
            for connection, time_ns, cdr in reader.messages():
                name = connection.msgtype
                topic = connection.topic.removesuffix(_stored_topic("", name))
                yield Payload(topic, name, time_ns, cdr)
    except Exception as error:  # the reader raises nearly anything on a damaged file
        if lacking := shortage(error):
            raise RecordError(f"The file {file} cannot be read now: {lacking}.") from error
        reason = str(error).strip().rstrip(".") or type(error).__name__
        raise RecordError(f"The file {file} is damaged: {reason}.") from error
