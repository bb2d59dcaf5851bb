"""Access to rosbag2 recordings, also from several threads and forked processes."""

from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from copy import copy
from pathlib import Path
from typing import TYPE_CHECKING

import apsw
from rosbags.interfaces import Connection
from rosbags.rosbag2 import Reader
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

if TYPE_CHECKING:
    from rosbags.rosbag2.reader import ReaderProtocol


def connections_of(reader: Reader) -> list[Connection]:
    """Return the connections in a bag's metadata and in its files, which may differ in QoS."""
    bag = reader.storage
    files = bag.storages if isinstance(bag, DirectoryReader) else []
    return [*reader.connections, *(connection for file in files for connection in file.connections)]


def open_bag(path: Path) -> Reader:
    """Open a bag's folder or file.

    Raises:
        Exception: of nearly any kind on a damaged file, since the library does not document its exceptions.
    """
    reader = Reader(path.absolute())  # it is opened again, maybe from another folder
    reader.open()
    return reader


@contextmanager
def reopened(bag: Reader) -> Iterator[Reader]:
    """Open the files of an open bag again, for a thread or forked process that must not share their positions.

    Raises:
        OSError: a file was removed.
    """
    own = copy(bag)
    with ExitStack() as files:
        if isinstance(bag.storage, DirectoryReader):
            own.storage = copy(bag.storage)
            own.storage.storages = [files.enter_context(_reopened(file)) for file in bag.storage.storages]
        else:
            own.storage = files.enter_context(_reopened(bag.storage))
        yield own


@contextmanager
def _reopened(file: "ReaderProtocol") -> "Iterator[ReaderProtocol]":
    own = copy(file)
    if isinstance(own, McapReader):
        with own.path.open("rb") as own.bio:
            yield own
    elif isinstance(own, Sqlite3Reader):
        flags = apsw.SQLITE_OPEN_READONLY | apsw.SQLITE_OPEN_URI
        with closing(apsw.Connection(f"file:{own.path}?immutable=1", flags=flags)) as own.dbconn:
            yield own
