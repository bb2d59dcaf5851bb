import json
from collections.abc import Callable
from pathlib import Path

import pytest
from msgspec.structs import replace
from tests.recording.runs import RUN

from sunset.errors import RecordError
from sunset.metrics import score
from sunset.recording import RecordWriter, read_messages, read_run, read_timeline, timeline_of
from sunset.recording.reader import first_difference
from sunset.recording.timelines import measured_topics
from sunset.system_interfaces.msg import Command
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.std_msgs.msg import String

Row = tuple[str, int, Message]
READERS = [read_messages, read_timeline]


def change_run(record: Path, **values: object) -> None:
    file = record / "run.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), **values}))


def test_messages_come_back_as_they_were_written(record: Path, rows: list[Row]) -> None:
    found = read_messages(record)
    assert [(one.topic, one.time_ns) for one in found] == [(topic, time_ns) for topic, time_ns, _ in rows]
    expected = [message for topic, _, message in rows if topic == "/seg_metrics"]
    assert [one.message for one in found if one.topic == "/seg_metrics"] == expected


def test_messages_may_be_limited_to_topics(record: Path) -> None:
    found = read_messages(record, ["/experiment/commands"])
    assert [type(one.message) for one in found] == [Command]


def test_where_records_begin_to_differ_is_told(tmp_path: Path) -> None:
    texts = {"a": "xyz", "same": "xyz", "changed": "xXz", "shorter": "xy", "none": ""}
    for name, content in texts.items():
        with RecordWriter(tmp_path / name) as writer:
            for number, text in enumerate(content):
                writer.write("/topic", 10**9 * (number + 3), String(data=text))
            writer.close(replace(RUN, start_ns=4 * 10**9))

    found = {name: first_difference(tmp_path / "a", tmp_path / name) for name in texts}

    assert found == {
        "a": "",
        "same": "",
        "changed": "first at 0.00 s on /topic",
        "shorter": "first at 1.00 s on /topic",
        "none": "first at -1.00 s on /topic",
    }
    assert first_difference(tmp_path / "shorter", tmp_path / "a") == found["shorter"]


def test_the_timeline_of_a_record_is_that_of_its_writer(tmp_path: Path, rows: list[Row]) -> None:
    run = replace(RUN, duration_s=5.0, period_s=0.2, expected_frames=50)
    with RecordWriter(tmp_path / "r") as writer:
        for row in rows:
            writer.write(*row)
        messages = writer.messages(measured_topics())
        live = timeline_of(run, messages)
        writer.close(run)
    stored = read_timeline(tmp_path / "r")
    assert (stored.duration_s, stored.period_s, stored.expected_frames) == (5.0, 0.2, 50)
    assert stored.thresholds == run.thresholds
    assert score(stored) == score(live)
    assert stored.message_times.keys() == live.message_times.keys()
    for topic, times in live.message_times.items():
        assert times.tolist() == stored.message_times[topic].tolist()


@pytest.mark.parametrize("read", [read_run, *READERS])
def test_a_folder_that_is_no_record_is_refused(tmp_path: Path, read: Callable[[Path], object]) -> None:
    with pytest.raises(RecordError, match=r"is not a complete record: there is no such folder"):
        read(tmp_path / "nothing")
    with pytest.raises(RecordError, match=r"is not a complete record: run\.json is missing"):
        read(tmp_path)
    (tmp_path / "bench.json").touch()
    with pytest.raises(RecordError, match="it is a campaign; name the folder of one of its runs"):
        read(tmp_path)


@pytest.mark.parametrize("read", [read_run, *READERS])
@pytest.mark.parametrize("text", ["", "{", "\xff", '{"record_version": 1', "[" * 100_000, '{"seed": NaN}'])
def test_a_damaged_run_file_is_refused(record: Path, read: Callable[[Path], object], text: str) -> None:
    (record / "run.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(RecordError, match=r"run\.json is damaged"):
        read(record)


@pytest.mark.parametrize("read", [read_run, *READERS])
@pytest.mark.parametrize("text", ["{}", '{"record_version": 2}'])
def test_a_record_of_another_version_is_refused(
    record: Path, read: Callable[[Path], object], text: str
) -> None:
    (record / "run.json").write_text(text)
    with pytest.raises(RecordError, match=r"is of version (None|2), expected 1"):
        read(record)


@pytest.mark.parametrize("read", [read_run, *READERS])
@pytest.mark.parametrize("text", ["[]", "3", "null"])
def test_a_run_file_that_is_not_an_object_is_refused(
    record: Path, read: Callable[[Path], object], text: str
) -> None:
    (record / "run.json").write_text(text)
    with pytest.raises(
        RecordError, match=r"run\.json must be an object, got (\[\]|3|None); restore the file"
    ):
        read(record)


def test_a_run_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run.json").mkdir()
    with pytest.raises(RecordError, match="cannot be read: Is a directory"):
        read_run(tmp_path)


@pytest.mark.parametrize("read", READERS)
def test_a_missing_bag_is_refused(record: Path, read: Callable[[Path], object]) -> None:
    (record / "messages.mcap").unlink()
    with pytest.raises(RecordError, match=r"incomplete: messages\.mcap is missing"):
        read(record)


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.6, 0.9, 0.999])
def test_a_truncated_bag_is_refused(record: Path, read: Callable[[Path], object], share: float) -> None:
    file = record / "messages.mcap"
    data = file.read_bytes()
    file.write_bytes(data[: int(share * len(data))])
    with pytest.raises(RecordError, match="is damaged"):
        read(record)


def flip(file: Path, data: bytes, place: int) -> None:
    file.write_bytes(data[:place] + bytes([data[place] ^ 0x55]) + data[place + 1 :])


@pytest.mark.parametrize("step", [211, pytest.param(53, marks=pytest.mark.thorough)])
def test_a_flipped_byte_is_refused_or_changes_nothing(record: Path, step: int) -> None:
    file = record / "messages.mcap"
    data = file.read_bytes()
    expected = read_messages(record)
    for place in range(0, len(data), step):
        flip(file, data, place)
        try:
            found = read_messages(record)
        except RecordError:
            continue
        assert found == expected


def test_a_flipped_byte_among_the_messages_is_refused(record: Path) -> None:
    file = record / "messages.mcap"
    data = file.read_bytes()
    chunk = 17 + int.from_bytes(data[9:17], "little")  # behind magic and header record
    size = int.from_bytes(data[chunk + 1 : chunk + 9], "little")
    for place in range(chunk + size * 2 // 3, chunk + size, 53):  # definitions come first, then messages
        flip(file, data, place)
        with pytest.raises(RecordError, match="is damaged"):
            read_messages(record)


def test_messages_of_another_record_are_refused(record: Path) -> None:
    change_run(record, digest="0" * 64)
    with pytest.raises(RecordError, match=r"run\.json gives the digest 000"):
        read_messages(record)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("duration_s", "20"),
        ("period_s", None),
        ("entropy_threshold", True),
        ("expected_frames", []),
        ("duration_s", 0),
        ("expected_frames", 2.5),
        ("period_s", 5e-324),
    ],
)
def test_a_run_file_without_a_number_for_the_timeline_is_refused(
    record: Path, key: str, value: object
) -> None:
    change_run(record, **{key: value})
    with pytest.raises(
        RecordError,
        match=rf"The {key} in .* must be a (whole )?number above 0(\.001)? and at most 1e\+06, got .*; restore the ",
    ):
        read_timeline(record)
