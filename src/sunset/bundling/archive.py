"""Writing zip files whose bytes depend on their content only, and opening those of strangers."""

import hashlib
import os
import re
import shutil
import stat
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import Final

from sunset.bundling.layout import CHECKSUMS_FILE
from sunset.errors import OutputError, RecordError
from sunset.input_files import check_regular, file_digest, read_text
from sunset.output_files import draft_of
from sunset.texts import counted, printable, shorten, shown

_EPOCH: Final = (1980, 1, 1, 0, 0, 0)
"""The earliest time that a zip file can give: it says nothing, so that the same files give the same bytes."""
_PERMISSIONS: Final = (stat.S_IFREG | 0o644) << 16
_UNIX: Final = 3
_METHODS: Final = frozenset({zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED})
_ENCRYPTED: Final = 0x1
_SMALL: Final = 2**28
"""256 MiB: so much may any bundle expand to."""
_RATIO: Final = 50
"""A larger one may expand to so many times its size; records are compressed already."""
_MOST: Final = 100_000
"""More files than any bundle has: three for each of ten thousand runs, and sources."""
_LONGEST: Final = 255
"""Bytes that a part of a name may have."""
_PATH: Final = 2048
"""Characters that a name may have."""
_NOTHING: Final = 2
"""Bytes that nothing takes, compressed."""
_PIECE: Final = 2**20
_ENTRY: Final = re.compile("(?P<digest>[0-9a-f]{64})  (?P<name>.+)")
"""A line of the list of checksums."""

_END: Final = b"PK\x05\x06" + bytes(18)
"""The last bytes of a zip file without a comment begin and end like this."""


def check_new(out: Path) -> None:
    """Check that there is no such file.

    Raises:
        OutputError: there is.
    """
    if out.exists():
        raise OutputError(f"The file {out} exists already: remove it, or name another one with --out.")


def write_archive(out: Path, files: Mapping[str, Path | bytes]) -> str:
    """Write files, and the list of their checksums, into a new zip file; return its SHA-256, in hexadecimal.

    Args:
        out: the file, which appears when it is complete.
        files: name in it → a file, or its content.

    Raises:
        OutputError: it exists, or cannot be written.
        RecordError: a file cannot be read.
    """
    check_new(out)
    sums = ""
    with draft_of(out, "bundle") as draft:
        with zipfile.ZipFile(draft, "w") as archive:
            for name in sorted(files):
                content = _content(files[name])
                sums += f"{hashlib.sha256(content).hexdigest()}  {name}\n"
                _add(archive, name, content)
            _add(archive, CHECKSUMS_FILE, sums.encode())
        return file_digest(draft)


def _content(source: Path | bytes) -> bytes:
    try:
        return source if isinstance(source, bytes) else source.read_bytes()
    except OSError as error:
        raise RecordError(f"The file {source!s} cannot be read: {error.strerror}.") from error


def _add(archive: zipfile.ZipFile, name: str, content: bytes) -> None:
    info = zipfile.ZipInfo(name, _EPOCH)
    info.create_system, info.external_attr = _UNIX, _PERMISSIONS
    archive.writestr(info, content, zipfile.ZIP_DEFLATED, 9)


def extract_archive(path: Path, into: Path) -> None:
    """Write the files of a zip file into an empty folder, and nothing outside of it.

    Raises:
        RecordError: there is no such file, it is not a zip file, is damaged or encrypted, has a file that does not
            belong below the folder, or expands to more than it says or than a bundle does.
    """
    try:
        check_regular(path)
    except FileNotFoundError as error:
        raise RecordError(f"There is no bundle {path}: name a file that 'sunset bundle' wrote.") from error
    except IsADirectoryError as error:
        raise RecordError(
            f"The bundle {path} is a folder: name the zip file that 'sunset bundle' wrote."
        ) from error
    except OSError as error:
        raise RecordError(f"The bundle {path} cannot be read: {error.strerror}.") from error
    with _translated(path), zipfile.ZipFile(path) as archive:
        infos = archive.infolist()
        _check(path, infos)
        for info in infos:
            if info.is_dir():
                continue
            file = into / info.filename
            file.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(info) as packed, file.open("xb") as unpacked:
                shutil.copyfileobj(
                    packed, unpacked, _PIECE
                )  # not more than the announced size: zipfile sees to it


@contextmanager
def _translated(path: Path) -> Iterator[None]:
    """Turn what reading a damaged zip file raises into one sentence."""
    try:
        yield
    except zipfile.BadZipFile as error:
        reason = printable(str(error)).rstrip(".")
        raise RecordError(f"The bundle {path} is not a zip file, or a damaged one: {reason}.") from error
    except (zlib.error, EOFError, NotImplementedError, UnicodeDecodeError, ValueError) as error:
        raise RecordError(f"The bundle {path} is damaged: {printable(str(error)).rstrip('.')}.") from error
    except (FileExistsError, NotADirectoryError, IsADirectoryError) as error:
        raise RecordError(
            f"The bundle {path} has two files of one name: take the bundle as it was published."
        ) from error
    except OSError as error:
        raise OutputError(
            f"The bundle {path} cannot be opened into a temporary folder: {error.strerror or error}; free some space, "
            "or name another folder with TMPDIR."
        ) from error


def _check(path: Path, infos: list[zipfile.ZipInfo]) -> None:
    """Check what a zip file says of its files before any of them is unpacked."""
    if len(infos) > _MOST:
        raise RecordError(
            f"The bundle {path} has {len(infos)} files, and none has more than {_MOST}: it is not opened."
        )
    with path.open("rb") as file:
        file.seek(-len(_END), os.SEEK_END)
        end = file.read()
    if min((info.header_offset for info in infos), default=0) or end[:4] != _END[:4] or end[-2:] != _END[-2:]:
        raise RecordError(
            f"The bundle {path} has bytes before or after the zip file in it: take the bundle as it was published."
        )
    for info in infos:
        name = info.filename
        quoted = shorten(printable(name))
        parts = PurePosixPath(name).parts
        long = len(name) > _PATH or any(len(part.encode()) > _LONGEST for part in parts)
        if (
            not parts
            or long
            or name.startswith("/")
            or "\\" in name
            or ".." in parts
            or not name.isprintable()
        ):
            raise RecordError(
                f"The bundle {path} has a file that does not belong below its folder, {quoted!r}: it is not opened."
            )
        if info.is_dir() and (info.file_size or info.compress_size > _NOTHING):
            raise RecordError(
                f"The bundle {path} has data in the entry of a folder, {quoted!r}, where none is looked for: it is not "
                "opened."
            )
        if stat.S_ISLNK(info.external_attr >> 16):
            raise RecordError(
                f"The bundle {path} has a link, {quoted!r}, and not only files: it is not opened."
            )
        if info.flag_bits & _ENCRYPTED:
            raise RecordError(
                f"The bundle {path} is encrypted: name one that can be read without a password."
            )
        if info.compress_type not in _METHODS:
            raise RecordError(
                f"The bundle {path} is packed in a way that bundles are not, {quoted!r} with method "
                f"{info.compress_type}: take the bundle as it was published."
            )
    size, limit = sum(info.file_size for info in infos), max(_SMALL, _RATIO * path.stat().st_size)
    if size > limit:
        raise RecordError(
            f"The bundle {path} would expand to {size} bytes, and one of its size has at most {limit}: it is not "
            "opened."
        )


def differing_files(folder: Path) -> Iterator[str]:
    """Yield a sentence for each file of an opened bundle that is not as the list of checksums says."""
    try:
        lines = read_text(folder / CHECKSUMS_FILE, _SMALL).splitlines()
    except (OSError, UnicodeDecodeError):
        yield f"{CHECKSUMS_FILE}: it is missing, or not a text, so that nothing says what the files were."
        return
    listed: dict[str, str] = {}
    for number, line in enumerate(lines, 1):
        entry = _ENTRY.fullmatch(line)
        if entry is None:
            yield f"{CHECKSUMS_FILE}: line {number} is {shown(printable(line))}, which is not a checksum and a file."
        elif entry["name"] in listed:
            yield f"{CHECKSUMS_FILE}: line {number} names {printable(entry['name'])}, which a line before it does, too."
        else:
            listed[entry["name"]] = entry["digest"]
    found = {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}
    for name in sorted(listed.keys() - found):
        yield f"{printable(name)}: it is missing, and stands in {CHECKSUMS_FILE}."
    for name in sorted(found - listed.keys() - {CHECKSUMS_FILE}):
        yield f"{name}: it does not stand in {CHECKSUMS_FILE}."
    for name in sorted(found & listed.keys()):
        if file_digest(folder / name) != listed[name]:
            yield f"{name}: it was changed, since its checksum is not that in {CHECKSUMS_FILE}."


def count_files(folder: Path) -> str:
    """Return how many files an opened bundle has, in words."""
    return counted(sum(1 for file in folder.rglob("*") if file.is_file()), "file")
