"""Writing files so that a reader never sees half of one."""

import os
from pathlib import Path

from sunset.errors import OutputError


def make_folder(folder: Path) -> None:
    """Make a folder and its parents; it may exist.

    Raises:
        OutputError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"The folder {folder} cannot be made: {error.strerror}; name another one."
        ) from error


def write_text(file: Path, text: str) -> None:
    """Write a text file under a temporary name, then rename it.

    Raises:
        OutputError: it cannot be written.
    """
    if not file.name:
        raise OutputError(f"A file to write to must have a name, got {file}.")
    temporary = file.with_name(f".{file.name}.{os.getpid()}.part")
    try:
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(file)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise OutputError(
            f"The file {file} cannot be written: {error.strerror}; free some space or write elsewhere."
        ) from error
