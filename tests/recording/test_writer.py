import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml
from msgspec.structs import replace
from rosbags.highlevel import AnyReader
from tests.recording.runs import RUN

from sunset.errors import InterfaceError, OutputError
from sunset.recording import RecordWriter, read_messages, read_run
from sunset.system_interfaces.msg import FusionType, ImageDigest, SensorFusion
from sunset_ros.interfaces import Message, deserialize, get_message, type_hash
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header, String

Row = tuple[str, int, Message]
FILES = ["messages.mcap", "metadata.yaml", "run.json"]


def contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in sorted(folder.iterdir())}


def written(folder: Path, *messages: Message) -> list[Message]:
    with RecordWriter(folder) as writer:
        for message in messages:
            writer.write("/topic", 0, message)
        writer.close(RUN)
    return [recorded.message for recorded in read_messages(folder)]


def test_a_record_is_a_bag_and_a_run_file(record: Path) -> None:
    assert sorted(file.name for file in record.iterdir()) == FILES
    assert [path.name for path in record.parent.iterdir()] == ["record"]


def test_an_independent_reader_opens_the_bag(record: Path, rows: list[Row]) -> None:
    with AnyReader([record]) as reader:
        found = [(connection.topic, time) for connection, time, _ in reader.messages()]
        hashes = {connection.msgtype: connection.digest for connection in reader.connections}
        evaluations = [c for c in reader.connections if c.topic == "/seg_metrics"]
        raw = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(evaluations)]
    stored = [
        (f"{topic}/digest" if isinstance(message, Image | SensorFusion) else topic, time_ns)
        for topic, time_ns, message in rows
    ]
    assert found == stored  # a topic of images has images in every bag
    assert hashes == {name: type_hash(get_message(name)) for name in hashes}
    assert len(hashes) == 6
    assert raw[3].intersection.tolist() == list(range(3, 31))  # type: ignore[attr-defined]


def test_the_metadata_are_as_ros_2_writes_them(record: Path) -> None:
    metadata = yaml.safe_load((record / "metadata.yaml").read_text("utf-8"))["rosbag2_bagfile_information"]
    topics = [topic["topic_metadata"] for topic in metadata["topics_with_message_count"]]
    assert metadata["ros_distro"] == "jazzy"
    # `ros2 bag play` offers the default quality of service for them
    assert all(topic["offered_qos_profiles"] == [] for topic in topics)


def test_messages_are_stored_in_order_of_time_and_then_of_writing(tmp_path: Path) -> None:
    with RecordWriter(tmp_path / "r") as writer:
        for time_ns, text in [(5, "late"), (1, "first"), (1, "second"), (3, "middle"), (1, "third")]:
            writer.write("/topic", time_ns, String(data=text))
        writer.close(RUN)
    found = [recorded.message for recorded in read_messages(tmp_path / "r")]
    assert found == [String(data=text) for text in ("first", "second", "third", "middle", "late")]


def test_messages_of_equal_time_keep_their_order_across_topics(tmp_path: Path) -> None:
    topics = ["/b", "/a", "/c", "/a"]
    with RecordWriter(tmp_path / "r") as writer:
        writer.write("/late", 5, String())
        for topic in topics:
            writer.write(topic, 1, String())
        writer.close(RUN)
    assert [recorded.topic for recorded in read_messages(tmp_path / "r")] == [*topics, "/late"]


def test_messages_of_equal_time_keep_their_order_in_a_long_record(tmp_path: Path) -> None:
    texts = [f"{number:06}" + "x" * 1000 for number in range(3000)]  # several chunks
    found = written(tmp_path / "r", *(String(data=text) for text in texts))
    assert found == [String(data=text) for text in texts]


def test_the_same_messages_leave_the_same_bytes_whatever_the_folder(
    tmp_path: Path, rows: list[Row], write_record: Callable[[Path, list[Row]], Path]
) -> None:
    first = write_record(tmp_path / "one", rows)
    second = write_record(tmp_path / "deep" / "er" / "another name", rows)
    assert contents(first) == contents(second)


@pytest.mark.thorough
def test_the_same_messages_leave_the_same_bytes_in_another_process(tmp_path: Path) -> None:
    code = """
import sys
from pathlib import Path
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header, String
from msgspec.structs import replace
from sunset.recording import RecordWriter
from tests.recording.runs import RUN
with RecordWriter(Path(sys.argv[1])) as writer:
    for number in range(200):
        writer.write("/b", number, Parameter(name=str(number)))
        writer.write("/a", number, String(data="text"))
        writer.write("/image", number, Image(header=Header(frame_id="c"), data=[number] * 10))
    writer.close(replace(RUN, metrics={"y": 0.1, "x": None}))
"""
    folders = []
    for seed in ("0", "1", "4711"):
        folders.append(tmp_path / seed)
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        subprocess.run([sys.executable, "-c", code, folders[-1]], env=environment, check=True)
    assert contents(folders[0]) == contents(folders[1]) == contents(folders[2])


def test_the_digest_is_over_topic_type_time_and_bytes(tmp_path: Path) -> None:
    cdr = bytes.fromhex("000100000200000061000000")
    expected = hashlib.sha256(b"/t std_msgs/msg/String 7 12\n" + cdr).hexdigest()
    with RecordWriter(tmp_path / "r") as writer:
        writer.write("/t", 7, String(data="a"))
        assert writer.digest == expected
        writer.close(RUN)
    assert read_run(tmp_path / "r").digest == expected


@pytest.mark.parametrize(
    ("topic", "time_ns", "message"),
    [
        ("/t", 1, String(data="b")),
        ("/t", 2, String(data="a")),
        ("/u", 1, String(data="a")),
        ("/t", 1, Header()),
    ],
)
def test_the_digest_tells_records_apart(tmp_path: Path, topic: str, time_ns: int, message: Message) -> None:
    with RecordWriter(tmp_path / "a") as first, RecordWriter(tmp_path / "b") as second:
        first.write("/t", 1, String(data="a"))
        second.write(topic, time_ns, message)
        assert first.digest != second.digest


def test_the_run_file_is_canonical_json(tmp_path: Path) -> None:
    run = replace(RUN, scenario="größer", metrics={"b": 2.5, "a": None})
    with RecordWriter(tmp_path / "r") as writer:
        digest = writer.digest
        writer.close(run)
    text = (tmp_path / "r" / "run.json").read_text()
    assert text.endswith("}\n")
    assert list(json.loads(text)) == sorted(json.loads(text))
    assert list(json.loads(text)["metrics"]) == ["a", "b"]
    assert "größer" in text
    assert "start_ns" not in text  # nor is anything else that the run has not
    assert read_run(tmp_path / "r") == replace(run, digest=digest, record_version=1)


def test_an_image_is_stored_as_the_digest_of_its_pixels(tmp_path: Path) -> None:
    pixels = np.arange(24, dtype=np.uint8)
    image = Image(header=Header(frame_id="c"), height=4, width=2, encoding="bgr8", data=pixels)
    expected = ImageDigest(
        header=Header(frame_id="c"),
        height=4,
        width=2,
        encoding="bgr8",
        digest=hashlib.blake2b(pixels.tobytes(), digest_size=16).digest(),
    )
    assert written(tmp_path / "r", image) == [expected]


def digest_of(tmp_path: Path, message: Message) -> list[int]:
    (found,) = written(tmp_path / f"r{len(list(tmp_path.iterdir()))}", message)
    assert isinstance(found, ImageDigest)
    return list(found.digest)


def test_a_fused_pair_is_told_apart_by_either_image_and_the_modality(tmp_path: Path) -> None:
    one, other = Image(data=[1]), Image(data=[2])
    digests = [
        digest_of(tmp_path, SensorFusion(rgb=rgb, depth=depth, modality=FusionType(fusion_type=modality)))
        for rgb in (one, other)
        for depth in (one, other)
        for modality in (0, 1, 2)
    ]
    assert len({tuple(digest) for digest in digests}) == 12
    again = SensorFusion(rgb=one, depth=one, header=Header(frame_id="f"))
    assert digest_of(tmp_path, again) == digests[0]


def test_an_array_that_is_reused_with_other_pixels_has_another_digest(tmp_path: Path) -> None:
    pixels = np.zeros(8, np.uint8)
    with RecordWriter(tmp_path / "r") as writer:
        writer.write("/t", 0, Image(data=pixels))
        pixels[0] = 1
        writer.write("/t", 1, Image(data=pixels))
        writer.close(RUN)
    first, second = (recorded.message for recorded in read_messages(tmp_path / "r"))
    assert first != second


def test_digests_are_right_for_more_arrays_than_are_remembered(tmp_path: Path) -> None:
    images = [Image(data=np.full(8, number, np.uint8)).copy() for number in range(100)]
    digests = written(tmp_path / "r", *images, *images)
    assert digests[:100] == digests[100:]
    assert len({message.digest.tobytes() for message in digests if isinstance(message, ImageDigest)}) == 100


def test_a_message_may_be_changed_after_it_was_written(tmp_path: Path) -> None:
    message = String(data="before")
    with RecordWriter(tmp_path / "r") as writer:
        writer.write("/t", 0, message)
        message.data = "after"
        writer.close(RUN)
    assert read_messages(tmp_path / "r")[0].message == String(data="before")


def test_a_record_without_messages_can_be_read(tmp_path: Path) -> None:
    assert written(tmp_path / "r") == []


def test_a_message_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    with RecordWriter(tmp_path / "r") as writer, pytest.raises(InterfaceError, match="'data'"):
        writer.write("/t", 0, String(data=3))  # type: ignore[arg-type]


def test_an_interrupted_run_leaves_nothing(tmp_path: Path) -> None:
    def interrupted() -> None:
        with RecordWriter(tmp_path / "r") as writer:
            writer.write("/t", 0, String())
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_run_left_is_replaced(tmp_path: Path) -> None:
    (tmp_path / ".r.partial" / "messages").mkdir(parents=True)
    (tmp_path / ".r.partial" / "messages" / "messages.mcap").touch()
    assert written(tmp_path / "r", String(data="a")) == [String(data="a")]
    assert [path.name for path in tmp_path.iterdir()] == ["r"]


def test_two_that_write_to_one_folder_do_not_take_it_from_each_other(tmp_path: Path) -> None:
    with RecordWriter(tmp_path / "run") as first:
        with pytest.raises(OutputError, match=r"Another process writes the record .*/run: name another"):
            RecordWriter(tmp_path / "run")
        first.close(RUN)

    assert read_run(tmp_path / "run")


def test_an_existing_record_is_not_overwritten(record: Path) -> None:
    before = contents(record)
    with pytest.raises(OutputError, match="exists already; remove it or name another folder"):
        RecordWriter(record)
    assert contents(record) == before


def test_an_empty_folder_may_become_the_record(tmp_path: Path) -> None:
    (tmp_path / "r").mkdir()
    assert written(tmp_path / "r", String(data="a")) == [String(data="a")]


def test_a_folder_that_cannot_be_made_is_an_output_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"The record .*/file/r cannot be written: Not a directory"):
        RecordWriter(tmp_path / "file" / "r")


def test_the_root_of_all_folders_is_no_record() -> None:
    with pytest.raises(OutputError, match=r"A record needs a folder of its own, got /\."):
        RecordWriter(Path("/"))


def test_a_record_that_appeared_meanwhile_is_not_overwritten(tmp_path: Path) -> None:
    with RecordWriter(tmp_path / "r") as writer:
        (tmp_path / "r").mkdir()
        (tmp_path / "r" / "mine").write_text("kept")
        with pytest.raises(OutputError, match="cannot be written"):
            writer.close(RUN)
    assert contents(tmp_path / "r") == {"mine": b"kept"}
    assert [path.name for path in tmp_path.iterdir()] == ["r"]


@pytest.mark.skipif(sys.platform == "win32", reason="has no limit on file sizes")
def test_a_full_disk_is_an_output_error_and_leaves_nothing(tmp_path: Path) -> None:
    code = """
import resource, sys
from pathlib import Path
from sunset.errors import OutputError
from sunset_ros.interfaces.std_msgs.msg import String
from sunset.recording import RecordWriter
import numpy as np
from tests.recording.runs import RUN
texts = [np.random.default_rng(i).bytes(500).hex() for i in range(100)]
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    with RecordWriter(Path(sys.argv[1])) as writer:
        for text in texts:
            writer.write("/t", 0, String(data=text))
        writer.close(RUN)
except OutputError as error:
    print(error)
"""
    command = [sys.executable, "-c", code, str(tmp_path / "r")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "cannot be written: File too large; free some space" in done.stdout
    assert done.stderr == ""
    assert list(tmp_path.iterdir()) == []


def test_recorded_bytes_are_those_of_the_message(record: Path, rows: list[Row]) -> None:
    with AnyReader([record]) as reader:
        raw = [
            deserialize(cdr, get_message(connection.msgtype))
            for connection, _, cdr in reader.messages()
            if connection.topic == "/experiment/commands"
        ]
    assert raw == [message for topic, _, message in rows if topic == "/experiment/commands"]
