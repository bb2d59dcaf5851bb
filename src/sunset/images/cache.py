"""A file that stores what was computed from images."""

import contextlib
import hashlib
import logging
import os
import platform
import sqlite3
import tempfile
import threading
from collections.abc import Callable, Iterator
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Final

from sunset.errors import DataError, OutputError

_APPLICATION_ID: Final = 0x53554E53
"""Marks the SQLite files of this module ("SUNS")."""

_VERSION: Final = 4
_TABLE: Final = (
    "CREATE TABLE known (key BLOB PRIMARY KEY, value BLOB NOT NULL, checksum BLOB NOT NULL) WITHOUT ROWID"
)
_REMEDY: Final = "--no-cache does without it, SUNSET_CACHE_DIR names another folder"
_MOST_RECENT: Final = 20_000
"""How many values a process keeps in memory: those of some tens of runs."""
_WAIT_S: Final = 60.0
"""Time to wait for other processes that write at the same moment."""

_log: Final = logging.getLogger(__name__)

_inherited: list[sqlite3.Connection] = []
"""Connections of the parent process: closing them would release the parent's locks."""


class ImageCache:
    """An SQLite file of what was computed from images: key → value, both bytes.

    A key names all that its value depends on, so no entry ever goes out of date, and the file can be deleted at any
    time. Several processes may share a file: it is in write-ahead mode and every entry is a transaction, so that a
    killed process leaves it intact. It must be on a local file system.

    Every entry has a checksum over its key and value. An entry that does not match, because another program
    wrote it, is not used; the first of them is reported on stderr.

    Args:
        path: the file; it is made with its folder if it does not exist.

    Raises:
        OutputError: the file or its folder cannot be made or written.
        DataError: the file is something else, or damaged. It is never overwritten.
    """

    def __init__(self, path: Path | str) -> None:
        self._path = Path(path)
        self._lock = threading.Lock()
        self._connection: sqlite3.Connection | None = None
        self._process = 0
        self._suspicious = False
        self._recent: dict[bytes, bytes] = {}
        with self._lock, self._errors():
            self._connected()

    def __repr__(self) -> str:
        return f"ImageCache({str(self._path)!r})"

    def __len__(self) -> int:
        with self._lock, self._errors():
            (count,) = self._connected().execute("SELECT COUNT(*) FROM known").fetchone()
            return int(count)

    def look_up(self, key: bytes, compute: Callable[[], bytes]) -> bytes:
        """Return the value of a key; if there is none, compute and store it.

        Raises:
            DataError, OutputError: as `get` and `put`.
        """
        value = self.get(key)
        if value is None:
            value = compute()
            self.put(key, value)
        return value

    def get(self, key: bytes) -> bytes | None:
        """Return the value of a key, or None without a valid entry.

        Raises:
            DataError: the file is damaged.
        """
        known = self._recent.get(key)
        if known is not None:
            return known
        with self._lock, self._errors():
            query = "SELECT value, checksum FROM known WHERE key = ?"
            row = self._connected().execute(query, (key,)).fetchone()
        if row is None:
            return None
        value, checksum = row
        if isinstance(value, bytes) and checksum == _checksum(key, value):
            self._remember(key, value)
            return value
        if not self._suspicious:
            self._suspicious = True
            _log.warning("The cache %s holds a value that was changed: it is computed anew.", self._path)
        return None

    def put(self, key: bytes, value: bytes) -> None:
        """Store a value, in the place of an older one.

        Raises:
            OutputError: the file cannot be written.
            DataError: it is damaged.
        """
        with self._lock, self._errors():
            statement = "INSERT OR REPLACE INTO known VALUES (?, ?, ?)"
            self._connected().execute(statement, (key, value, _checksum(key, value)))
        self._remember(key, value)

    def _remember(self, key: bytes, value: bytes) -> None:
        if len(self._recent) == _MOST_RECENT:
            self._recent.clear()
        self._recent[key] = value

    def close(self) -> None:
        """Close the file; it is opened again when needed."""
        with self._lock:
            if self._connection is not None and self._process == os.getpid():
                self._connection.close()
                self._connection = None

    def __del__(self) -> None:
        if getattr(self, "_connection", None) is not None and os:  # not after modules were cleared at exit
            self.close()

    def _create(self) -> None:
        """Make an empty cache beside the path and link it there, so that other processes see a whole file."""
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(prefix=f".{self._path.name}.", dir=self._path.parent) as folder:
                draft = Path(folder) / self._path.name
                draft.touch(0o600)
                connection = sqlite3.connect(draft, isolation_level=None)
                with self._errors(), contextlib.closing(connection):
                    connection.execute(f"PRAGMA application_id = {_APPLICATION_ID}")
                    connection.execute(f"PRAGMA user_version = {_VERSION}")
                    connection.execute(_TABLE)
                    connection.execute("PRAGMA journal_mode = WAL")
                with contextlib.suppress(FileExistsError):  # another process was first
                    os.link(draft, self._path)
        except OSError as error:
            raise OutputError(
                f"The cache {self._path} cannot be made: {error.strerror}; {_REMEDY}."
            ) from error

    def _connected(self) -> sqlite3.Connection:
        """Return this process's connection, since SQLite's connections must not be used across a fork."""
        if self._connection is None or self._process != os.getpid():
            if not self._path.exists():  # it was deleted
                self._create()
            place = f"{self._path.absolute().as_uri()}?mode=rw"  # which makes no empty file
            connection = sqlite3.connect(
                place, uri=True, timeout=_WAIT_S, isolation_level=None, check_same_thread=False
            )
            try:
                self._check_version(connection)
                connection.execute("PRAGMA synchronous = NORMAL")  # a killed process loses nothing
            except BaseException:
                connection.close()
                raise
            if self._connection is not None:
                _inherited.append(self._connection)
            self._connection, self._process = connection, os.getpid()
        return self._connection

    def _check_version(self, connection: sqlite3.Connection) -> None:
        (application,) = connection.execute("PRAGMA application_id").fetchone()
        (version,) = connection.execute("PRAGMA user_version").fetchone()
        if (application, version) != (_APPLICATION_ID, _VERSION):
            raise DataError(
                f"The file {self._path} is no cache of this version: choose another path, or "
                "delete it if it is not needed."
            )

    @contextlib.contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except (sqlite3.OperationalError, OSError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise OutputError(f"The cache {self._path} cannot be used: {reason}; {_REMEDY}.") from error
        except sqlite3.DatabaseError as error:
            raise DataError(
                f"The cache {self._path} is damaged ({error}): delete it, it will be filled again."
            ) from error


def _checksum(key: bytes, value: bytes) -> bytes:
    return hashlib.blake2b(key + value, digest_size=8).digest()


@cache
def open_cache(path: Path) -> ImageCache:
    """Return the cache in a file, opened once a process."""
    return ImageCache(path)


@cache
def platform_features() -> str:
    """Return what the last bits of computed images may depend on: processor and libraries."""
    import cv2  # noqa: PLC0415  a slow import, which the readers of records do without

    return f"{platform.machine()}|{cv2.getCPUFeaturesLine()}|{cv2.__version__}|{version('numpy')}"
