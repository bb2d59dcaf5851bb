"""Whatever is wrong with the data that a user brings ends with one sentence and exit code 2."""

import os
import re
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from rosbags.rosbag2 import CompressionMode, StoragePlugin, Writer
from tests.data.material import (
    FLIGHT,
    IMAGE,
    SIZE,
    STAMPS,
    STORE,
    Rows,
    image_message,
    make_frames,
    picture_file,
    put_frame,
    record,
    rows_of,
)

Complaint = Callable[[Sequence[str]], str]
Spoil = Callable[[Path], None]


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("kept") / "syndrone"
    for number in range(2):
        put_frame(root / FLIGHT, number)
    return root


def replaced(name: str, make: Callable[[bytes], bytes]) -> Spoil:
    def spoil(root: Path) -> None:
        path = root / FLIGHT / name
        data = path.read_bytes()
        # the file is shared with other tests
        path.unlink()
        path.write_bytes(make(data))

    return spoil


def removed(*names: str) -> Spoil:
    def spoil(root: Path) -> None:
        path = root.joinpath(*names)
        shutil.rmtree(path) if path.is_dir() else path.unlink()

    return spoil


def plain(shape: tuple[int, ...], kind: str, suffix: str, value: int = 7) -> Callable[[bytes], bytes]:
    return lambda _: picture_file(np.full(shape, value, dtype=kind), suffix)


def another_weather(root: Path) -> None:
    shutil.copytree(root / FLIGHT, root / "Town01_Opt_120" / "WetNoon" / "height50m", copy_function=os.link)


def untouched(root: Path) -> None:
    assert root.is_dir()


def other_out(root: Path) -> None:
    (root.parent / "flight.mcap").write_text("dear reader")


FOLDERS: dict[str, tuple[Spoil, Sequence[str], Sequence[str]]] = {
    "missing folder": (removed(), [], ["no folder", "TownNN_Opt_120"]),
    "missing depth": (removed(*FLIGHT.parts, "depth"), [], ["depth", "Town01_Opt_120_depth.zip"]),
    "missing labels": (removed(*FLIGHT.parts, "semantic"), [], ["semantic", "Town01_Opt_120_color.zip"]),
    "fewer labels": (
        removed(*FLIGHT.parts, "semantic", "00001.png"),
        [],
        ["labels of every frame, got 1 of 2", "Town01_Opt_120_color.zip"],
    ),
    "depth of 8 bits": (
        replaced("depth/00001.png", plain((1080, 1920), "u1", ".png")),
        [],
        ["depth/00001.png", "16-bit greyscale PNG", "got 8-bit greyscale PNG"],
    ),
    "labels of 16 bits": (
        replaced("semantic/00001.png", plain((1080, 1920), "u2", ".png")),
        [],
        ["semantic/00001.png", "8-bit greyscale PNG", "got 16-bit greyscale PNG"],
    ),
    "impossible ids": (
        replaced("semantic/00000.png", plain((1080, 1920), "u1", ".png", 31)),
        [],
        ["semantic/00000.png", "got 31"],
    ),
    "truncated JPEG": (
        replaced("rgb/00001.jpg", lambda data: data[: len(data) // 2]),
        [],
        ["rgb/00001.jpg", "ends before the picture does"],
    ),
    "truncated PNG": (
        replaced("depth/00000.png", lambda data: data[: len(data) // 2]),
        [],
        ["depth/00000.png", "ends before the picture does"],
    ),
    "no picture": (replaced("rgb/00000.jpg", lambda _: b"not found"), [], ["rgb/00000.jpg", "neither JPEG"]),
    "other size": (
        replaced("rgb/00000.jpg", plain((720, 1280, 3), "u1", ".jpg")),
        [],
        ["depth/00000.png", "1280x720", "got 1920x1080"],
    ),
    "several weathers": (another_weather, [], ["ClearNoon, WetNoon", "--weather"]),
    "unknown town": (untouched, ["--town", "9"], ["1 to 7 and 10HD", "'9'"]),
    "missing town": (untouched, ["--town", "10"], ["Town10HD_Opt_120", "got Town01_Opt_120"]),
    "missing weather": (untouched, ["--weather", "HardRainNoon"], ["HardRainNoon", "got ClearNoon"]),
    "missing height": (untouched, ["--height", "20"], ["height20m", "got height50m"]),
    "no frame selected": (untouched, ["--frames", "7:9"], ["frames 0 to 1", "from 7 to 9"]),
    "some frame selected": (untouched, ["--frames", "0:9"], ["frames 0 to 1", "from 0 to 9"]),
    "frames no span": (untouched, ["--frames", "7"], ["FIRST:LAST", "'7'"]),
    "size no size": (untouched, ["--size", "256"], ["WIDTHxHEIGHT", "'256'"]),
    "size of nothing": (untouched, ["--size", "0x144"], ["WIDTHxHEIGHT", "'0x144'"]),
    "no rate": (untouched, ["--rate", "0"], ["0.1 to 1000", "'0'"]),
    "out exists": (other_out, [], ["flight.mcap", "exists"]),
    "unwritable out": (
        untouched,
        ["--out", "/dev/null/flight.mcap"],
        ["/dev/null/flight.mcap", "another place"],
    ),
    "two sources": (untouched, ["--bag", "other"], ["--bag", "--syndrone"]),
}


@pytest.mark.parametrize("case", FOLDERS)
def test_a_bad_folder_of_syndrone(case: str, kept: Path, tmp_path: Path, complaint: Complaint) -> None:
    root = tmp_path / "syndrone"
    shutil.copytree(kept, root, copy_function=os.link)
    spoil, options, words = FOLDERS[case]
    spoil(root)
    before = sorted(tmp_path.iterdir())

    sentence = complaint(["data", "import", "--syndrone", str(root), "--out", "flight.mcap", *options])

    for word in words:
        assert word in sentence
    assert sorted(tmp_path.iterdir()) == before


def changed(place: int, **changes: Any) -> Callable[[Rows], Rows]:
    def change(rows: Rows) -> Rows:
        for name, value in changes.items():
            setattr(rows[place][2], name, value)
        return rows

    return change


def without_depth(rows: Rows) -> Rows:
    return [row for row in rows if row[0] != "/depth_raw"]


def no_depth_measured(rows: Rows) -> Rows:
    nothing = np.full(SIZE, np.nan, dtype=np.float32)
    rows[1::3] = [(topic, time, image_message(nothing, "32FC1", time)) for topic, time, _ in rows[1::3]]
    return rows


def never_together(rows: Rows) -> Rows:
    for _, _, message in rows[2::3]:
        message.header.stamp.sec += 3600
    return rows


CONTENTS: dict[str, tuple[Callable[[Rows], Rows], Sequence[str]]] = {
    "missing topic": (without_depth, ["/depth_raw", "got /gt_segmentation, /rgb_raw"]),
    "grey colour": (changed(3, encoding="mono8"), ["1 on /rgb_raw", "bgr8", "got 'mono8'"]),
    "raw Bayer": (changed(0, encoding="bayer_rggb8"), ["0 on /rgb_raw", "got 'bayer_rggb8'"]),
    "depth of 8 bits": (
        changed(1, encoding="8UC1"),
        ["0 on /depth_raw", "16UC1, mono16 or 32FC1", "got '8UC1'"],
    ),
    "labels in colour": (
        changed(5, encoding="rgb8"),
        ["1 on /gt_segmentation", "8UC1 or mono8", "got 'rgb8'"],
    ),
    "data too short": (changed(0, data=np.zeros(9, dtype=np.uint8)), ["0 on /rgb_raw", "got 9 bytes"]),
    "impossible ids": (
        changed(8, data=np.full(60, 200, dtype=np.uint8)),
        ["2 on /gt_segmentation", "got 200", "map them to these"],
    ),
    "nothing but NaN": (no_depth_measured, ["/depth_raw", "below 1000 m"]),
    "other clocks": (never_together, ["one moment", "synchronise"]),
}


@pytest.mark.parametrize("case", CONTENTS)
def test_a_bag_of_bad_content(case: str, tmp_path: Path, complaint: Complaint) -> None:
    change, words = CONTENTS[case]
    record(tmp_path / "bag", change(rows_of(make_frames())), StoragePlugin.SQLITE3)

    sentence = complaint(["run", "--bag", "bag"])

    assert " bag" in sentence
    for word in words:
        assert word in sentence


def test_images_of_several_sizes(tmp_path: Path, complaint: Complaint) -> None:
    rows = rows_of(make_frames())
    rows[4] = (
        "/depth_raw",
        STAMPS[1],
        image_message(np.zeros((12, 20), dtype=np.uint16), "16UC1", STAMPS[1]),
    )
    record(tmp_path / "bag", rows)

    sentence = complaint(["run", "--bag", "bag"])

    assert "1 on /depth_raw" in sentence
    assert "10x6, got 20x12" in sentence


def test_another_message_type(tmp_path: Path, complaint: Complaint) -> None:
    kind = "std_msgs/msg/Empty"
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/rgb_raw", kind, typestore=STORE)
        writer.write(connection, 1, STORE.serialize_cdr(STORE.types[kind](), kind))

    sentence = complaint(["run", "--bag", "bag"])

    assert IMAGE in sentence
    assert f"got {kind}" in sentence


def halved(folder: Path, suffix: str) -> None:
    (path,) = folder.glob(f"*{suffix}")
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])


def garbled(folder: Path, suffix: str) -> None:
    (path,) = folder.glob(f"*{suffix}")
    data = bytearray(path.read_bytes())
    data[8:72] = b"?" * 64
    path.write_bytes(data)


DAMAGES: dict[str, tuple[StoragePlugin, CompressionMode, Callable[[Path, str], None], str]] = {
    "truncated MCAP": (StoragePlugin.MCAP, CompressionMode.NONE, halved, ".mcap"),
    "garbled MCAP": (StoragePlugin.MCAP, CompressionMode.STORAGE, garbled, ".mcap"),
    "truncated db3": (StoragePlugin.SQLITE3, CompressionMode.NONE, halved, ".db3"),
    "truncated zstd": (StoragePlugin.SQLITE3, CompressionMode.FILE, halved, ".zstd"),
    "garbled zstd": (StoragePlugin.MCAP, CompressionMode.FILE, garbled, ".zstd"),
}


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # rosbags leaves files open
@pytest.mark.parametrize("case", DAMAGES)
def test_a_damaged_bag(case: str, tmp_path: Path, complaint: Complaint) -> None:
    plugin, mode, damage, suffix = DAMAGES[case]
    damage(record(tmp_path / "bag", rows_of(make_frames(3, (30, 40))), plugin, mode), suffix)

    sentence = complaint(["run", "--bag", "bag"])

    assert re.search("The bag bag (cannot be read as a rosbag2|must have the 3 images)", sentence)
    assert re.search("record, copy or import it again|mcap recover", sentence)


def edited(folder: Path, **changes: object) -> None:
    path = folder / "metadata.yaml"
    metadata = yaml.safe_load(path.read_text())
    metadata["rosbag2_bagfile_information"] |= changes
    path.write_text(yaml.safe_dump(metadata))


METADATA: dict[str, tuple[dict[str, object], str]] = {
    "unknown codec": ({"compression_format": "lz4", "compression_mode": "file"}, "lz4"),
    "unknown storage": ({"storage_identifier": "leveldb"}, "leveldb"),
    "missing file": ({"relative_file_paths": ["bag_7.mcap"]}, "bag_7.mcap"),
    "version of the future": ({"version": 99}, "99"),
    "other serialization": ({"topics_with_message_count": [{}]}, "topic_metadata"),
}


@pytest.mark.parametrize("case", METADATA)
def test_metadata_that_cannot_be_followed(case: str, tmp_path: Path, complaint: Complaint) -> None:
    changes, word = METADATA[case]
    edited(record(tmp_path / "bag", rows_of(make_frames())), **changes)

    sentence = complaint(["run", "--bag", "bag"])

    assert "The bag bag cannot be read as a rosbag2" in sentence
    assert word in sentence


def test_a_bag_without_a_message(tmp_path: Path, complaint: Complaint) -> None:
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        for topic in ("/rgb_raw", "/depth_raw", "/gt_segmentation"):
            writer.add_connection(topic, IMAGE, typestore=STORE)

    assert "at least one frame, got 0 on /rgb_raw" in complaint(["run", "--bag", "bag"])


def test_what_is_no_bag(tmp_path: Path, complaint: Complaint) -> None:
    (tmp_path / "thesis.pdf").write_text("dear reader")
    (tmp_path / "old.bag").write_text("#ROSBAG V2.0")

    assert "got '.pdf'" in complaint(["run", "--bag", "thesis.pdf"])
    assert "rosbags-convert" in complaint(["run", "--bag", "old.bag"])
    assert "There is no bag at nowhere" in complaint(["data", "info", "nowhere"])
    assert "There is no bag at nowhere" in complaint(["data", "import", "--bag", "nowhere", "--out", "o"])
    for option in ("--rate", "--jobs"):
        idle = ["data", "import", "--bag", "nowhere", option, "5", "--out", "o"]
        assert f"{option} is for --syndrone and --pictures and cannot be used with --bag" in complaint(idle)
    idle = ["data", "import", "--pictures", "nowhere", "--town", "2", "--out", "o"]
    assert "--town is for --syndrone and cannot be used with --pictures" in complaint(idle)


@pytest.mark.parametrize(("span", "got"), [("3:", "3 to 2"), ("0:3", "0 to 3"), ("2:1", "2 to 1")])
def test_frames_that_a_bag_does_not_have(span: str, got: str, tmp_path: Path, complaint: Complaint) -> None:
    record(tmp_path / "bag", rows_of(make_frames()))

    sentence = complaint(["data", "import", "--bag", "bag", "--frames", span, "--out", "o"])

    assert f"frames 0 to 2, got --frames from {got}; choose" in sentence
    assert not (tmp_path / "o").exists()


def test_sqlite3_under_a_path_that_it_would_misread(tmp_path: Path, complaint: Complaint) -> None:
    record(tmp_path / "bag", rows_of(make_frames()))
    (tmp_path / "run").write_text("dear reader")

    sentence = complaint(["data", "import", "--bag", "bag", "--out", "run#3/flight.db3"])

    assert "without #, ? and %" in sentence
    assert (tmp_path / "run").read_text() == "dear reader"
    assert not (tmp_path / "run#3").exists()
