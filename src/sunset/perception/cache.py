"""A file that stores the results of inference."""

import contextlib
import hashlib
import logging
import math
import os
import platform
import sqlite3
import struct
import tempfile
import threading
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt
import onnxruntime

from sunset.errors import DataError, OutputError
from sunset.files.compression import zstd
from sunset.files.image_digests import image_digest
from sunset.perception.card import Modality

_APPLICATION_ID: Final = 0x53554E53
"""Marks the SQLite files of this module ("SUNS")."""

_VERSION: Final = 3
_TABLE: Final = (
    "CREATE TABLE answers (key BLOB PRIMARY KEY, labels BLOB NOT NULL, entropy REAL NOT NULL, checksum BLOB NOT NULL) "
    "WITHOUT ROWID"
)
_REMEDY: Final = "--no-cache does without it, SUNSET_CACHE_DIR names another folder"
_WAIT_S: Final = 60.0
"""Time to wait for other processes that write at the same moment."""

_log: Final = logging.getLogger(__name__)

_inherited: list[sqlite3.Connection] = []
"""Connections of the parent process: closing them would release the parent's locks."""


class InferenceCache:
    """An SQLite file of inference results: labels and entropy.

    The key is a SHA-256 over the weights' checksum, the modality, the runtime's version, the processor's
    instruction sets (others may give other last bits) and the digests of the inputs, so no entry ever goes out of
    date, and the file can be deleted at any time. Several processes may share a file: it is in write-ahead mode and
    every entry is a transaction, so that a killed process leaves it intact. It must be on a local file system.

    Every entry has a checksum over its key and content. An entry that does not match, because another program
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
        features = f"{onnxruntime.__version__}|{platform.machine()}|{cv2.getCPUFeaturesLine()}"
        self._platform = hashlib.sha256(features.encode()).digest()
        if not self._path.exists():
            self._create()
        with self._lock, self._errors():
            self._connected()

    def __repr__(self) -> str:
        return f"InferenceCache({str(self._path)!r})"

    def __len__(self) -> int:
        with self._lock, self._errors():
            (count,) = self._connected().execute("SELECT COUNT(*) FROM answers").fetchone()
            return int(count)

    def key(self, weights: str, modality: Modality, inputs: Iterable[npt.NDArray[np.generic]]) -> bytes:
        """Return the key of an inference, 32 bytes, by the weights' checksum and its inputs."""
        digest = hashlib.sha256(self._platform)
        digest.update(f"{weights}|{modality.key}".encode())
        for array in inputs:
            digest.update(f"|{array.dtype.str}{array.shape}|".encode())
            digest.update(image_digest(array))
        return digest.digest()

    def get(self, key: bytes) -> tuple[npt.NDArray[np.uint8], float] | None:
        """Return flat labels (read-only) and entropy of an inference, or None without a valid entry.

        Raises:
            DataError: the file is damaged.
        """
        with self._lock, self._errors():
            query = "SELECT labels, entropy, checksum FROM answers WHERE key = ?"
            row = self._connected().execute(query, (key,)).fetchone()
            if row is not None and row[2] is not None and row[2] == _checksum(key, *row[:2]):
                return np.frombuffer(zstd.decompress(row[0]), dtype=np.uint8), row[1]
        if row is not None and not self._suspicious:
            self._suspicious = True
            _log.warning(
                "The inference cache %s holds an answer that was changed: it is computed anew.", self._path
            )
        return None

    def put(self, key: bytes, labels: npt.NDArray[np.uint8], entropy: float) -> None:
        """Store a result, in the place of an older entry; a result with the entropy NaN is not stored.

        Raises:
            OutputError: the file cannot be written.
            DataError: it is damaged.
        """
        if math.isnan(entropy):  # SQLite has none, and takes it for a missing value
            return
        entropy = float(entropy) + 0.0  # SQLite keeps no sign of zero
        packed = zstd.compress(labels.tobytes())
        with self._lock, self._errors():
            statement = "INSERT OR REPLACE INTO answers VALUES (?, ?, ?, ?)"
            self._connected().execute(statement, (key, packed, entropy, _checksum(key, packed, entropy)))

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
                f"The inference cache {self._path} cannot be made: {error.strerror}; {_REMEDY}."
            ) from error

    def _connected(self) -> sqlite3.Connection:
        """Return this process's connection, since SQLite's connections must not be used across a fork."""
        if self._connection is None or self._process != os.getpid():
            connection = sqlite3.connect(
                self._path, timeout=_WAIT_S, isolation_level=None, check_same_thread=False
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
                f"The file {self._path} is no inference cache of this version: choose another path, or "
                "delete it if it is not needed."
            )

    @contextlib.contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except (sqlite3.OperationalError, OSError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise OutputError(
                f"The inference cache {self._path} cannot be used: {reason}; {_REMEDY}."
            ) from error
        except (sqlite3.DatabaseError, zstd.ZstdError) as error:
            raise DataError(
                f"The inference cache {self._path} is damaged ({error}): delete it, it will be filled again."
            ) from error


def _checksum(key: bytes, labels: object, entropy: object) -> bytes | None:
    """Return the checksum of an entry; None if its values have other types than this module writes."""
    if not isinstance(labels, bytes) or not isinstance(entropy, float):
        return None
    return hashlib.sha256(b"".join((key, struct.pack("<d", entropy), labels))).digest()
