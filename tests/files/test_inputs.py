"""Whatever a user names is a regular file of bounded size, or refused at once."""

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from sunset.errors import RecordError, SunsetError
from sunset.files.inputs import check_regular, file_digest, read_bytes, read_text
from sunset.perception import ModelCard
from sunset.recording import count_runs, read_run

READERS = [check_regular, file_digest, read_bytes, read_text]


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize("kind", ["pipe", "device", "link to a device"])
def test_what_is_not_a_regular_file_is_refused_at_once(kind: str, read: object, tmp_path: Path) -> None:
    path = Path("/dev/zero") if kind == "device" else tmp_path / "it"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "link to a device":
        path.symlink_to("/dev/zero")
    assert callable(read)
    with pytest.raises(OSError, match="not a regular file") as caught:
        read(path)
    assert caught.value.filename == str(path)


def test_a_socket_a_folder_and_nothing_are_refused_in_the_systems_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # a socket's path must be short
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("door")
        with pytest.raises(OSError, match="a socket, not a regular file"):
            read_bytes(Path("door"))
    with pytest.raises(IsADirectoryError):
        read_bytes(tmp_path)
    with pytest.raises(FileNotFoundError):
        read_bytes(tmp_path / "nothing")


def test_a_file_may_have_as_many_bytes_as_allowed_and_no_more(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"twelve bytes")
    assert read_bytes(path, 12) == b"twelve bytes"
    with pytest.raises(OSError, match="larger than 11 bytes"):
        read_bytes(path, 11)


def test_a_link_to_a_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("füße", encoding="utf-8")
    (tmp_path / "link").symlink_to("file")
    assert read_text(tmp_path / "link") == "füße"
    assert file_digest(tmp_path / "link") == (
        "26c039741212205c52b98520abb92640f2e8f6d2f543f3e49eb0dfc2bce123f0"
    )


@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("run.json", lambda file: read_run(file.parent)),
        ("card.json", ModelCard.read),
    ],
)
def test_no_reader_waits_for_a_pipe(name: str, read: Callable[[Path], object], tmp_path: Path) -> None:
    file = tmp_path / "rgb" / name
    file.parent.mkdir()
    os.mkfifo(file)
    with pytest.raises(SunsetError, match="not a regular file"):
        read(file)


def test_a_plan_that_is_a_pipe_is_no_campaign(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "bench.json")
    with pytest.raises(RecordError, match="not a regular file"):
        count_runs(tmp_path)
