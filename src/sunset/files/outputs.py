"""Writing files and folders completely or not at all."""

import errno
import hashlib
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from sunset.errors import OutputError

_LONGEST: Final = 100


def folder_name(text: str) -> str:
    """Return a text as a folder's name; distinct texts have distinct names."""
    slug = re.sub(r"[^A-Za-z0-9_+.-]+", "-", text).strip("-.")[:_LONGEST]
    return slug if slug == text else f"{slug}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"


def make_folder(folder: Path) -> None:
    """Make a folder and its parents; it may exist."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"The folder {folder} cannot be made: {error.strerror}; name another one."
        ) from error


def unwritable(label: str, error: OSError) -> OutputError:
    """Return an error with the reason why something cannot be written, and the remedy.

    >>> unwritable("The page", OSError(errno.ENOSPC, "No space left on device")).args[0]
    'The page cannot be written: No space left on device; free some space or name another place.'
    """
    is_full = error.errno in {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
    remedy = f"{'free some space or ' if is_full else ''}name another place"
    return OutputError(f"{label} cannot be written: {error.strerror or error}; {remedy}.")


def flush(path: Path) -> None:
    """Write a file, or all files in a folder, to the disk, so that they are complete after a power cut."""
    for file in path.rglob("*") if path.is_dir() else [path]:
        if file.is_file():
            with file.open("rb") as opened:
                os.fsync(opened.fileno())


@contextmanager
def draft_of(file: Path, kind: str = "file") -> Iterator[Path]:
    """Give a temporary path for writing a file, and rename it at the end, unless an exception is raised.

    Args:
        file: the file, which is replaced; its folder must exist.
        kind: its kind, for messages.
    """
    if not file.name:
        raise OutputError(f"A {kind} to write to must have a name, got {file}.")
    draft = file.with_name(f".{file.name}.{os.getpid()}.part")
    try:
        yield draft
        flush(draft)
        draft.replace(file)
    except OSError as error:
        raise unwritable(f"The {kind} {file}", error) from error
    finally:
        with suppress(OSError):
            draft.unlink()


@contextmanager
def draft_of_folder(folder: Path, kind: str = "folder") -> Iterator[Path]:
    """Give a temporary folder, and rename it at the end, unless an exception is raised.

    Args:
        folder: must not exist, or be empty.
        kind: its kind, for messages.

    Raises:
        OutputError: it exists and is not empty, or cannot be written.
    """
    place = folder.absolute()
    try:
        if place.exists() and (not place.is_dir() or any(place.iterdir())):
            raise OutputError(f"The {kind} {folder} exists already; remove it or name another folder.")
        draft = place.with_name(f".{place.name}.{os.getpid()}.part")
        draft.mkdir(parents=True)
        try:
            yield draft
            draft.rename(place)
        finally:
            shutil.rmtree(draft, ignore_errors=True)
    except OSError as error:
        raise unwritable(f"The {kind} {folder}", error) from error


def write_text(file: Path, text: str, kind: str = "file") -> None:
    """Write a text file, as `draft_of`."""
    with draft_of(file, kind) as draft:
        draft.write_text(text, encoding="utf-8")
