import hashlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from sunset.data import Frame, read_bag, write_bag
from sunset.errors import DataError, InvalidInputError, OutputError

STORE = get_typestore(Stores.ROS2_JAZZY)
IMAGE = "sensor_msgs/msg/Image"
SIZE = (6, 10)
STAMPS = [100_000_000, 200_000_000, 1_300_000_000]
Rows = list[tuple[str, int, Any]]


def _frames(count: int = 3, size: tuple[int, int] = SIZE) -> list[Frame]:
    rng = np.random.default_rng(0)
    return [
        Frame(
            rng.integers(0, 256, (*size, 3), dtype=np.uint8),
            rng.integers(0, 65536, size, dtype=np.uint16),
            rng.integers(0, 106, size, dtype=np.uint8),
        )
        for _ in range(count)
    ]


def _equal(one: Frame, other: Frame) -> bool:
    pairs = ((one.rgb, other.rgb), (one.depth, other.depth), (one.labels, other.labels))
    return all(a.dtype == b.dtype and np.array_equal(a, b) for a, b in pairs)


def _image(array: npt.NDArray[Any], encoding: str, stamp: int, **changes: Any) -> Any:
    types = STORE.types
    fields = {
        "header": types["std_msgs/msg/Header"](
            stamp=types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id=""
        ),
        "height": array.shape[0],
        "width": array.shape[1],
        "encoding": encoding,
        "is_bigendian": 0,
        "step": array.strides[0],
        "data": np.frombuffer(array.tobytes(), dtype=np.uint8),
    }
    return types[IMAGE](**{**fields, **changes})


def _rows(frames: Sequence[Frame]) -> Rows:
    return [
        row
        for frame, stamp in zip(frames, STAMPS, strict=False)
        for row in (
            ("/rgb_raw", stamp, _image(frame.rgb, "bgr8", stamp)),
            ("/depth_raw", stamp, _image(frame.depth, "16UC1", stamp)),
            ("/gt_segmentation", stamp, _image(frame.labels, "8UC1", stamp)),
        )
    ]


def _write(folder: Path, rows: Rows, plugin: StoragePlugin = StoragePlugin.MCAP) -> Path:
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        topics = dict.fromkeys(topic for topic, _, _ in rows)
        connections = {topic: writer.add_connection(topic, IMAGE, typestore=STORE) for topic in topics}
        for topic, time, message in rows:
            writer.write(connections[topic], time, STORE.serialize_cdr(message, IMAGE))
    return folder


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_what_was_written_is_read(tmp_path: Path, storage: str) -> None:
    frames = _frames()
    with read_bag(write_bag(tmp_path / "bag", frames, STAMPS, storage=storage)) as bag:
        assert len(bag) == 3
        assert bag.size == SIZE
        assert bag.stamps_ns == tuple(STAMPS)
        for index in (2, 0, 1, 1):
            assert _equal(bag.frame(index), frames[index])
        assert repr(bag) == f"BagReader({str(tmp_path / 'bag')!r}, frames=3, size=(6, 10))"


def test_a_standard_reader_reads_it(tmp_path: Path) -> None:
    frames = _frames()
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
    folder = write_bag(tmp_path / "bag", _frames(), STAMPS)
    with read_bag(folder / "bag.mcap") as bag:
        assert len(bag) == 3


def test_frames_of_a_bag_cannot_be_changed(tmp_path: Path) -> None:
    with read_bag(write_bag(tmp_path / "bag", _frames(), STAMPS)) as bag:
        frame = bag.frame(0)
    for image in (frame.rgb, frame.depth, frame.labels):
        with pytest.raises(ValueError, match="read-only"):
            image[0] = 0


def test_the_same_frames_give_the_same_bytes(tmp_path: Path) -> None:
    digests = set()
    for parent in ("a", "b"):
        folder = write_bag(tmp_path / parent / "bag", _frames(), STAMPS)
        files = sorted(folder.iterdir())
        digests.add(hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest())
    assert len(digests) == 1


def test_messages_are_paired_by_their_own_stamps_not_by_the_time_of_recording(tmp_path: Path) -> None:
    frames = _frames()
    late = {"/rgb_raw": 0, "/depth_raw": 7, "/gt_segmentation": 150_000_000}
    rows = [(topic, time + late[topic], message) for topic, time, message in _rows(frames)]
    with read_bag(_write(tmp_path / "bag", rows)) as bag:
        assert all(_equal(bag.frame(index), frames[index]) for index in range(3))


def test_other_topics_are_passed_over(tmp_path: Path) -> None:
    frames = _frames()
    rows = [*_rows(frames), ("/other", 5, _image(frames[0].rgb, "rgb8", 5))]
    with read_bag(_write(tmp_path / "bag", rows)) as bag:
        assert len(bag) == 3


def test_padded_rows_and_big_endian_depth_are_understood(tmp_path: Path) -> None:
    frames = _frames(1)
    rows = _rows(frames)
    padded = np.zeros((SIZE[0], 32), dtype=np.uint8)
    padded[:, :30] = frames[0].rgb.reshape(SIZE[0], 30)
    rows[0][2].step, rows[0][2].data = 32, padded.reshape(-1)
    rows[1][2].is_bigendian = 1
    rows[1][2].data = np.frombuffer(frames[0].depth.astype(">u2").tobytes(), dtype=np.uint8)
    with read_bag(_write(tmp_path / "bag", rows)) as bag:
        assert _equal(bag.frame(0), frames[0])


def test_a_frame_that_is_not_there_is_an_index_error(tmp_path: Path) -> None:
    with read_bag(write_bag(tmp_path / "bag", _frames(), STAMPS)) as bag:
        for index in (3, -1):
            with pytest.raises(IndexError, match=f"frames 0 to 2, got {index}"):
                bag.frame(index)


def test_a_closed_bag_says_so(tmp_path: Path) -> None:
    bag = read_bag(write_bag(tmp_path / "bag", _frames(), STAMPS))
    bag.close()
    bag.close()
    with pytest.raises(DataError, match="not open"):
        bag.frame(0)


def _no_depth(rows: Rows) -> Rows:
    return [row for row in rows if row[0] != "/depth_raw"]


def _one_less(rows: Rows) -> Rows:
    return rows[:-1]


def _other_stamp(rows: Rows) -> Rows:
    rows[4][2].header.stamp.nanosec += 1
    return rows


def _twice(rows: Rows) -> Rows:
    return [*rows[:3], *rows[:3]]


def _other_encoding(rows: Rows) -> Rows:
    rows[3][2].encoding = "rgb8"
    return rows


def _other_size(rows: Rows) -> Rows:
    wide = np.zeros((6, 11), dtype=np.uint8)
    rows[5] = (rows[5][0], rows[5][1], _image(wide, "8UC1", rows[5][1]))
    return rows


def _short_data(rows: Rows) -> Rows:
    rows[0][2].data = rows[0][2].data[:-1]
    return rows


def _zero_width(rows: Rows) -> Rows:
    rows[0][2].width = rows[0][2].step = 0
    rows[0][2].data = rows[0][2].data[:0]
    return rows


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (_no_depth, "must have the topic /depth_raw, got /gt_segmentation, /rgb_raw"),
        (_one_less, "3 on /rgb_raw, 3 on /depth_raw, 2 on /gt_segmentation"),
        (_other_stamp, "on /depth_raw, got 200000001 ns for 200000000 ns at frame 1"),
        (_twice, "every stamp once, got 100000000 ns twice"),
        (_other_encoding, "encoding bgr8 in message 1 on /rgb_raw, got 'rgb8'"),
        (_other_size, "one size, 10x6, got 11x6 on /gt_segmentation at frame 1"),
        (_short_data, "6 rows of at least 30 bytes in message 0 on /rgb_raw, got 179 bytes"),
        (_zero_width, "rows of at least 0 bytes"),
    ],
)
@pytest.mark.parametrize("plugin", list(StoragePlugin))
def test_a_bag_of_other_content_is_refused(
    tmp_path: Path, change: Any, message: str, plugin: StoragePlugin
) -> None:
    folder = _write(tmp_path / "bag", change(_rows(_frames())), plugin)
    with pytest.raises(DataError, match=message) as caught:
        read_bag(folder)
    assert str(folder) in str(caught.value)
    assert str(caught.value).endswith(".")


def test_a_bag_without_messages_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="at least one frame"):
        read_bag(write_bag(tmp_path / "bag", [], []))


def test_another_message_type_is_refused(tmp_path: Path) -> None:
    kind = "std_msgs/msg/Empty"
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/rgb_raw", kind, typestore=STORE)
        writer.write(connection, 1, STORE.serialize_cdr(STORE.types[kind](), kind))
    with pytest.raises(DataError, match=rf"must have {IMAGE} on /rgb_raw, got {kind}"):
        read_bag(tmp_path / "bag")


def _broken(folder: Path) -> Iterator[tuple[str, Path]]:
    yield "missing", folder.parent / "nowhere"
    empty = folder.parent / "empty"
    empty.mkdir()
    yield "empty folder", empty
    stray = folder.parent / "stray.txt"
    stray.write_text("hello")
    yield "no bag", stray


def test_what_is_no_bag_is_refused(tmp_path: Path) -> None:
    for _, path in _broken(tmp_path / "bag"):
        with pytest.raises(DataError, match=str(path)):
            read_bag(path)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.7, 0.99])
def test_a_truncated_file_is_refused(tmp_path: Path, storage: str, share: float) -> None:
    folder = write_bag(tmp_path / "bag", _frames(3, (60, 100)), STAMPS, storage=storage)
    path = next(path for path in folder.iterdir() if path.suffix in {".mcap", ".db3"})
    path.write_bytes(path.read_bytes()[: int(path.stat().st_size * share)])
    with pytest.raises(DataError, match=r"cannot be read|must have") as caught:
        read_bag(folder)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_garbage_anywhere_is_refused_or_harmless(tmp_path: Path, storage: str) -> None:
    folder = write_bag(tmp_path / "bag", _frames(), STAMPS, storage=storage)
    path = next(path for path in folder.iterdir() if path.suffix in {".mcap", ".db3"})
    good, rng = path.read_bytes(), np.random.default_rng(1)
    refused = 0
    for _ in range(60):
        spoiled = bytearray(good)
        start = int(rng.integers(len(good) - 40))
        spoiled[start : start + 40] = rng.bytes(40)
        path.write_bytes(spoiled)
        try:
            with read_bag(folder) as bag:
                for index in range(len(bag)):
                    bag.frame(index)
        except DataError:
            refused += 1
    assert refused > 5


@pytest.mark.parametrize(
    "text", ["", "{", "rosbag2_bagfile_information: 7", "rosbag2_bagfile_information: {version: 99}"]
)
def test_a_broken_metadata_file_is_refused(tmp_path: Path, text: str) -> None:
    folder = write_bag(tmp_path / "bag", _frames(), STAMPS)
    (folder / "metadata.yaml").write_text(text)
    with pytest.raises(DataError, match="cannot be read as a rosbag2"):
        read_bag(folder)


def test_writing_over_something_is_refused(tmp_path: Path) -> None:
    write_bag(tmp_path / "bag", _frames(), STAMPS)
    with pytest.raises(OutputError, match="exists"):
        write_bag(tmp_path / "bag", _frames(), STAMPS)


def test_writing_where_nothing_can_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        write_bag(tmp_path / "file" / "bag", _frames(), STAMPS)


@pytest.mark.parametrize("stamps", [STAMPS[:2], [*STAMPS, 2_000_000_000], [1, 1, 2], [-1, 2, 3], [3, 2, 1]])
def test_stamps_that_do_not_fit_leave_nothing_behind(tmp_path: Path, stamps: list[int]) -> None:
    with pytest.raises(InvalidInputError, match="stamp"):
        write_bag(tmp_path / "bag", _frames(), stamps)
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_storage_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match="mcap or sqlite3, got 'zip'"):
        write_bag(tmp_path / "bag", _frames(), STAMPS, storage="zip")
