"""Writing files so that a reader never sees half of one."""

import hashlib
import os
import re
from pathlib import Path
from typing import Final

from sunset.errors import OutputError

_LONGEST: Final = 100


def folder_name(text: str) -> str:
    """Return a text as a folder's name; distinct texts have distinct names."""
    slug = re.sub(r"[^A-Za-z0-9_+.-]+", "-", text).strip("-.")[:_LONGEST]
    return slug if slug == text else f"{slug}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"


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
