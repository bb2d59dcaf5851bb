"""Checks of a bag's path, and the errors of a bag that cannot be read."""

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Final

from sunset.errors import DataError, OutputError, shortage
from sunset.files.bags import files_of_recording
from sunset.files.inputs import open_regular

REMEDY: Final = "record, copy or import it again"
_WITHOUT_METADATA: Final = "remove its metadata.yaml: without one, it is read by what its files say"
_REMEDIES: Final = MappingProxyType(
    {
        "etadata": _WITHOUT_METADATA,
        "Rosbag2 version": _WITHOUT_METADATA,
        "files are missing": "put them beside its metadata.yaml, or give a file itself",
        "not supported": "convert it with 'ros2 bag convert'",
        "Profile is not ros2": "give one of ROS 2",
    }
)
"""Words in the library's message → a remedy other than `REMEDY`."""

STORAGES: Final = {".mcap": "mcap", ".db3": "sqlite3"}
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
    """Check that a path looks like a bag whose files are whole.

    Raises:
        DataError: it is missing, of another kind, truncated, not closed by its recorder, or in sqlite3 under a path
            that sqlite3 cannot open.
    """
    if not path.exists():
        raise DataError(f"There is no bag at {path}: give the folder or the file of a rosbag2 recording.")
    if path.is_dir():
        if not (path / "metadata.yaml").exists() and not files_of_recording(path):
            raise DataError(
                f"The folder {path} must be a rosbag2 with a metadata.yaml, or with the .mcap or .db3 files of one "
                "recording, got neither: give the file of one itself; of SynDrone's folders 'sunset data import "
                "--syndrone' makes a bag, and of pictures in rgb, depth and labels 'sunset data import --pictures'."
            )
    elif path.suffix == ".bag":
        raise DataError(f"The bag {path} must be of ROS 2, got one of ROS 1: 'rosbags-convert' converts it.")
    elif path.suffix not in STORAGES:
        raise DataError(
            f"The bag {path} must be a rosbag2 folder or a file in .mcap or .db3, got {path.suffix!r}; "
            "give the folder of a compressed bag."
        )
    for file in sorted(path.glob("*.db3")) if path.is_dir() else [path]:
        if file.suffix == ".db3":
            check_uri(file, DataError)
            _check_closed(file)
            _check_whole(file, path)


def check_uri(path: Path, error: type[DataError | OutputError]) -> None:
    """Check a path for sqlite3, which takes it as a URI; raise `error` if it would open another file."""
    if set("#?%") & set(str(path.absolute())):
        raise error(
            f"A bag in sqlite3 must lie under a path without #, ? and %, got {path.absolute()}: rename it, "
            "or use MCAP."
        )


def _check_closed(file: Path) -> None:
    """Check that all messages of a sqlite3 file are in it, and none in its write-ahead log, which is not read."""
    log = Path(f"{file}-wal")
    if log.exists() and log.stat().st_size:
        raise DataError(
            f"The bag {file} must be closed, got one whose last messages are in {log.name}: when nothing "
            f"records it any more, 'sqlite3 {file} \"PRAGMA wal_checkpoint(TRUNCATE)\"' moves them."
        )


def _check_whole(file: Path, bag: Path) -> None:
    """Check that a sqlite3 file is as long as its header says, since sqlite3 notices a missing end only on reading it.

    The header: https://www.sqlite.org/fileformat.html, section 1.3.
    """
    try:
        with open_regular(file) as opened:
            header = opened.read(100)
    except OSError as error:
        raise DataError(f"The bag {bag} cannot be read: {error.strerror}.") from error
    if header[24:28] != header[92:96]:
        return  # its writer did not count the pages
    page, pages = int.from_bytes(header[16:18]), int.from_bytes(header[28:32])
    page = 65536 if page == 1 else page  # the largest size does not fit into two bytes
    expected, got = page * pages, file.stat().st_size
    if got < expected:
        raise DataError(
            f"The bag {bag} cannot be read as a rosbag2: {file.name} is cut off after {got:,} of {expected:,} bytes; "
            "record, copy or import it again."
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
