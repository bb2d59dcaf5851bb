from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from rosbags.highlevel import AnyReader
from tests.recording.runs import RUN

from sunset.classes import CARLA_IDS, COLOURS
from sunset.errors import RecordError
from sunset.recording import RecordWriter, StoredImage, read_images, read_run
from sunset.system_interfaces.msg import SensorFusion, SetBlackboardGroup
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter, ParameterValue
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header

GENERATOR = np.random.default_rng(1)
BGR = GENERATOR.integers(0, 256, (6, 8, 3), dtype=np.uint8)
DEPTH = GENERATOR.integers(0, 65536, (6, 8), dtype=np.uint16)
LABELS = GENERATOR.integers(0, 28, (6, 8), dtype=np.uint8)
TRUTH = np.array(list(CARLA_IDS.values()), np.uint8)[LABELS]
HEADER = Header(stamp=Time(sec=3, nanosec=500))


def image(pixels: npt.NDArray[np.generic], encoding: str) -> Image:
    data = pixels.view(np.uint8).reshape(-1)
    height, width = pixels.shape[:2]
    return Image(
        header=HEADER, height=height, width=width, encoding=encoding, step=data.size // height, data=data
    )


def record(folder: Path, *messages: tuple[str, Message], images: bool = True) -> Path:
    with RecordWriter(folder, images=images) as writer:
        for number, (topic, message) in enumerate(messages):
            writer.write(topic, number, message)
        writer.close(RUN)
    return folder


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    numbers = [
        Parameter(name="entropy", value=ParameterValue(type=3, double_value=0.25)),
        Parameter(name="camera_autofocus_needed", value=ParameterValue(type=1, bool_value=True)),
        Parameter(name="frames", value=ParameterValue(type=2, integer_value=7)),
        Parameter(name="text", value=ParameterValue(type=4, string_value="no number")),
    ]
    fused = SensorFusion(header=HEADER, rgb=image(BGR, "bgr8"), depth=image(DEPTH, "16UC1"))
    return record(
        tmp_path_factory.mktemp("images") / "kept",
        ("/gt_segmentation", image(TRUTH, "8UC1")),
        ("/managed_subsystem/sensors_fused", fused),
        ("/managed_subsystem/segmentation", image(LABELS, "8UC1")),
        ("/infrared", image(DEPTH.view(np.float16), "16FC1")),
        ("/blackboard_group", SetBlackboardGroup(bb_params=numbers)),
    )


def test_what_was_kept_comes_back_to_the_bit(kept: Path) -> None:
    found = {one.topic: one for one in read_images(kept)}

    assert {topic: one.encoding for topic, one in found.items()} == {
        "/gt_segmentation": "8UC1",
        "/managed_subsystem/sensors_fused/rgb": "bgr8",
        "/managed_subsystem/sensors_fused/depth": "16UC1",
        "/managed_subsystem/segmentation": "8UC1",
    }
    expected: dict[str, npt.NDArray[np.generic]] = {
        "/gt_segmentation": TRUTH,
        "/managed_subsystem/sensors_fused/rgb": BGR,
        "/managed_subsystem/sensors_fused/depth": DEPTH,
        "/managed_subsystem/segmentation": LABELS,
    }
    for topic, pixels in expected.items():
        assert found[topic].pixels.dtype == pixels.dtype
        np.testing.assert_array_equal(found[topic].pixels, pixels)
        assert found[topic].stamp_ns == 3 * 10**9 + 500
    assert [one.time_ns for one in found.values()] == [0, 1, 1, 2]


def test_another_reader_sees_labels_in_colours_and_each_number_on_a_topic(kept: Path) -> None:
    with AnyReader([kept / "images.mcap"]) as reader:
        found = {
            connection.topic: reader.deserialize(raw, connection.msgtype)
            for connection, _, raw in reader.messages()
        }

    for topic in ("/gt_segmentation/compressed", "/managed_subsystem/segmentation/compressed"):
        shown = cv2.imdecode(found[topic].data, cv2.IMREAD_COLOR_RGB)  # type: ignore[attr-defined]
        np.testing.assert_array_equal(shown, np.array(COLOURS, np.uint8)[LABELS])
    assert found["/infrared"].encoding == "16FC1"  # type: ignore[attr-defined]
    numbers = {
        topic: message.data  # type: ignore[attr-defined]
        for topic, message in found.items()
        if topic.startswith("/symptoms/")
    }
    assert numbers == {
        "/symptoms/entropy": 0.25,
        "/symptoms/camera_autofocus_needed": 1.0,
        "/symptoms/frames": 7.0,
    }


def test_the_record_is_the_same_with_and_without_its_images(kept: Path, tmp_path: Path) -> None:
    messages = ("/a", image(BGR, "bgr8")), ("/b", image(DEPTH, "16UC1"))
    with_images, without = (
        record(tmp_path / name, *messages, images=name == "with") for name in ("with", "without")
    )

    assert {file.name for file in with_images.iterdir()} - {file.name for file in without.iterdir()} == {
        "images.mcap"
    }
    for file in without.iterdir():
        assert file.read_bytes() == (with_images / file.name).read_bytes()
    with pytest.raises(RecordError, match=r"has no images: run it with --images"):
        list(read_images(without))
    assert read_run(kept).digest


@pytest.mark.parametrize(
    "odd",
    [
        Image(header=HEADER, height=6, width=8, encoding="bgr8", step=24, data=np.zeros(10, np.uint8)),
        Image(header=HEADER, height=6, width=8, encoding="bgr8", step=3, data=np.zeros(144, np.uint8)),
        Image(header=HEADER, encoding="8UC1"),
    ],
    ids=["too little data", "rows that overlap", "empty"],
)
def test_an_image_that_is_not_one_is_kept_as_it_is(odd: Image, tmp_path: Path) -> None:
    folder = record(tmp_path / "odd", ("/odd", odd))

    with AnyReader([folder / "images.mcap"]) as reader:
        assert [connection.topic for connection, _, _ in reader.messages()] == ["/odd"]


def test_the_same_bytes_in_rows_of_another_length_are_another_image(tmp_path: Path) -> None:
    data = np.arange(48, dtype=np.uint8)
    wide, padded = (
        Image(header=HEADER, height=48 // step, width=6, encoding="8UC1", step=step, data=data)
        for step in (6, 12)
    )

    found = read_images(record(tmp_path / "record", ("/wide", wide), ("/padded", padded)))

    assert [one.pixels.shape for one in found] == [(8, 6), (4, 6)]


def test_padded_rows_are_kept_without_their_padding(tmp_path: Path) -> None:
    rows = np.hstack([BGR.reshape(6, 24), np.full((6, 4), 99, np.uint8)])
    padded = Image(header=HEADER, height=6, width=8, encoding="bgr8", step=28, data=rows.reshape(-1))

    (found,) = read_images(record(tmp_path / "padded", ("/padded", padded)))

    np.testing.assert_array_equal(found.pixels, BGR)


def test_what_is_damaged_is_said_in_a_sentence(kept: Path, tmp_path: Path) -> None:
    (tmp_path / "images.mcap").write_bytes((kept / "images.mcap").read_bytes()[:400])

    with pytest.raises(RecordError, match=r"images\.mcap is damaged"):
        list(read_images(tmp_path))
    with pytest.raises(RecordError, match="The image on /a at 5 ns is damaged"):
        _ = StoredImage("/a", 5, 0, "bgr8", b"\x89PNG" + bytes(40)).pixels


@pytest.mark.parametrize("png", [b"", b"\x89PNG\r\n", cv2.imencode(".png", LABELS)[1].tobytes()])
def test_a_picture_of_another_kind_is_damaged(png: bytes) -> None:
    with pytest.raises(RecordError, match="The image on /a at 5 ns is damaged"):
        _ = StoredImage("/a", 5, 0, "bgr8", png).pixels


def test_what_is_kept_as_it_is_may_have_any_name(tmp_path: Path) -> None:
    messages = ("/a/compressed", image(DEPTH.view(np.float16), "16FC1")), ("/b", image(DEPTH, "16UC1"))

    assert [one.topic for one in read_images(record(tmp_path / "named", *messages))] == ["/b"]


def test_a_record_that_is_given_up_leaves_no_open_file(tmp_path: Path) -> None:
    def opened() -> list[str]:
        return [str(file.readlink()) for file in Path("/proc/self/fd").iterdir() if file.is_symlink()]

    with RecordWriter(tmp_path / "record", images=True) as writer:
        writer.write("/a", 0, image(BGR, "bgr8"))
        assert any("images.mcap" in file for file in opened())
        writer.abort()
        assert not any("images.mcap" in file for file in opened())
    assert list(tmp_path.iterdir()) == []
