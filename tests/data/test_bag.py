import contextlib
import hashlib
import os
import shutil
import sqlite3
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
import yaml
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionMode, StoragePlugin, Writer
from tests.data.material import (
    COMPRESSED,
    IMAGE,
    SIZE,
    STAMPS,
    STORE,
    Rows,
    compressed_message,
    header,
    image_message,
    make_frames,
    record,
    rows_of,
)

from sunset.data import Frame, read_bag, write_bag
from sunset.errors import DataError, InvalidInputError, OutputError


def _equal(one: Frame, other: Frame) -> bool:
    pairs = ((one.rgb, other.rgb), (one.depth, other.depth), (one.labels, other.labels))
    return all(a.dtype == b.dtype and np.array_equal(a, b) for a, b in pairs)


@pytest.mark.parametrize("name", ["bag", "bag.mcap", "bag.db3"])
def test_what_was_written_is_read(tmp_path: Path, name: str) -> None:
    frames = make_frames()
    with read_bag(write_bag(tmp_path / name, frames, STAMPS)) as bag:
        assert len(bag) == 3
        assert bag.size == SIZE
        assert bag.stamps_ns == tuple(STAMPS)
        for index in (2, 0, 1, 1):
            assert _equal(bag.frame(index), frames[index])
        assert repr(bag) == f"BagReader({str(tmp_path / name)!r}, frames=3, size=(6, 10))"


def test_a_standard_reader_reads_it(tmp_path: Path) -> None:
    frames = make_frames()
    folder = write_bag(tmp_path / "bag", frames, STAMPS)
    with AnyReader([folder], default_typestore=STORE) as reader:
        rows = [(c.topic, time, reader.deserialize(raw, c.msgtype)) for c, time, raw in reader.messages()]
    assert len(rows) == 9
    found = {(topic, time): message for topic, time, message in rows}
    message: Any = found["/depth_raw", STAMPS[2]]
    assert (message.encoding, message.width, message.step) == ("16UC1", 10, 20)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 300_000_000)
    np.testing.assert_array_equal(message.data.view("<u2").reshape(SIZE), frames[2].depth)


def test_the_file_itself_can_be_opened(tmp_path: Path) -> None:
    folder = write_bag(tmp_path / "bag", make_frames(), STAMPS)
    with read_bag(folder / "bag.mcap") as bag:
        assert len(bag) == 3


def test_frames_of_a_bag_cannot_be_changed(tmp_path: Path) -> None:
    with read_bag(write_bag(tmp_path / "bag", make_frames(), STAMPS)) as bag:
        frame = bag.frame(0)
    for image in (frame.rgb, frame.depth, frame.labels):
        with pytest.raises(ValueError, match="read-only"):
            image[0] = 0


def test_the_same_frames_give_the_same_bytes(tmp_path: Path) -> None:
    digests = set()
    for parent in ("a", "b"):
        folder = write_bag(tmp_path / parent / "bag", make_frames(), STAMPS)
        files = sorted(folder.iterdir())
        digests.add(hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest())
    assert len(digests) == 1


def test_messages_are_paired_by_their_own_stamps_not_by_the_time_of_recording(tmp_path: Path) -> None:
    frames = make_frames()
    late = {"/rgb_raw": 0, "/depth_raw": 7, "/gt_segmentation": 150_000_000}
    rows = [(topic, time + late[topic], message) for topic, time, message in rows_of(frames)]
    with read_bag(record(tmp_path / "bag", rows)) as bag:
        assert all(_equal(bag.frame(index), frames[index]) for index in range(3))


def test_other_topics_are_passed_over(tmp_path: Path) -> None:
    frames = make_frames()
    rows = [*rows_of(frames), ("/other", 5, image_message(frames[0].rgb, "rgb8", 5))]
    with read_bag(record(tmp_path / "bag", rows)) as bag:
        assert len(bag) == 3


def _modes() -> Iterator[Any]:
    for plugin in StoragePlugin:
        for mode in CompressionMode:
            if (plugin, mode) != (StoragePlugin.SQLITE3, CompressionMode.STORAGE):
                yield pytest.param(plugin, mode, id=f"{plugin.name}-{mode.name}")


@pytest.mark.parametrize(("plugin", "mode"), list(_modes()))
def test_every_storage_and_compression_is_read(
    tmp_path: Path, plugin: StoragePlugin, mode: CompressionMode
) -> None:
    frames = make_frames()
    with read_bag(record(tmp_path / "bag", rows_of(frames), plugin, mode)) as bag:
        assert all(_equal(bag.frame(index), frames[index]) for index in range(3))


@pytest.mark.parametrize("plugin", list(StoragePlugin))
def test_a_recording_in_several_files_is_one_bag(tmp_path: Path, plugin: StoragePlugin) -> None:
    frames = make_frames()
    rows = rows_of(frames)
    folder = record(tmp_path / "bag_0", rows[:4], plugin)
    second = record(tmp_path / "bag_1", rows[4:], plugin)
    (other,) = second.glob("bag_1.*")
    other.rename(folder / other.name)
    metadata = yaml.safe_load((folder / "metadata.yaml").read_text())
    metadata["rosbag2_bagfile_information"]["relative_file_paths"].append(other.name)
    (folder / "metadata.yaml").write_text(yaml.safe_dump(metadata))
    with read_bag(folder) as bag:
        assert all(_equal(bag.frame(index), frames[index]) for index in range(3))


@pytest.mark.parametrize("topic", ["/rgb_raw", "/depth_raw", "/gt_segmentation"])
def test_images_without_stamps_are_refused(tmp_path: Path, topic: str) -> None:
    rows = rows_of(make_frames())
    for name, _, message in rows:
        if name == topic:
            message.header.stamp.sec = message.header.stamp.nanosec = 0
    remedy = f"moments on {topic}, got 0 ns as the stamp of all 3: let the camera's driver set the stamps"
    with pytest.raises(DataError, match=remedy):
        read_bag(record(tmp_path / "bag", rows))


def _edit(folder: Path, change: Callable[[dict[str, Any]], None]) -> Path:
    path = folder / "metadata.yaml"
    metadata = yaml.safe_load(path.read_text())
    change(metadata["rosbag2_bagfile_information"])
    path.write_text(yaml.safe_dump(metadata))
    return folder


def _count(number: int) -> Callable[[dict[str, Any]], None]:
    def change(metadata: dict[str, Any]) -> None:
        for topic in metadata["topics_with_message_count"]:
            topic["message_count"] = number

    return change


@pytest.mark.parametrize("plugin", list(StoragePlugin))
def test_files_whose_qos_is_not_that_of_the_metadata_are_read(tmp_path: Path, plugin: StoragePlugin) -> None:
    frames = make_frames()
    rows = rows_of(frames)
    zero = QosTime(0, 0)
    qos = Qos(
        QosHistory.KEEP_LAST,
        5,
        QosReliability.BEST_EFFORT,
        QosDurability.VOLATILE,
        zero,
        zero,
        QosLiveliness.AUTOMATIC,
        zero,
        avoid_ros_namespace_conventions=False,
    )
    folder = tmp_path / "bag_0"
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        topics = [row[0] for row in rows[:3]]
        connections = {
            topic: writer.add_connection(topic, IMAGE, typestore=STORE, offered_qos_profiles=[qos])
            for topic in topics
        }
        for topic, time, message in rows[:6]:
            writer.write(connections[topic], time, STORE.serialize_cdr(message, IMAGE))
    (other,) = record(tmp_path / "bag_1", rows[6:], plugin).glob("bag_1.*")
    other.rename(folder / other.name)
    _edit(folder, lambda metadata: metadata["relative_file_paths"].append(other.name))
    with read_bag(_edit(folder, _count(3))) as bag:
        assert all(_equal(bag.frame(index), frames[index]) for index in range(3))


@pytest.mark.parametrize("plugin", list(StoragePlugin))
def test_a_bag_that_lacks_images_that_its_metadata_tells_of_is_refused(
    tmp_path: Path, plugin: StoragePlugin
) -> None:
    folder = _edit(record(tmp_path / "bag", rows_of(make_frames()), plugin), _count(6))
    with pytest.raises(
        DataError, match=r"the 6 images on /rgb_raw that its metadata tells of, got 3; .*reindex"
    ):
        read_bag(folder)


def test_a_bag_whose_images_were_not_counted_is_read(tmp_path: Path) -> None:
    folder = _edit(record(tmp_path / "bag", rows_of(make_frames())), _count(0))
    with read_bag(folder) as bag:
        assert len(bag) == 3


def test_what_a_killed_recorder_left_is_read_once_it_is_moved(tmp_path: Path) -> None:
    frames = make_frames()
    file = record(tmp_path / "bag", rows_of(frames), StoragePlugin.SQLITE3) / "bag.db3"
    killed = tmp_path / "killed"
    killed.mkdir()
    with contextlib.closing(sqlite3.connect(file)) as base:
        base.execute("PRAGMA journal_mode=WAL")
        base.execute("PRAGMA wal_autocheckpoint=0")
        base.execute("CREATE TABLE more(x)")
        base.commit()
        for path in file.parent.iterdir():
            shutil.copy(path, killed)
    for path in (killed, killed / "bag.db3"):
        with pytest.raises(DataError, match=r"bag\.db3 must be closed, .* in bag\.db3-wal: .*wal_checkpoint"):
            read_bag(path)
    with contextlib.closing(sqlite3.connect(killed / "bag.db3")) as base:
        base.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    with read_bag(killed) as bag:
        assert all(_equal(bag.frame(index), frames[index]) for index in range(3))


def test_a_recording_of_humble_is_read(tmp_path: Path) -> None:
    frames = make_frames()
    folder = tmp_path / "flight.bag"
    folder.mkdir()
    qos = "- history: 3\n  depth: 0\n  reliability: 1\n  durability: 2\n  deadline:\n    sec: 9223372036\n"
    qos += "    nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n"
    qos += "  liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n"
    qos += "  avoid_ros_namespace_conventions: false"
    topics = ["/rgb_raw", "/depth_raw", "/gt_segmentation"]
    with sqlite3.connect(folder / "flight_0.db3") as base:
        base.executescript(
            "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);"
            "CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL,"
            " metadata TEXT NOT NULL);"
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
            " serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,"
            " timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
            "INSERT INTO schema VALUES (3, 'humble');"
        )
        for number, topic in enumerate(topics, 1):
            base.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', ?)", (number, topic, IMAGE, qos))
        for topic, time, message in rows_of(frames):
            data = bytes(STORE.serialize_cdr(message, IMAGE))
            base.execute(
                "INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)",
                (topics.index(topic) + 1, time, data),
            )
    base.close()
    span = {
        "starting_time": {"nanoseconds_since_epoch": STAMPS[0]},
        "duration": {"nanoseconds": 1_200_000_000},
    }
    described = {"type": IMAGE, "serialization_format": "cdr", "offered_qos_profiles": qos}
    metadata = {
        "version": 5,
        "storage_identifier": "sqlite3",
        **span,
        "message_count": 9,
        "topics_with_message_count": [
            {"topic_metadata": {"name": topic, **described}, "message_count": 3} for topic in topics
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": ["flight_0.db3"],
        "files": [{"path": "flight_0.db3", **span, "message_count": 9}],
    }
    (folder / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": metadata}))
    with read_bag(folder) as bag:
        assert all(_equal(bag.frame(index), frames[index]) for index in range(3))
    with read_bag(folder / "flight_0.db3") as bag:
        assert _equal(bag.frame(2), frames[2])


@pytest.mark.parametrize(
    "options",
    [
        ["--dst-storage", "sqlite3", "--dst-version", "8"],
        ["--dst-storage", "mcap", "--compress", "zstd", "--compress-mode", "storage"],
    ],
)
def test_what_another_tool_converted_is_read(tmp_path: Path, options: list[str]) -> None:
    frames = make_frames()
    folder = write_bag(tmp_path / "bag", frames, STAMPS)
    paths = ["--src", str(folder), "--dst", str(tmp_path / "other")]
    call = [sys.executable, "-m", "rosbags.convert", *paths, *options]
    subprocess.run(call, check=True)
    with read_bag(tmp_path / "other") as bag:
        assert all(_equal(bag.frame(index), frames[index]) for index in range(3))


def _with_alpha(image: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return np.dstack([image, np.full(image.shape[:2], 9, dtype=np.uint8)])


@pytest.mark.parametrize(
    ("topic", "encoding", "convert", "changes"),
    [
        ("/rgb_raw", "rgb8", lambda image: image[..., ::-1], {}),
        ("/rgb_raw", "bgra8", _with_alpha, {}),
        ("/rgb_raw", "rgba8", lambda image: _with_alpha(image[..., ::-1]), {}),
        ("/rgb_raw", "bgr8", lambda image: image, {"step": 0}),
        ("/rgb_raw", "bgr8", lambda image: image, {"is_bigendian": 1}),
        ("/depth_raw", "mono16", lambda image: image, {}),
        ("/depth_raw", "16UC1", lambda image: image.astype(">u2"), {"is_bigendian": 1}),
        ("/depth_raw", "32FC1", lambda image: (image / 65.535).astype("<f4"), {}),
        ("/depth_raw", "32FC1", lambda image: (image / 65.535).astype(">f4"), {"is_bigendian": 1}),
        ("/gt_segmentation", "mono8", lambda image: image, {}),
    ],
)
def test_every_encoding_gives_the_same_frame(
    tmp_path: Path, topic: str, encoding: str, convert: Any, changes: dict[str, int]
) -> None:
    frames = make_frames(1)
    rows = rows_of(frames)
    place = [row[0] for row in rows].index(topic)
    array = (frames[0].rgb, frames[0].depth, frames[0].labels)[place]
    rows[place] = (
        topic,
        STAMPS[0],
        image_message(np.ascontiguousarray(convert(array)), encoding, STAMPS[0], **changes),
    )
    with read_bag(record(tmp_path / "bag", rows)) as bag:
        assert _equal(bag.frame(0), frames[0])
        assert bag.encodings[topic] == encoding


def test_padded_rows_are_understood(tmp_path: Path) -> None:
    frames = make_frames(1)
    rows = rows_of(frames)
    padded = np.zeros((SIZE[0], 32), dtype=np.uint8)
    padded[:, :30] = frames[0].rgb.reshape(SIZE[0], 30)
    rows[0][2].step, rows[0][2].data = 32, padded.reshape(-1)
    with read_bag(record(tmp_path / "bag", rows)) as bag:
        assert _equal(bag.frame(0), frames[0])


def test_depth_that_was_not_measured_is_far(tmp_path: Path) -> None:
    frames = make_frames(1)
    metres = np.full(SIZE, 100, dtype=np.float32)
    metres[0, :5] = np.nan, np.inf, -np.inf, 1500, -3
    rows = rows_of(frames)
    rows[1] = ("/depth_raw", STAMPS[0], image_message(metres, "32FC1", STAMPS[0]))
    with read_bag(record(tmp_path / "bag", rows)) as bag:
        depth = bag.frame(0).depth
    assert depth[0, :5].tolist() == [65535, 65535, 0, 65535, 0]
    assert set(depth[1:].ravel().tolist()) == {6554}


def _png(array: npt.NDArray[Any]) -> bytes:
    return bytes(cv2.imencode(".png", array)[1])


@pytest.mark.parametrize("suffixes", [("", "", ""), ("/compressed", "/compressedDepth", "/compressed")])
def test_compressed_images_are_read(tmp_path: Path, suffixes: tuple[str, str, str]) -> None:
    frames = make_frames(2)
    header = bytes(12) if suffixes[1] else b""
    rows: Rows = []
    for frame, stamp in zip(frames, STAMPS, strict=False):
        colour, depth, labels = (_png(image) for image in (frame.rgb, frame.depth, frame.labels))
        images = (
            compressed_message(colour, "rgb8; png compressed bgr8", stamp),
            compressed_message(header + depth, "16UC1; compressedDepth png", stamp),
            compressed_message(labels, "mono8; png compressed ", stamp),
        )
        topics = zip(("/rgb_raw", "/depth_raw", "/gt_segmentation"), suffixes, images, strict=True)
        rows += [(topic + suffix, stamp, image) for topic, suffix, image in topics]
    with read_bag(record(tmp_path / "bag", rows)) as bag:
        assert all(_equal(bag.frame(index), frames[index]) for index in range(2))
        assert set(bag.topics) == {row[0] for row in rows}
        assert bag.topics["/rgb_raw" + suffixes[0]] == (COMPRESSED, 2)


def _depth_as(rows: Rows, suffix: str, make: Callable[[npt.NDArray[Any]], bytes], text: str) -> Rows:
    pictures = [
        make(message.data.view("<u2").reshape(SIZE)) for topic, _, message in rows if topic == "/depth_raw"
    ]
    return [
        ("/depth_raw" + suffix, stamp, compressed_message(picture, text, stamp))
        for picture, stamp in zip(pictures, STAMPS, strict=True)
    ]


def _jpeg(array: npt.NDArray[Any]) -> bytes:
    return bytes(cv2.imencode(".jpg", (array >> 8).astype(np.uint8))[1])


@pytest.mark.parametrize("counted", [True, False])
def test_the_transport_of_depth_that_keeps_it_is_read(tmp_path: Path, counted: bool) -> None:
    frames = make_frames()
    rows = rows_of(frames)
    useless = _depth_as(rows, "/compressed", _jpeg, "16UC1; jpeg compressed ")
    useful = _depth_as(rows, "/compressedDepth", _png, "16UC1; compressedDepth png")
    folder = record(tmp_path / "bag", [row for row in rows if row[0] != "/depth_raw"] + useless + useful)
    with read_bag(folder if counted else _edit(folder, _count(0))) as bag:
        assert all(_equal(bag.frame(index), frames[index]) for index in range(3))


@pytest.mark.parametrize("plugin", list(StoragePlugin))
@pytest.mark.parametrize("counted", [True, False])
def test_a_topic_without_messages_hides_no_other(
    tmp_path: Path, plugin: StoragePlugin, counted: bool
) -> None:
    frames = make_frames()
    rows = rows_of(frames)
    useful = _depth_as(rows, "/compressedDepth", _png, "16UC1; compressedDepth png")
    with Writer(tmp_path / "bag", version=9, storage_plugin=plugin) as writer:
        writer.add_connection("/depth_raw", IMAGE, typestore=STORE)
        connections = {
            topic: writer.add_connection(topic, kind, typestore=STORE)
            for topic, kind in (("/rgb_raw", IMAGE), ("/gt_segmentation", IMAGE), (useful[0][0], COMPRESSED))
        }
        for topic, time, message in rows + useful:
            if topic in connections:
                raw = STORE.serialize_cdr(message, message.__msgtype__)
                writer.write(connections[topic], time, raw)
    with read_bag(tmp_path / "bag" if counted else _edit(tmp_path / "bag", _count(0))) as bag:
        assert all(_equal(bag.frame(index), frames[index]) for index in range(3))


def test_a_jpeg_is_nearly_its_picture(tmp_path: Path) -> None:
    colour = np.zeros((64, 64, 3), dtype=np.uint8)
    colour[:32], colour[32:] = (200, 100, 50), (10, 60, 110)
    frame = Frame(colour, np.ones((64, 64), dtype=np.uint16), np.ones((64, 64), dtype=np.uint8))
    rows = rows_of([frame])
    jpeg = bytes(cv2.imencode(".jpg", colour)[1])
    rows[0] = ("/rgb_raw", STAMPS[0], compressed_message(jpeg, "rgb8; jpeg compressed bgr8", STAMPS[0]))
    with read_bag(record(tmp_path / "bag", rows)) as bag:
        error = np.abs(bag.frame(0).rgb.astype(int) - colour)
    assert error[:30].max() < 4
    assert error[34:].max() < 4


def test_images_are_paired_by_the_nearest_stamp_and_the_rest_is_dropped(tmp_path: Path) -> None:
    frames = make_frames(5)
    stamps = [10**18 + 10**8 * number for number in range(5)]
    rows = rows_of(frames, stamps)
    for number, late in ((1, 20_000_000), (4, -30_000_000), (7, 70_000_000)):
        stamp = rows[number][1] + late
        rows[number][2].header = header(stamp)
    del rows[11]  # the labels of frame 3
    rows += rows[11:13]  # colour and depth of frame 4 once more
    with read_bag(
        record(tmp_path / "bag", [rows[index] for index in np.random.default_rng(2).permutation(16)])
    ) as bag:
        assert bag.stamps_ns == (stamps[0], stamps[1], stamps[3], stamps[4])
        assert [_equal(bag.frame(at), frames[number]) for at, number in enumerate((0, 1, 3, 4))] == [
            True,
            True,
            False,  # it has no labels
            True,
        ]
        assert bag.unlabelled == 1
        assert bag.dropped == {"/rgb_raw": 2, "/depth_raw": 2, "/gt_segmentation": 1}


def test_a_bag_without_labels_is_read(tmp_path: Path) -> None:
    frames = make_frames()
    rows = [row for row in rows_of(frames) if row[0] != "/gt_segmentation"]
    with read_bag(record(tmp_path / "bag", rows)) as bag:
        assert bag.unlabelled == len(bag) == len(frames)
        assert np.array_equal(bag.frame(1).depth, frames[1].depth)
        assert not bag.frame(1).labels.any()
        assert "/gt_segmentation" not in bag.encodings


def test_labels_of_another_time_are_refused(tmp_path: Path) -> None:
    rows = rows_of(make_frames())
    for _, _, message in rows[2::3]:
        message.header.stamp.sec += 100
    with pytest.raises(DataError, match="one moment on all three topics, got none"):
        read_bag(record(tmp_path / "bag", rows))


def test_frames_are_resampled_to_the_size_that_is_asked_for(tmp_path: Path) -> None:
    frames = make_frames(2, (60, 80))
    folder = write_bag(tmp_path / "bag", frames, STAMPS[:2])
    with read_bag(folder, size=(9, 16)) as bag:
        assert (bag.size, bag.recorded_size) == ((9, 16), (60, 80))
        frame = bag.frame(1)
    # 16:9 of 80 x 60 is 80 x 45 in the middle: a factor of 5, from row 7
    middle = frames[1].rgb[7:52].reshape(9, 5, 16, 5, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(frame.rgb, middle, atol=0.51)
    np.testing.assert_array_equal(frame.depth, frames[1].depth[9:52:5, 2::5])
    np.testing.assert_array_equal(frame.labels, frames[1].labels[9:52:5, 2::5])
    with pytest.raises(ValueError, match="read-only"):
        frame.depth[0] = 0


def test_a_frame_that_is_not_there_is_an_index_error(tmp_path: Path) -> None:
    with read_bag(write_bag(tmp_path / "bag", make_frames(), STAMPS)) as bag:
        for index in (3, -1):
            with pytest.raises(IndexError, match=f"frames 0 to 2, got {index}"):
                bag.frame(index)


def test_an_image_that_was_damaged_after_the_bag_was_opened_is_named(tmp_path: Path) -> None:
    with read_bag(write_bag(tmp_path / "bag.mcap", make_frames(3, (60, 100)), STAMPS)) as bag:
        # larger than what is buffered
        data = bag.path.read_bytes()
        bag.path.write_bytes(data.replace(b"bgr8", b"bgr7"))
        with pytest.raises(DataError, match=r"image of frame 2 on /rgb_raw of the bag .* got 'bgr7'"):
            bag.frame(2)


@pytest.mark.parametrize("name", ["bag", "bag.mcap", "bag.db3"])
def test_an_open_bag_is_read_from_any_folder_and_moves_no_place_that_a_fork_shares(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_bag(Path(name), make_frames(3, (60, 100)), STAMPS)
    with read_bag(Path(name)) as bag:
        files = _open_files(tmp_path)
        assert [os.lseek(file, 0, os.SEEK_SET) for file in files] == [0]
        monkeypatch.chdir("/")
        for index in (2, 0, 1):
            assert bag.frame(index).rgb.shape == (*bag.size, 3)
        assert [os.lseek(file, 0, os.SEEK_CUR) for file in files] == [0]


def _open_files(folder: Path) -> list[int]:
    return sorted(
        int(link.name)
        for link in Path("/proc/self/fd").iterdir()
        if link.exists() and link.readlink().is_relative_to(folder) and link.resolve().is_file()
    )


def test_a_bag_that_was_cut_off_after_it_was_opened_says_so(tmp_path: Path) -> None:
    with read_bag(write_bag(tmp_path / "bag.mcap", make_frames(), STAMPS)) as bag:
        bag.path.write_bytes(b"")
        with pytest.raises(DataError, match=r"changed after it was opened: .*; open it again\.$"):
            bag.frame(0)


def test_a_closed_bag_says_so(tmp_path: Path) -> None:
    bag = read_bag(write_bag(tmp_path / "bag", make_frames(), STAMPS))
    bag.close()
    bag.close()
    with pytest.raises(DataError, match="not open"):
        bag.frame(0)


def _no_depth(rows: Rows) -> Rows:
    return [row for row in rows if row[0] != "/depth_raw"]


def _elsewhen(rows: Rows) -> Rows:
    for topic, _, message in rows:
        if topic == "/depth_raw":
            message.header.stamp.sec += 100
    return rows


def _other_encoding(rows: Rows) -> Rows:
    rows[3][2].encoding = "mono8"
    return rows


def _other_size(rows: Rows) -> Rows:
    wide = np.zeros((6, 11), dtype=np.uint8)
    rows[5] = (rows[5][0], rows[5][1], image_message(wide, "8UC1", rows[5][1]))
    return rows


def _short_data(rows: Rows) -> Rows:
    rows[0][2].data = rows[0][2].data[:-1]
    return rows


def _zero_width(rows: Rows) -> Rows:
    rows[0][2].width = rows[0][2].step = 0
    rows[0][2].data = rows[0][2].data[:0]
    return rows


def _class_indices(rows: Rows) -> Rows:
    rows[2][2].data = np.arange(60, dtype=np.uint8) % 28
    return rows


def _no_depth_measured(rows: Rows) -> Rows:
    nothing = np.full(SIZE, np.nan, dtype=np.float32)
    return [
        (topic, time, image_message(nothing, "32FC1", time) if topic == "/depth_raw" else message)
        for topic, time, message in rows
    ]


def _depth_in_a_dropped_image_only(rows: Rows) -> Rows:
    return [rows[1], rows[2], *_no_depth_measured(rows)[3:]]


def _jpeg_of_labels(rows: Rows) -> Rows:
    jpeg = bytes(cv2.imencode(".jpg", np.zeros(SIZE, dtype=np.uint8))[1])
    rows[2::3] = [
        ("/gt_segmentation", row[1], compressed_message(jpeg, "mono8; jpeg", row[1])) for row in rows[2::3]
    ]
    return rows


def _reciprocal_depth(rows: Rows) -> Rows:
    picture = _png(np.zeros(SIZE, dtype=np.uint16))
    rows[1::3] = [
        ("/depth_raw", row[1], compressed_message(picture, "32FC1; png", row[1])) for row in rows[1::3]
    ]
    return rows


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (_no_depth, "must have the topic /depth_raw, got /gt_segmentation, /rgb_raw"),
        (_elsewhen, "one moment on all three topics, got none"),
        (_other_encoding, "image 1 on /rgb_raw of the bag .* encoding bgr8, rgb8, .* got 'mono8'"),
        (_other_size, "size of those before it, 10x6, got 11x6"),
        (_short_data, "6 rows of at least 30 bytes, got 179 bytes"),
        (_zero_width, "at least one pixel"),
        (_class_indices, "SynDrone's label ids .* got 23, 24, 25, 26, 27"),
        (_no_depth_measured, "some depth below 1000 m on /depth_raw, got none"),
        (_depth_in_a_dropped_image_only, "some depth below 1000 m on /depth_raw, got none in any frame"),
        (_jpeg_of_labels, "of the kind 8-bit greyscale PNG, got 8-bit colour JPEG"),
        (_reciprocal_depth, "depth as it was measured, got '32FC1; png'"),
    ],
)
@pytest.mark.parametrize("plugin", list(StoragePlugin))
def test_a_bag_of_other_content_is_refused(
    tmp_path: Path, change: Any, message: str, plugin: StoragePlugin
) -> None:
    folder = record(tmp_path / "bag", change(rows_of(make_frames())), plugin)
    with pytest.raises(DataError, match=message) as caught:
        read_bag(folder)
    assert str(folder) in str(caught.value)
    assert str(caught.value).endswith(".")


def test_a_bag_without_messages_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="at least one frame"):
        read_bag(write_bag(tmp_path / "bag", [], []))


def test_packed_messages_are_read_whatever_their_folder_says(tmp_path: Path) -> None:
    frames = make_frames()
    folder = record(tmp_path / "bag", rows_of(frames), StoragePlugin.SQLITE3, CompressionMode.MESSAGE)
    _edit(folder, lambda metadata: metadata.update(compression_mode="", compression_format=""))
    for path in (folder, folder / "bag.db3"):
        with read_bag(path) as bag:
            assert np.array_equal(bag.frame(2).depth, frames[2].depth)


def test_another_message_type_is_refused(tmp_path: Path) -> None:
    kind = "std_msgs/msg/Empty"
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/rgb_raw", kind, typestore=STORE)
        writer.write(connection, 1, STORE.serialize_cdr(STORE.types[kind](), kind))
    with pytest.raises(DataError, match=rf"must have {IMAGE} or {COMPRESSED} on /rgb_raw, got {kind}"):
        read_bag(tmp_path / "bag")


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("missing", "give the folder"),
        ("empty", "metadata.yaml, got none: 'ros2 bag reindex' makes it"),
        ("stray.txt", "got '.txt'"),
        ("flight.mcap.zstd", "folder of a compressed bag"),
        ("old.bag", "rosbags-convert"),
    ],
)
def test_what_is_no_bag_is_refused(tmp_path: Path, name: str, remedy: str) -> None:
    path = tmp_path / name
    if name == "empty":
        path.mkdir()
    elif name != "missing":
        path.write_text("hello")
    with pytest.raises(DataError, match=remedy) as caught:
        read_bag(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("suffix", [".mcap", ".db3"])
@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.7, 0.9])
def test_a_truncated_file_is_refused(tmp_path: Path, suffix: str, share: float) -> None:
    path = write_bag(tmp_path / f"bag{suffix}", make_frames(3, (60, 100)), STAMPS)
    path.write_bytes(path.read_bytes()[: int(path.stat().st_size * share)])
    with pytest.raises(DataError, match=r"cannot be read|must have") as caught:
        read_bag(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("suffix", [".mcap", ".db3"])
def test_garbage_anywhere_is_refused_or_harmless(tmp_path: Path, suffix: str) -> None:
    path = write_bag(tmp_path / f"bag{suffix}", make_frames(), STAMPS)
    good, rng = path.read_bytes(), np.random.default_rng(1)
    refused = 0
    for _ in range(60):
        spoiled = bytearray(good)
        start = int(rng.integers(len(good) - 40))
        spoiled[start : start + 40] = rng.bytes(40)
        path.write_bytes(spoiled)
        try:
            with read_bag(path) as bag:
                for index in range(len(bag)):
                    bag.frame(index)
        except DataError:
            refused += 1
    assert refused > 5


@pytest.mark.parametrize(
    "text", ["", "{", "rosbag2_bagfile_information: 7", "rosbag2_bagfile_information: {version: 99}"]
)
def test_a_broken_metadata_file_is_refused(tmp_path: Path, text: str) -> None:
    folder = write_bag(tmp_path / "bag", make_frames(), STAMPS)
    (folder / "metadata.yaml").write_text(text)
    with pytest.raises(
        DataError,
        match=r"cannot be read as a rosbag2: .*; remove its metadata\.yaml and let 'ros2 bag reindex'",
    ):
        read_bag(folder)
    with read_bag(folder / "bag.mcap") as bag:
        assert len(bag) == 3


def test_a_file_that_lacks_its_end_is_refused_with_a_remedy(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "bag.mcap", make_frames(3, (60, 100)), STAMPS)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(DataError, match=r"it was cut off later: complete it with 'mcap recover'\."):
        read_bag(path)


def test_a_schema_that_is_not_of_ros_is_refused(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "bag.mcap", make_frames(), STAMPS)
    path.write_bytes(path.read_bytes().replace(b"ros2msg", b"unknown"))
    with pytest.raises(DataError, match=r"has an unknown 'unknown'; .* without topics that are not CDR\."):
        read_bag(path)


@pytest.mark.parametrize("name", ["flight.mcap", "flight.db3"])
def test_a_file_alone_is_written(tmp_path: Path, name: str) -> None:
    frames = make_frames()
    path = write_bag(tmp_path / "new" / name, frames, STAMPS)
    assert path.is_file()
    assert list(path.parent.iterdir()) == [path]
    with read_bag(path) as bag:
        assert all(_equal(bag.frame(index), frames[index]) for index in range(3))


def test_writing_over_something_is_refused(tmp_path: Path) -> None:
    write_bag(tmp_path / "bag", make_frames(), STAMPS)
    with pytest.raises(OutputError, match="exists"):
        write_bag(tmp_path / "bag", make_frames(), STAMPS)


def test_writing_where_nothing_can_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        write_bag(tmp_path / "file" / "bag", make_frames(), STAMPS)


@pytest.mark.parametrize("stamps", [STAMPS[:2], [*STAMPS, 2_000_000_000], [1, 1, 2], [-1, 2, 3], [3, 2, 1]])
def test_stamps_that_do_not_fit_leave_nothing_behind(tmp_path: Path, stamps: list[int]) -> None:
    with pytest.raises(InvalidInputError, match="stamp"):
        write_bag(tmp_path / "bag", make_frames(), stamps)
    assert list(tmp_path.iterdir()) == []
