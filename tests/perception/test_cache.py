import contextlib
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from sunset.errors import DataError, OutputError
from sunset.files.compression import zstd
from sunset.perception import InferenceCache, Modality, Model, Segmenter

Frame = tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16]]

OTHER = bytes(range(32))
LABELS = np.arange(144 * 256, dtype=np.uint8).reshape(144, 256) % 28

WRITER = """
import sys
import numpy as np
from sunset.perception import InferenceCache
from pathlib import Path
path, first, count = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
cache = InferenceCache(path)
print("open", flush=True)
for number in range(first, first + count):
    cache.put(number.to_bytes(32), np.full(36864, number % 28, dtype=np.uint8), number / 1e6)
"""


def write(path: Path, first: int, count: int) -> "subprocess.Popen[str]":
    command = [sys.executable, "-c", WRITER, str(path), str(first), str(count)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def test_an_answer_comes_back_as_it_was_put(tmp_path: Path) -> None:
    cache = InferenceCache(tmp_path / "new" / "cache.sqlite")
    key = cache.key("abc", Modality.RGB, [LABELS])
    assert cache.get(key) is None
    cache.put(key, LABELS, 0.1 + 0.2)
    cache.close()
    found = InferenceCache(tmp_path / "new" / "cache.sqlite").get(key)
    assert found is not None
    assert np.array_equal(found[0], LABELS.ravel())
    assert found[1] == 0.1 + 0.2
    assert not found[0].flags.writeable


def test_an_entropy_of_minus_zero_is_found_again(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    cache = InferenceCache(tmp_path / "cache.sqlite")
    cache.put(OTHER, LABELS, -0.0)
    found = cache.get(OTHER)
    assert found is not None
    assert found[1] == 0.0
    assert caplog.text == ""


def test_an_entropy_that_is_no_number_is_not_kept_and_no_damage(tmp_path: Path) -> None:
    cache = InferenceCache(tmp_path / "cache.sqlite")
    cache.put(OTHER, LABELS, float("nan"))
    assert cache.get(OTHER) is None


def test_the_key_tells_weights_modality_and_inputs_apart(tmp_path: Path) -> None:
    cache = InferenceCache(tmp_path / "cache.sqlite")
    other = LABELS.copy()
    other[0, 0] += 1
    keys = {
        cache.key("abc", Modality.RGB, [LABELS]),
        cache.key("abd", Modality.RGB, [LABELS]),
        cache.key("abc", Modality.DEPTH, [LABELS]),
        cache.key("abc", Modality.RGB, [other]),
        cache.key("abc", Modality.RGB, [LABELS.T.copy()]),
        cache.key("abc", Modality.RGB, [LABELS, LABELS]),
    }
    assert len(keys) == 6
    assert cache.key("abc", Modality.RGB, [LABELS.copy()]) in keys


def test_a_segmenter_answers_the_same_with_and_without_a_cache(
    tmp_path: Path, lite: Model, frame: Frame
) -> None:
    cache = InferenceCache(tmp_path / "cache.sqlite")
    plain = Segmenter(lite).segment(Modality.FUSION, *frame)
    for known in (1, 1):
        cached = Segmenter(lite, cache=cache).segment(Modality.FUSION, *frame)
        assert np.array_equal(cached.labels, plain.labels)
        assert cached.entropy == plain.entropy
        assert len(cache) == known


def test_a_cached_answer_is_used(tmp_path: Path, lite: Model, frame: Frame) -> None:
    cache = InferenceCache(tmp_path / "cache.sqlite")
    key = cache.key(lite.card.networks[Modality.RGB].digest, Modality.RGB, [frame[0]])
    cache.put(key, LABELS, 0.125)
    result = Segmenter(lite, cache=cache).segment(Modality.RGB, frame[0], None)
    assert result.entropy == 0.125
    assert np.array_equal(result.labels, LABELS)


def test_processes_that_open_and_write_at_once_lose_nothing(tmp_path: Path) -> None:
    path = tmp_path / "cache.sqlite"
    writers = [write(path, 200 * number, 300) for number in range(3)]
    assert [writer.wait() for writer in writers] == [0, 0, 0]
    for writer in writers:
        writer.communicate()
    cache = InferenceCache(path)
    assert len(cache) == 700  # the ranges overlap
    assert cache.get((650).to_bytes(32)) is not None
    assert [file.name for file in tmp_path.iterdir() if file.name.startswith(".")] == []


def test_a_killed_writer_leaves_a_cache_that_others_go_on_with(tmp_path: Path) -> None:
    path = tmp_path / "cache.sqlite"
    with write(path, 0, 1_000_000) as writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == "open\n"
        cache = InferenceCache(path)
        while len(cache) < 50:
            pass
        writer.send_signal(signal.SIGKILL)
        assert writer.wait() == -signal.SIGKILL
    count = len(cache)
    assert all(cache.get(number.to_bytes(32)) is not None for number in range(count))
    cache.put((2_000_000).to_bytes(32), LABELS, 0.5)
    assert len(cache) == count + 1
    with sqlite3.connect(path) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    connection.close()


def test_another_kind_of_file_is_refused_and_kept(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("not a cache\n" * 500, encoding="utf-8")
    with pytest.raises(DataError, match=r"The inference cache .*notes\.txt is damaged .*: delete it"):
        InferenceCache(path)
    assert path.read_text(encoding="utf-8").startswith("not a cache")


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="looks up open files in Linux' way")
def test_what_is_refused_is_not_held_open(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("not a cache\n" * 500, encoding="utf-8")
    with pytest.raises(DataError) as caught:  # which keeps alive what nobody closed
        InferenceCache(path)
    assert path not in [file.readlink() for file in Path("/proc/self/fd").iterdir() if file.is_symlink()]
    del caught


def test_another_database_is_refused_and_kept(tmp_path: Path) -> None:
    path = tmp_path / "other.sqlite"
    connection = sqlite3.connect(path)
    connection.execute("CREATE TABLE answers (key BLOB, labels BLOB, entropy REAL)")
    connection.commit()
    connection.close()
    with pytest.raises(DataError, match=r"The file .*other\.sqlite is no inference cache of this version"):
        InferenceCache(path)


def test_a_damaged_cache_says_so(tmp_path: Path) -> None:
    path = tmp_path / "cache.sqlite"
    cache = InferenceCache(path)
    for number in range(200):
        cache.put(number.to_bytes(32), LABELS, 0.5)
    cache.close()
    content = bytearray(path.read_bytes())
    content[4096:] = bytes(len(content) - 4096)
    path.write_bytes(content)
    damaged = InferenceCache(path)
    with pytest.raises(DataError, match="is damaged"):
        damaged.get((100).to_bytes(32))


FORGERIES: dict[str, tuple[str, tuple[object, ...]]] = {
    "entropy": ("entropy = 0.999", ()),
    "a text for an entropy": ("entropy = 'sure'", ()),
    "labels": ("labels = ?", (zstd.compress(bytes([255]) * LABELS.size),)),
    "labels that do not unpack": ("labels = x'0102'", ()),
    "a number for labels": ("labels = 3", ()),
    "the answer to another frame": (
        "(labels, entropy, checksum) = (SELECT labels, entropy, checksum FROM answers WHERE key = ?)",
        (OTHER,),
    ),
}


@pytest.mark.parametrize("forgery", FORGERIES)
def test_a_forged_answer_is_told_of_once_and_computed_anew(
    forgery: str, tmp_path: Path, lite: Model, frame: Frame, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "cache.sqlite"
    cache = InferenceCache(path)
    cache.put(OTHER, LABELS, 0.125)
    segmenter = Segmenter(lite, cache=cache)
    true = segmenter.segment(Modality.RGB, *frame)
    with contextlib.closing(sqlite3.connect(path)) as connection, connection:
        change, values = FORGERIES[forgery]
        connection.execute(f"UPDATE answers SET {change}", values)  # noqa: S608  it is ours

    for _ in range(2):
        found = segmenter.segment(Modality.RGB, *frame)
        assert found.entropy == true.entropy
        assert np.array_equal(found.labels, true.labels)

    assert caplog.messages == [
        f"The inference cache {path} holds an answer that was changed: it is computed anew."
    ]


def test_a_full_cache_names_the_way_without_it(tmp_path: Path) -> None:
    code = (
        "import sys, resource, signal; import numpy as np; from sunset.perception import InferenceCache\n"
        "cache = InferenceCache(sys.argv[1])\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100000, 100000))\n"
        "rng = np.random.default_rng(1)\n"
        "[cache.put(bytes([n] * 32), rng.integers(0, 28, 36864, dtype=np.uint8), 0.5) for n in range(99)]\n"
    )
    result = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "cache.sqlite")],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    last = result.stderr.splitlines()[-1]
    assert last.startswith("sunset.errors.OutputError: The inference cache ")
    assert last.endswith("; --no-cache does without it, SUNSET_CACHE_DIR names another folder.")


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(
        OutputError, match=r"The inference cache .* cannot be made: (Not a directory|File exists); --no-cache"
    ):
        InferenceCache(tmp_path / "file" / "cache.sqlite")


def test_a_folder_in_the_place_of_the_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="cannot be used: unable to open database file; --no-cache"):
        InferenceCache(tmp_path)
