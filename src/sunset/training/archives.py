"""Files that torch writes are zip archives, whose checksums it does not look at when it reads them."""

import zipfile
import zlib
from pathlib import Path


def check_archive(path: Path, damaged: Exception) -> None:
    """Raise `damaged` unless a file is a zip archive whose entries have the content that their checksums say."""
    try:
        with zipfile.ZipFile(path) as archive:
            entry = archive.testzip()
    except (EOFError, RuntimeError, ValueError, zipfile.BadZipFile, zlib.error) as error:
        raise damaged from error
    if entry is not None:
        raise damaged
