"""Access to users' rosbag2 recordings, without blocking or unbounded decompression.

Compressed content is expanded to at most `LARGEST` bytes or, if that is more, `RATIO` times its size, which no
recording reaches.
"""

import logging
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager, suppress
from copy import copy
from pathlib import Path
from struct import unpack
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import apsw
from rosbags.interfaces import Connection
from rosbags.rosbag2 import Reader, storage_mcap
from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.metadata import ReaderMetadata
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_mcap import ChunkInfo, McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

from sunset.files.compression import zstd
from sunset.files.inputs import check_regular, open_regular, read_bytes

if TYPE_CHECKING:
    from rosbags.rosbag2.reader import ReaderProtocol

LARGEST: Final = 2**28
"""256 MiB: an image of 8192 x 8192 pixels in four channels."""

RATIO: Final = 1000

_PIECE: Final = 2**20
_METADATA: Final = "metadata.yaml"
_NO_STORAGE: Final = re.compile(r"""^\s*storage_identifier:\s*(""|'')?\s*$""", re.MULTILINE)
"""The line that 'ros2 bag reindex' of Humble writes."""
_HEAD: Final = 9
"""Bytes of the kind and the length before a record of MCAP."""
_CHUNK: Final = 0x06
_DATA_END: Final = 0x0F

_log: Final = logging.getLogger(__name__)


def connections_of(reader: Reader) -> list[Connection]:
    """Return the connections in a bag's metadata and in its files, which may differ in QoS."""
    bag = reader.storage
    files = bag.storages if isinstance(bag, DirectoryReader) else []
    return [*reader.connections, *(connection for file in files for connection in file.connections)]


class _Mcap(McapReader):
    """An MCAP file of a flight, which may lack its end, or the message indexes that the library needs."""

    def open(self) -> None:
        try:
            super().open()
            if all(chunk.channel_count for chunk in self.chunks):
                return
        except ReaderError:
            if not self.data_start:
                raise
            self.bio = self.path.open("rb")
            _log.warning(
                "The file %s lacks its end: its recorder was killed, or it was cut off later. It is read up to its "
                "last whole chunk.",
                self.path,
            )
        try:
            self._scan()
        except BaseException:
            self.close()
            raise

    def _scan(self) -> None:
        """Index the complete chunks, and read their content."""
        assert self.bio is not None  # noqa: S101  it is open
        size, place, chunks = Path(str(self.path)).stat().st_size, self.data_start, []
        while place + _HEAD <= size:
            self.bio.seek(place)
            kind, length = unpack("<BQ", self.bio.read(_HEAD))
            if kind == _DATA_END or place + _HEAD + length > size:
                break
            if kind == _CHUNK:
                start, end, expanded, _ = unpack("<QQQI", self.bio.read(28))
                packing = storage_mcap.read_string(self.bio)
                (packed,) = unpack("<Q", self.bio.read(8))
                chunks.append(
                    ChunkInfo(start, end, place, _HEAD + length, {}, 0, packing, packed, expanded, {})
                )
            place += _HEAD + length
        _check(size, (chunk.uncompressed_size for chunk in chunks))
        self.data_end = place
        self.meta_scan()
        counts = self.statistics.channel_message_counts if self.statistics else {}
        self.chunks = [chunk._replace(channel_count=counts) for chunk in chunks]
        self.connections = [
            connection._replace(msgcount=counts.get(connection.id, 0)) for connection in self.connections
        ]


class _Folder(DirectoryReader):
    """A bag's folder; without usable metadata, its files are searched for connections."""

    STORAGE_PLUGINS: "Mapping[str, type[ReaderProtocol]]" = MappingProxyType(
        {"mcap": _Mcap, "sqlite3": Sqlite3Reader}
    )

    def __init__(self, path: Path) -> None:
        with suppress(FileNotFoundError):  # of the metadata
            super().__init__(path)
        self._path = path

    def open(self) -> None:
        metadata = self._path / _METADATA
        if metadata.exists() and not _NO_STORAGE.search(metadata.read_text(encoding="utf-8")):
            super().open()
            return
        self.storages, self.files = [], []
        self.metadata = ReaderMetadata(0, 2**63 - 1, 0, 0, None, None, None, None)
        with ExitStack() as stack:
            for path in files_of_recording(self._path):
                file = _FlightBag.STORAGE_PLUGINS[path.suffix](path)
                file.open()
                stack.callback(file.close)
                self.storages.append(file)
            self.stack = stack.pop_all()
        self.connections = [connection for file in self.storages for connection in file.connections]


class _FlightBag(Reader):
    """A flight's bag from any recorder."""

    STORAGE_PLUGINS: "Mapping[str, type[ReaderProtocol]]" = MappingProxyType(
        {"dir": _Folder, ".mcap": _Mcap, ".db3": Sqlite3Reader}
    )


def files_of_recording(folder: Path) -> list[Path]:
    """Return the files of a folder's only recording: a file, or NAME_0, NAME_1 and so on; else an empty list."""
    files = [path for path in folder.iterdir() if path.suffix in _FlightBag.STORAGE_PLUGINS]
    parts = {path.name: path for path in files}
    for first in files if len(files) > 1 else ():
        if first.stem.endswith("_0"):
            names = [f"{first.stem[:-1]}{number}{first.suffix}" for number in range(len(files))]
            return [parts[name] for name in names] if parts.keys() == {*names} else []
    return files if len(files) == 1 else []


def open_bag(path: Path, *, cut_off: bool = False) -> Reader:
    """Open a bag's folder or file. Separately compressed messages are not expanded: see `expand`.

    Args:
        path: the folder or file.
        cut_off: whether an MCAP file may lack its end, which logs a warning, and a folder its metadata.

    Raises:
        OSError: a file cannot be read, or is not a regular file.
        ValueError: it would expand to more than a recording.
        Exception: of nearly any kind on a damaged file, since the library does not document its exceptions.
    """
    _check_files(path)
    reader = (_FlightBag if cut_off else Reader)(path)
    reader.open()
    try:
        bag = reader.storage
        if isinstance(bag, DirectoryReader) and bag.metadata.compression_mode == "message":
            bag.metadata = bag.metadata._replace(compression_mode=None)  # which would expand without bounds
        for file in bag.storages if isinstance(bag, DirectoryReader) else [bag]:
            if isinstance(file, McapReader | Sqlite3Reader):
                file.path = Path(str(file.path)).absolute()  # it is opened again, maybe from another folder
            if isinstance(file, McapReader):
                _check(file.path.stat().st_size, (chunk.uncompressed_size for chunk in file.chunks))
            elif isinstance(file, Sqlite3Reader) and file.dbconn is not None:
                file.dbconn.limit(apsw.SQLITE_LIMIT_LENGTH, LARGEST)
    except BaseException:
        reader.close()
        raise
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
            own.dbconn.limit(apsw.SQLITE_LIMIT_LENGTH, LARGEST)
            yield own


def expand(packed: bytes | memoryview, most: int | None = None) -> bytes:
    """Return the content of zstd frames.

    Args:
        packed: a frame, or several.
        most: announced bytes of the content; None for the limit of a recording.

    Raises:
        ValueError: the content has more bytes.
        ZstdError: it is damaged.
    """
    limit = _limit(len(packed))
    limit = limit if most is None else min(most, limit)
    parts, left, rest = [], limit, bytes(packed)
    while rest:
        frame = zstd.ZstdDecompressor()
        parts.append(frame.decompress(rest, max_length=left + 1))
        left -= len(parts[-1])
        if left < 0:
            raise _bomb_error(limit)
        if not frame.eof:
            raise ValueError("it is packed with zstd and ends before its content does")
        rest = frame.unused_data
    return b"".join(parts)


# The library expands chunks of MCAP files with this function and their announced size.
storage_mcap.DECOMPRESSORS["zstd"] = expand


def _check_files(path: Path) -> None:
    """Check the files of a bag before they are opened or unpacked."""
    for file in sorted(path.iterdir()) if path.is_dir() else [path]:
        if file.name == _METADATA:
            read_bytes(file)
        elif file.suffix == ".zstd":
            _check(file.stat().st_size, _pieces(file))
        elif not file.is_dir():
            check_regular(file)


def _pieces(file: Path) -> Iterable[int]:
    """Yield the sizes of the pieces of a packed file's content; damage is noticed when it is unpacked."""
    with open_regular(file) as packed, zstd.open(packed) as content, suppress(EOFError, zstd.ZstdError):
        while piece := content.read(_PIECE):
            yield len(piece)


def _check(packed: int, expanded: Iterable[int]) -> None:
    left = _limit(packed)
    for size in expanded:
        left -= size
        if left < 0:
            raise _bomb_error(_limit(packed))


def _limit(packed: int) -> int:
    return max(LARGEST, RATIO * packed)


def _bomb_error(limit: int) -> ValueError:
    return ValueError(f"it would expand to more than {limit} bytes, more than any recording of its size")
