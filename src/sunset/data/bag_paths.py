"""Files of bags: their checks, their errors, and their use by several threads and forked processes."""

import struct
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from copy import copy
from pathlib import Path
from typing import TYPE_CHECKING, Final

import apsw
from rosbags.interfaces import Connection
from rosbags.rosbag2 import Reader
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

from sunset.errors import DataError, shortage

if TYPE_CHECKING:
    from rosbags.rosbag2.reader import ReaderProtocol

REMEDY: Final = "record, copy or import it again"
_WITHOUT_METADATA: Final = (
    "remove its metadata.yaml and let 'ros2 bag reindex' make another, or give a file itself"
)
_REMEDIES: Final = {
    "etadata": _WITHOUT_METADATA,
    "Rosbag2 version": _WITHOUT_METADATA,
    "files are missing": "put them beside its metadata.yaml, or give a file itself",
    "not supported": "convert it with 'ros2 bag convert'",
    "Profile is not ros2": "give one of ROS 2",
    "File end": "its recorder was killed, or it was cut off later: complete it with 'mcap recover'",
}
"""Words in the library's message → a remedy other than `REMEDY`."""

_OF_DAMAGE: Final = (
    AssertionError,
    AttributeError,
    IndexError,
    OverflowError,
    TypeError,
    UnicodeDecodeError,
    struct.error,
)
"""Errors of Python in the library, whose texts do not describe the bag."""


def check_bag_path(path: Path) -> None:
    """Check that a path looks like a bag that its recorder has closed.

    Raises:
        DataError: it is missing, of another kind or not closed.
    """
    if not path.exists():
        raise DataError(f"There is no bag at {path}: give the folder or the file of a rosbag2 recording.")
    if path.is_dir():
        if not (path / "metadata.yaml").exists():
            raise DataError(
                f"The folder {path} must be a rosbag2 with a metadata.yaml, got none: 'ros2 bag reindex' makes it, or "
                "give a recording's file itself; of SynDrone's folders 'sunset data import --syndrone' makes a bag, "
                "and of pictures in rgb, depth and labels 'sunset data import --pictures'."
            )
    elif path.suffix == ".bag":
        raise DataError(f"The bag {path} must be of ROS 2, got one of ROS 1: 'rosbags-convert' converts it.")
    elif path.suffix not in {".mcap", ".db3"}:
        raise DataError(
            f"The bag {path} must be a rosbag2 folder or a file in .mcap or .db3, got {path.suffix!r}; "
            "give the folder of a compressed bag."
        )
    for log in sorted(path.glob("*.db3-wal")) if path.is_dir() else [Path(f"{path}-wal")]:
        if log.exists() and log.stat().st_size:
            file = str(log).removesuffix("-wal")
            raise DataError(
                f"The bag {file} must be closed, got one whose last messages are in {log.name}: when nothing "
                f"records it any more, 'sqlite3 {file} \"PRAGMA wal_checkpoint(TRUNCATE)\"' moves them."
            )


@contextmanager
def translated(path: Path, *, opened: bool = False) -> Iterator[None]:
    """Turn exceptions of the bag library about a broken file into a `DataError`.

    If the bag was `opened` before, the error says that it has changed since.
    """
    try:
        yield
    except DataError:
        raise
    except Exception as error:  # the library raises a dozen kinds on broken files, none documented
        if lacking := shortage(error):
            raise DataError(f"The bag {path} cannot be read now: {lacking}.") from error
        reason = str(error)
        if isinstance(error, OSError) and error.filename:
            reason = f"{Path(error.filename).name}: {error.strerror}"
        if not reason or isinstance(error, _OF_DAMAGE):
            reason = "it is damaged"
        reason = reason.splitlines()[0].partition(";")[0].rstrip(".")
        if opened:
            raise DataError(
                f"The bag {path} was closed, or changed after it was opened: {reason}; open it again."
            ) from error
        if isinstance(error, KeyError):
            raise DataError(
                f"The bag {path} cannot be read as a rosbag2: it lacks or has an unknown {error}; {REMEDY}, "
                "without topics that are not CDR."
            ) from error
        remedy = next((remedy for words, remedy in _REMEDIES.items() if words in reason), REMEDY)
        raise DataError(f"The bag {path} cannot be read as a rosbag2: {reason}; {remedy}.") from error


def connections_of(reader: Reader) -> list[Connection]:
    """Return the connections in a bag's metadata and in its files, which may differ in QoS."""
    bag = reader.storage
    files = bag.storages if isinstance(bag, DirectoryReader) else []
    return [*reader.connections, *(connection for file in files for connection in file.connections)]


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
