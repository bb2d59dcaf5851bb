"""Reading files that users name: regular files only, of a size that fits their kind.

A pipe or an endless device would otherwise block a command or fill its memory. The `strerror` of an `OSError` gives the
reason of a refusal, as the operating system's own errors do.
"""

import errno
import hashlib
import os
import stat
from pathlib import Path
from typing import Final

TEXT_BYTES: Final = 2**24
"""The limit of text files, such as cards, logs, plans and parameter files: 16 MiB."""


def check_regular(path: Path) -> None:
    """Check that a path is a regular file."""
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "it is a pipe, a device or a socket, not a regular file", str(path))


def read_bytes(path: Path, most: int = TEXT_BYTES) -> bytes:
    """Return the content of a regular file of at most `most` bytes.

    Raises:
        OSError: it cannot be read, is not a regular file, or is larger.
    """
    check_regular(path)
    if path.stat().st_size > most:
        raise OSError(errno.EFBIG, f"it is larger than {most} bytes, the limit of its kind", str(path))
    return path.read_bytes()


def read_text(path: Path, most: int = TEXT_BYTES) -> str:
    """Return the text in a regular file of at most `most` bytes, in UTF-8."""
    return read_bytes(path, most).decode("utf-8")


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a regular file, in hexadecimal."""
    check_regular(path)
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
