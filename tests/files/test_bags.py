"""Bags expand to what recordings hold, and no further."""

import sqlite3
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import CompressionMode, StoragePlugin
from tests.data.material import image_message, make_frames, record, rows_of

from sunset.data import read_bag
from sunset.errors import DataError
from sunset.files.bags import expand, open_bag

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

MIB = 2**20
BOMB = zstd.compress(bytes(MIB)) * 3000
"""3 GB in less than 200 kB, as frames of which each tells the truth."""


def test_what_was_packed_comes_back_whole_in_one_frame_or_several() -> None:
    text = bytes(range(256)) * 1000
    assert expand(zstd.compress(text)) == text
    assert expand(zstd.compress(text[:7]) + zstd.compress(text[7:]), len(text)) == text
    assert expand(b"", 0) == b""


def test_a_bomb_is_refused_before_it_fills_the_memory() -> None:
    assert len(BOMB) < 200_000
    with pytest.raises(ValueError, match="would expand to more than 268435456 bytes"):
        expand(BOMB)


def test_what_is_larger_than_announced_or_ends_early_is_refused() -> None:
    packed = zstd.compress(bytes(1001))
    with pytest.raises(ValueError, match="would expand to more than 1000 bytes"):
        expand(packed, 1000)
    with pytest.raises(ValueError, match="ends before its content does"):
        expand(packed[:-1])


PACKED = [
    (StoragePlugin.MCAP, CompressionMode.STORAGE),
    (StoragePlugin.MCAP, CompressionMode.MESSAGE),
    (StoragePlugin.MCAP, CompressionMode.FILE),
    (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
    (StoragePlugin.SQLITE3, CompressionMode.FILE),
]


@pytest.mark.parametrize(("plugin", "mode"), PACKED)
def test_a_small_bag_that_expands_to_much_is_refused_however_it_is_packed(
    plugin: StoragePlugin, mode: CompressionMode, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    zeros = image_message(np.zeros((MIB, 3), dtype=np.uint8), "bgr8", 1, width=1, height=MIB, step=3)
    bag = record(tmp_path / "bag", [("/rgb_raw", 1, zeros), *rows_of(make_frames())], plugin, mode)
    monkeypatch.setattr("sunset.files.bags.LARGEST", 2 * MIB)
    monkeypatch.setattr("sunset.files.bags.RATIO", 1)
    with pytest.raises(DataError, match="would expand to more than 2097152 bytes"):
        read_bag(bag)


@pytest.mark.parametrize(("plugin", "mode"), PACKED)
def test_a_packed_bag_is_read(plugin: StoragePlugin, mode: CompressionMode, tmp_path: Path) -> None:
    frames = make_frames()
    with read_bag(record(tmp_path / "bag", rows_of(frames), plugin, mode)) as bag:
        assert np.array_equal(bag.frame(1).rgb, frames[1].rgb)


def test_a_database_cannot_make_messages_up(tmp_path: Path) -> None:
    bag = record(tmp_path / "bag", rows_of(make_frames()), StoragePlugin.SQLITE3)
    with closing(sqlite3.connect(bag / "bag.db3")) as connection, connection:
        connection.execute("ALTER TABLE messages RENAME TO real")
        connection.execute(
            "CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
            "data BLOB AS (zeroblob(900000000)))"
        )
        connection.execute("INSERT INTO messages SELECT id, topic_id, timestamp FROM real")
    with pytest.raises(DataError, match="too big"):
        read_bag(bag)


def test_a_pipe_beside_a_bags_files_does_not_block(tmp_path: Path) -> None:
    bag = record(tmp_path / "bag", rows_of(make_frames()))
    (bag / "bag.mcap").unlink()
    (bag / "bag.mcap").symlink_to("/dev/zero")
    with pytest.raises(OSError, match="not a regular file"):
        open_bag(bag)
