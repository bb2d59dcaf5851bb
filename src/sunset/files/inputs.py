"""Reading files that users name: regular files only, of a size that fits their kind.

A pipe or an endless device would otherwise block a command or fill its memory. The `strerror` of an `OSError` gives the
reason of a refusal, as the operating system's own errors do.
"""

import errno
import hashlib
import os
import stat
from io import BufferedReader
from pathlib import Path
from typing import Final

TEXT_BYTES: Final = 2**24
"""The limit of text files, such as cards, logs, plans and parameter files: 16 MiB."""


def open_regular(path: Path) -> BufferedReader:
    """Open a regular file for reading, without blocking."""
    try:
        file = open(path, "rb", opener=_opened)  # noqa: SIM115  the caller closes it; Path.open takes no opener
    except ValueError as error:  # a null byte
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path)) from error
    try:
        _check(path, os.fstat(file.fileno()).st_mode)
    except OSError:
        file.close()
        raise
    return file


def _opened(path: str, flags: int) -> int:
    return os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY)


def check_regular(path: Path) -> None:
    """Check that a path, which a library will open, is a regular file.

    It is not opened here: closing a database's file would release the locks of its users.
    """
    _check(path, path.stat().st_mode)


def _check(path: Path, mode: int) -> None:
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "it is a pipe, a device or a socket, not a regular file", str(path))


def read_bytes(path: Path, most: int = TEXT_BYTES) -> bytes:
    """Return the content of a regular file of at most `most` bytes.

    Raises:
        OSError: it cannot be read, is not a regular file, or is larger.
    """
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        if size > most:
            raise OSError(errno.EFBIG, f"it is larger than {most} bytes, the limit of its kind", str(path))
        return file.read(size)


def read_text(path: Path, most: int = TEXT_BYTES) -> str:
    """Return the text in a regular file of at most `most` bytes, in UTF-8."""
    return read_bytes(path, most).decode("utf-8")


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a regular file, in hexadecimal."""
    with open_regular(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
