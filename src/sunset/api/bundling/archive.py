"""The zip file of a bundle: the names of its files, its bytes, which depend on its content only, and its checksums."""

import errno
import hashlib
import stat
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from sunset.errors import OutputError, RecordError
from sunset.files.inputs import check_regular, file_digest
from sunset.files.outputs import draft_of
from sunset_ros.texts import printable

MANIFEST_FILE: Final = "bundle.json"
CHECKSUMS_FILE: Final = "SHA256SUMS"
CITATION_FILE: Final = "CITATION.cff"
CRATE_FILE: Final = "ro-crate-metadata.json"
README_FILE: Final = "README.md"
REPORT_FILE: Final = "report.txt"
CARD_FILE: Final = "model/card.json"
CAMPAIGN: Final = "campaign"
"""The folder of the plan and the runs."""
SCENARIOS: Final = "scenarios"
"""The folder of the scenarios of all runs, by suite, and of a split."""
SPLIT: Final = f"{SCENARIOS}/split"

_EPOCH: Final = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip file can store
_PERMISSIONS: Final = (stat.S_IFREG | 0o644) << 16
_UNIX: Final = 3


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
    """Unpack a zip file into a folder; `zipfile` writes nothing outside this folder, and no links.

    Raises:
        RecordError: the file cannot be read, is not a zip file, or is damaged or encrypted.
        OutputError: the temporary folder lacks space.
    """
    try:
        check_regular(path)
        with zipfile.ZipFile(path) as archive:
            archive.extractall(into)
    except OSError as error:
        if error.errno in {errno.ENOSPC, errno.EDQUOT}:
            raise OutputError(
                f"The bundle {path} cannot be opened into a temporary folder: {error.strerror}; free some space, or "
                "name another folder with TMPDIR."
            ) from error
        raise RecordError(
            f"The bundle {path} cannot be read: {error.strerror}; name the zip file that 'sunset bundle' wrote."
        ) from error
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError) as error:
        reason = printable(str(error)).rstrip(".")
        raise RecordError(f"The bundle {path} is not a zip file, or is damaged: {reason}.") from error


def differing_files(folder: Path) -> Iterator[str]:
    """Yield a sentence for each file of an opened bundle that does not match the list of checksums."""
    try:
        lines = (folder / CHECKSUMS_FILE).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        yield f"{CHECKSUMS_FILE}: it is missing, or is not a text."
        return
    listed = {name: digest for digest, _, name in (line.partition("  ") for line in lines)}
    present = {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}
    for name in sorted(listed.keys() | (present - {CHECKSUMS_FILE})):
        if name not in present:
            yield f"{name}: it is missing, although {CHECKSUMS_FILE} lists it."
        elif name not in listed:
            yield f"{name}: {CHECKSUMS_FILE} does not list it."
        elif file_digest(folder / name) != listed[name]:
            yield f"{name}: it was changed, since its checksum differs from {CHECKSUMS_FILE}."
