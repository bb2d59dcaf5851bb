"""Payloads to a rosbag2 and back; the only file here that writes with `rosbags`."""

from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Final

from rosbags.interfaces import Connection
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.rosbag2.errors import WriterError

from sunset.bag_files import open_bag
from sunset.errors import OutputError, RecordError
from sunset.interfaces import get_message, message_definition, type_hash
from sunset.recording.values import Payload
from sunset.shortage import shortage

_NAME: Final = "messages"
_FILE: Final = f"{_NAME}.mcap"

BAG_FILES: Final = (_FILE, "metadata.yaml")
"""The files of the bag in a record's folder."""


def write_bag(folder: Path, payloads: Sequence[Payload]) -> None:
    """Write messages, in order of time, as a rosbag2 into an existing folder.

    The bytes depend on the messages, and on the versions of `rosbags` and its compressor; on neither the
    folder's name nor the clock.

    Raises:
        OutputError: the files cannot be written.
    """
    # the writer names its files after its folder, so it gets one whose name is always the same
    own = folder / _NAME
    try:
        writer = Writer(own, version=9, storage_plugin=StoragePlugin.MCAP)
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        with writer:
            connections = _connections(writer, payloads)
            for payload in payloads:
                writer.write(connections[payload.topic, payload.type], payload.time_ns, payload.cdr)
        for name in BAG_FILES:
            (own / name).rename(folder / name)
        own.rmdir()
    except WriterError as error:
        raise OutputError(f"The record in {folder} cannot be written: {error}.") from error


def _connections(writer: Writer, payloads: Sequence[Payload]) -> dict[tuple[str, str], Connection]:
    connections = {}
    for topic, name in sorted({(payload.topic, payload.type) for payload in payloads}):
        kind = get_message(name)
        connections[topic, name] = writer.add_connection(
            topic, name, msgdef=message_definition(kind), rihs01=type_hash(kind)
        )
    return connections


def read_bag(folder: Path) -> Iterator[Payload]:
    """Return the messages in a record's folder in order of time.

    Raises:
        RecordError: the file is missing, truncated or damaged.
    """
    file = folder / _FILE
    if not file.exists():
        raise RecordError(f"The record {folder} is incomplete: {_FILE} is missing.")
    try:
        with closing(open_bag(file)) as reader:
            for connection, time_ns, cdr in reader.messages():
                yield Payload(connection.topic, connection.msgtype, time_ns, cdr)
    except Exception as error:  # the reader raises nearly anything on a damaged file
        if lacking := shortage(error):
            raise RecordError(f"The file {file} cannot be read now: {lacking}.") from error
        reason = str(error).strip().rstrip(".") or type(error).__name__
        raise RecordError(f"The file {file} is damaged: {reason}.") from error
