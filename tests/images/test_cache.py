import contextlib
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

from sunset.errors import DataError, OutputError
from sunset.images import ImageCache

KEY, OTHER = bytes(16), bytes(range(16))
VALUE = bytes(range(256)) * 4

WRITER = """
import sys
from sunset.images import ImageCache
from pathlib import Path
path, first, count = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
cache = ImageCache(path)
print("open", flush=True)
for number in range(first, first + count):
    cache.put(number.to_bytes(16), bytes([number % 28]) * 2000)
"""


def write(path: Path, first: int, count: int) -> "subprocess.Popen[str]":
    command = [sys.executable, "-c", WRITER, str(path), str(first), str(count)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def test_a_value_comes_back_as_it_was_put(tmp_path: Path) -> None:
    cache = ImageCache(tmp_path / "new" / "cache.sqlite")
    assert cache.get(KEY) is None
    cache.put(KEY, b"earlier")
    cache.put(KEY, VALUE)
    cache.close()
    assert ImageCache(tmp_path / "new" / "cache.sqlite").get(KEY) == VALUE


def test_processes_that_open_and_write_at_once_lose_nothing(tmp_path: Path) -> None:
    path = tmp_path / "cache.sqlite"
    writers = [write(path, 200 * number, 300) for number in range(3)]
    assert [writer.wait() for writer in writers] == [0, 0, 0]
    for writer in writers:
        writer.communicate()
    cache = ImageCache(path)
    assert len(cache) == 700  # the ranges overlap
    assert cache.get((650).to_bytes(16)) is not None
    assert [file.name for file in tmp_path.iterdir() if file.name.startswith(".")] == []


def test_a_killed_writer_leaves_a_cache_that_others_go_on_with(tmp_path: Path) -> None:
    path = tmp_path / "cache.sqlite"
    with write(path, 0, 1_000_000) as writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == "open\n"
        cache = ImageCache(path)
        while len(cache) < 50:
            pass
        writer.send_signal(signal.SIGKILL)
        assert writer.wait() == -signal.SIGKILL
    count = len(cache)
    assert all(cache.get(number.to_bytes(16)) is not None for number in range(count))
    cache.put((2_000_000).to_bytes(16), VALUE)
    assert len(cache) == count + 1
    with sqlite3.connect(path) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    connection.close()


def test_another_kind_of_file_is_refused_and_kept(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("not a cache\n" * 500, encoding="utf-8")
    with pytest.raises(DataError, match=r"The cache .*notes\.txt is damaged .*: delete it"):
        ImageCache(path)
    assert path.read_text(encoding="utf-8").startswith("not a cache")


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="looks up open files in Linux' way")
def test_what_is_refused_is_not_held_open(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("not a cache\n" * 500, encoding="utf-8")
    with pytest.raises(DataError) as caught:  # which keeps alive what nobody closed
        ImageCache(path)
    assert path not in [file.readlink() for file in Path("/proc/self/fd").iterdir() if file.is_symlink()]
    del caught


def test_another_database_is_refused_and_kept(tmp_path: Path) -> None:
    path = tmp_path / "other.sqlite"
    connection = sqlite3.connect(path)
    connection.execute("CREATE TABLE answers (key BLOB, labels BLOB, entropy REAL)")
    connection.commit()
    connection.close()
    with pytest.raises(DataError, match=r"The file .*other\.sqlite is no cache of this version"):
        ImageCache(path)


def test_a_damaged_cache_says_so(tmp_path: Path) -> None:
    path = tmp_path / "cache.sqlite"
    cache = ImageCache(path)
    for number in range(200):
        cache.put(number.to_bytes(16), VALUE)
    cache.close()
    content = bytearray(path.read_bytes())
    content[4096:] = bytes(len(content) - 4096)
    path.write_bytes(content)
    damaged = ImageCache(path)
    with pytest.raises(DataError, match="is damaged"):
        damaged.get((100).to_bytes(16))


FORGERIES: dict[str, tuple[str, tuple[object, ...]]] = {
    "value": ("value = ?", (VALUE[1:],)),
    "a text for a value": ("value = 'sure'", ()),
    "a number for a value": ("value = 3", ()),
    "the value of another key": (
        "(value, checksum) = (SELECT value, checksum FROM known WHERE key = ?)",
        (OTHER,),
    ),
}


@pytest.mark.parametrize("forgery", FORGERIES)
def test_a_changed_value_is_reported_once_and_not_used(
    forgery: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "cache.sqlite"
    cache = ImageCache(path)
    cache.put(OTHER, b"another")
    cache.put(KEY, VALUE)
    with contextlib.closing(sqlite3.connect(path)) as connection, connection:
        change, values = FORGERIES[forgery]
        connection.execute(f"UPDATE known SET {change} WHERE key = ?", (*values, KEY))  # noqa: S608  it is ours

    cache = ImageCache(path)  # which remembers nothing
    assert [cache.get(KEY), cache.get(KEY)] == [None, None]
    assert caplog.messages == [f"The cache {path} holds a value that was changed: it is computed anew."]
    cache.put(KEY, VALUE)
    assert cache.get(KEY) == VALUE


def test_a_full_cache_names_the_way_without_it(tmp_path: Path) -> None:
    code = (
        "import sys, resource, signal, random; from sunset.images import ImageCache\n"
        "cache = ImageCache(sys.argv[1])\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100000, 100000))\n"
        "[cache.put(bytes([n] * 16), random.randbytes(10000)) for n in range(99)]\n"
    )
    result = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "cache.sqlite")],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    last = result.stderr.splitlines()[-1]
    assert last.startswith("sunset.errors.OutputError: The cache ")
    assert last.endswith("; --no-cache does without it, SUNSET_CACHE_DIR names another folder.")


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(
        OutputError, match=r"The cache .* cannot be made: (Not a directory|File exists); --no-cache"
    ):
        ImageCache(tmp_path / "file" / "cache.sqlite")


def test_a_folder_in_the_place_of_the_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="cannot be used: unable to open database file; --no-cache"):
        ImageCache(tmp_path)


def test_a_cache_that_was_deleted_is_made_again(tmp_path: Path) -> None:
    path = tmp_path / "cache.sqlite"
    ImageCache(path).put(KEY, VALUE)
    cache = ImageCache(path)
    cache.close()
    for file in tmp_path.iterdir():
        file.unlink()
    assert cache.get(KEY) is None
    cache.put(KEY, VALUE)
    assert ImageCache(path).get(KEY) == VALUE
