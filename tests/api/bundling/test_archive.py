"""Bundles of strangers: what is not fit to be opened is refused in one sentence, and nothing is written elsewhere."""

import re
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from sunset.api.bundling import verify
from sunset.api.bundling.archive import extract_archive, write_archive
from sunset.errors import OutputError, RecordError

Make = Callable[[Path], object]

CENTRAL = b"PK\x01\x02"
"""How the entry of a file in a zip file's directory begins."""


def with_file(name: str, content: bytes = b"") -> Make:
    def make(path: Path) -> None:
        with zipfile.ZipFile(path, "w") as file:
            file.writestr(name, content)

    return make


def with_directory(offset: int, kind: str, value: int) -> Make:
    """Return what makes a zip file whose directory has a value that its file does not fit."""

    def make(path: Path) -> None:
        with_file("notes.txt", b"some text")(path)
        content = bytearray(path.read_bytes())
        struct.pack_into(kind, content, content.index(CENTRAL) + offset, value)
        path.write_bytes(content)

    return make


def truncated(path: Path) -> None:
    with_file("notes.txt", b"some text")(path)
    path.write_bytes(path.read_bytes()[:-30])


OF_ANOTHER_VERSION = b'{"bundle_version": 2, "managers": {}, "extensions": {}}'


MISTAKES: dict[str, tuple[Make, str]] = {
    "missing": (
        lambda _: None,
        r"x.zip cannot be read: No such file or directory; name the zip file that 'sunset bundle' wrote\.",
    ),
    "folder": (Path.mkdir, "x.zip cannot be read: Is a directory; name the zip file"),
    "text": (
        lambda path: path.write_text("results"),
        "is not a zip file, or is damaged: File is not a zip",
    ),
    "truncated": (truncated, "is not a zip file, or is damaged"),
    "other zip": (with_file("notes.txt"), "It is not a bundle: bundle.json is missing; name a file"),
    "another version": (
        with_file("bundle.json", OF_ANOTHER_VERSION),
        "The bundle is of version 2, expected 1",
    ),
    "manifest that is a list": (
        with_file("bundle.json", b"[]"),
        r"bundle\.json must be an object, got \[\]; take the bundle as it was published",
    ),
    "damaged manifest": (
        with_file("bundle.json", b"{"),
        "The manifest bundle.json is damaged and cannot be read",
    ),
    "encrypted": (
        with_directory(8, "<H", 1),
        "is not a zip file, or is damaged: File .* is encrypted",
    ),
    "larger than announced": (with_directory(24, "<I", 4), "is not a zip file, or is damaged: Bad CRC-32"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_what_is_not_a_bundle_is_refused(name: str, tmp_path: Path) -> None:
    make, expected = MISTAKES[name]
    room = tmp_path / "room"
    room.mkdir()
    make(room / "x.zip")

    with pytest.raises(RecordError, match=expected) as caught:
        verify(room / "x.zip", run_again=0, seed=1)

    assert re.fullmatch(r"[^\n]*\.", str(caught.value))
    assert {file.name for file in tmp_path.rglob("*")} <= {"room", "x.zip"}


def test_nothing_is_written_elsewhere(tmp_path: Path) -> None:
    with_file("../notes.txt", b"some text")(tmp_path / "x.zip")

    extract_archive(tmp_path / "x.zip", tmp_path / "opened")

    assert {file.name for file in tmp_path.iterdir()} == {"opened", "x.zip"}
    assert (tmp_path / "opened/notes.txt").read_bytes() == b"some text"


def test_the_same_files_give_the_same_bytes_wherever_they_are(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_bytes(b"some text")
    one = write_archive(tmp_path / "one.zip", {"b/notes.txt": tmp_path / "notes.txt", "a": b""})
    other = write_archive(tmp_path / "other.zip", {"a": b"", "b/notes.txt": b"some text"})

    assert one == other
    assert (tmp_path / "one.zip").read_bytes() == (tmp_path / "other.zip").read_bytes()
    with zipfile.ZipFile(tmp_path / "one.zip") as file:
        assert file.namelist() == ["a", "b/notes.txt", "SHA256SUMS"]
        assert b"  b/notes.txt\n" in file.read("SHA256SUMS")


def test_an_archive_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="cannot be written: No such file"):
        write_archive(tmp_path / "nowhere/x.zip", {"a": b""})

    assert list(tmp_path.iterdir()) == []
