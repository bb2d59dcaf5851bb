"""Zip files whose bytes depend on their content only, and the opening of zip files from strangers."""

import errno
import hashlib
import shutil
import stat
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import Final

from sunset.api.bundling.layout import CHECKSUMS_FILE
from sunset.errors import OutputError, RecordError
from sunset.files.inputs import check_regular, file_digest, read_text
from sunset.files.outputs import draft_of
from sunset_ros.texts import printable, shorten

_EPOCH: Final = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip file can store
_PERMISSIONS: Final = (stat.S_IFREG | 0o644) << 16
_UNIX: Final = 3
_METHODS: Final = frozenset({zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED})
_ENCRYPTED: Final = 0x1
_SMALL: Final = 2**28  # any bundle may expand to 256 MiB
_RATIO: Final = 50  # a larger bundle may expand to this multiple of its size; records are compressed already
_PIECE: Final = 2**20


def write_archive(out: Path, files: Mapping[str, Path | bytes]) -> str:
    """Write files, name → file or content, and their checksums into a zip file; return its SHA-256, in hexadecimal.

    Raises:
        OutputError: the zip file cannot be written.
    """
    sums = ""
    with draft_of(out, "bundle") as draft:
        with zipfile.ZipFile(draft, "w") as archive:
            for name, source in sorted(files.items()):
                content = source if isinstance(source, bytes) else source.read_bytes()
                sums += f"{hashlib.sha256(content).hexdigest()}  {name}\n"
                _add(archive, name, content)
            _add(archive, CHECKSUMS_FILE, sums.encode())
        return file_digest(draft)


def _add(archive: zipfile.ZipFile, name: str, content: bytes) -> None:
    info = zipfile.ZipInfo(name, _EPOCH)
    info.create_system, info.external_attr = _UNIX, _PERMISSIONS
    archive.writestr(info, content, zipfile.ZIP_DEFLATED, 9)


def extract_archive(path: Path, into: Path) -> None:
    """Unpack a zip file into an empty folder, and write nothing outside this folder.

    Raises:
        RecordError: the file cannot be read, is not a zip file, is damaged or encrypted, has a link or a file that
            leads out of the folder, or is excessively large.
        OutputError: the temporary folder lacks space.
    """
    with _translated(path), zipfile.ZipFile(path) as archive:
        infos = archive.infolist()
        _check(path, infos)
        for info in infos:
            if not info.is_dir():
                file = into / info.filename
                file.parent.mkdir(parents=True, exist_ok=True)
                with archive.open(info) as packed, file.open("xb") as unpacked:
                    shutil.copyfileobj(packed, unpacked, _PIECE)  # zipfile stops at the announced size


@contextmanager
def _translated(path: Path) -> Iterator[None]:
    """Turn each exception that a missing or damaged zip file causes into one sentence."""
    try:
        check_regular(path)
        yield
    except OSError as error:
        if error.errno in {errno.ENOSPC, errno.EDQUOT}:
            raise OutputError(
                f"The bundle {path} cannot be opened into a temporary folder: {error.strerror}; free some space, or "
                "name another folder with TMPDIR."
            ) from error
        raise RecordError(
            f"The bundle {path} cannot be read: {error.strerror}; name the zip file that 'sunset bundle' wrote."
        ) from error
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, ValueError) as error:
        reason = printable(str(error)).rstrip(".")
        raise RecordError(f"The bundle {path} is not a zip file, or is damaged: {reason}.") from error


def _check(path: Path, infos: Sequence[zipfile.ZipInfo]) -> None:
    """Check the directory of a zip file before any file is unpacked."""
    for info in infos:
        name = info.filename
        quoted = shorten(printable(name))
        parts = PurePosixPath(name).parts
        leads_out = not parts or name.startswith("/") or "\\" in name or ".." in parts
        if leads_out or not name.isprintable() or stat.S_ISLNK(info.external_attr >> 16):
            raise RecordError(
                f"The bundle {path} has a link, or a file that does not belong below its folder, {quoted!r}: it is "
                "not opened."
            )
        if info.flag_bits & _ENCRYPTED or info.compress_type not in _METHODS:
            raise RecordError(
                f"The bundle {path} is encrypted or compressed in another way, {quoted!r}: take the bundle as it was "
                "published."
            )
    size, limit = sum(info.file_size for info in infos), max(_SMALL, _RATIO * path.stat().st_size)
    if size > limit:
        raise RecordError(
            f"The bundle {path} would expand to {size} bytes, and a bundle of its size has at most {limit}: it is not "
            "opened."
        )


def differing_files(folder: Path) -> Iterator[str]:
    """Yield a sentence for each file of an opened bundle that does not match the list of checksums."""
    try:
        lines = read_text(folder / CHECKSUMS_FILE, _SMALL).splitlines()
    except (OSError, UnicodeDecodeError):
        yield f"{CHECKSUMS_FILE}: it is missing, or is not a text."
        return
    listed = {name: digest for digest, _, name in (line.partition("  ") for line in lines)}
    present = {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}
    for name in sorted(listed.keys() | (present - {CHECKSUMS_FILE})):
        if name not in present:
            yield f"{printable(name)}: it is missing, although {CHECKSUMS_FILE} lists it."
        elif name not in listed:
            yield f"{name}: {CHECKSUMS_FILE} does not list it."
        elif file_digest(folder / name) != listed[name]:
            yield f"{name}: it was changed, since its checksum differs from {CHECKSUMS_FILE}."
