"""Checksums of the zip archives that torch writes; torch does not check them when it reads."""

import zipfile
import zlib
from pathlib import Path


def check_archive(path: Path, damaged: Exception) -> None:
    """Raise `damaged` unless a file is a zip archive whose entries match their checksums."""
    try:
        with zipfile.ZipFile(path) as archive:
            entry = archive.testzip()
    except (EOFError, RuntimeError, ValueError, zipfile.BadZipFile, zlib.error) as error:
        raise damaged from error
    if entry is not None:
        raise damaged
