"""Recordings and folders for tests, made by other means than the code that reads them."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from sunset.classes import CARLA_IDS
from sunset.data import Frame
from sunset_ros.seeding import generator

STORE = get_typestore(Stores.ROS2_JAZZY)
IMAGE = "sensor_msgs/msg/Image"
COMPRESSED = "sensor_msgs/msg/CompressedImage"
IDS = np.array([0, 4, 10, 255, *CARLA_IDS.values()], dtype=np.uint8)
SIZE = (6, 10)
STAMPS = [100_000_000, 200_000_000, 1_300_000_000]
Rows = list[tuple[str, int, Any]]
"""Topic, time of recording in nanoseconds, message."""

FLIGHT = Path("Town01_Opt_120", "ClearNoon", "height50m")
BLOCK = 15
"""Pixels of SynDrone's that are alike in these pictures: 128 x 72 blocks a frame."""


def make_frames(count: int = 3, size: tuple[int, int] = SIZE) -> list[Frame]:
    rng = np.random.default_rng(0)
    return [
        Frame(
            rng.integers(0, 256, (*size, 3), dtype=np.uint8),
            rng.integers(0, 65536, size, dtype=np.uint16),
            rng.choice(IDS, size),
        )
        for _ in range(count)
    ]


def header(stamp: int) -> Any:
    types = STORE.types
    time = types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
    return types["std_msgs/msg/Header"](stamp=time, frame_id="")


def image_message(array: npt.NDArray[Any], encoding: str, stamp: int, **changes: Any) -> Any:
    fields = {
        "header": header(stamp),
        "height": array.shape[0],
        "width": array.shape[1],
        "encoding": encoding,
        "is_bigendian": 0,
        "step": array.strides[0],
        "data": np.frombuffer(array.tobytes(), dtype=np.uint8),
    }
    return STORE.types[IMAGE](**{**fields, **changes})


def compressed_message(data: bytes, text: str, stamp: int) -> Any:
    return STORE.types[COMPRESSED](
        header=header(stamp), format=text, data=np.frombuffer(data, dtype=np.uint8)
    )


def rows_of(frames: Sequence[Frame], stamps: Sequence[int] = STAMPS) -> Rows:
    return [
        row
        for frame, stamp in zip(frames, stamps, strict=False)
        for row in (
            ("/rgb_raw", stamp, image_message(frame.rgb, "bgr8", stamp)),
            ("/depth_raw", stamp, image_message(frame.depth, "16UC1", stamp)),
            ("/gt_segmentation", stamp, image_message(frame.labels, "8UC1", stamp)),
        )
    ]


def record(
    folder: Path,
    rows: Rows,
    plugin: StoragePlugin = StoragePlugin.MCAP,
    mode: CompressionMode = CompressionMode.NONE,
) -> Path:
    writer = Writer(folder, version=9, storage_plugin=plugin)
    if mode is not CompressionMode.NONE:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        kinds = {topic: message.__msgtype__ for topic, _, message in rows}
        connections = {
            topic: writer.add_connection(topic, kind, typestore=STORE) for topic, kind in kinds.items()
        }
        for topic, time, message in rows:
            writer.write(connections[topic], time, STORE.serialize_cdr(message, message.__msgtype__))
    return folder


def blocks(number: int) -> tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any]]:
    rng = generator(7, "syndrone", number)
    colour = rng.integers(60, 120, (72, 128, 3), dtype=np.uint8)
    depth = rng.integers(0, 65536, (72, 128), dtype=np.uint16)
    return colour, depth, rng.choice(np.array([0, 1, 7, 9, 22, 100], dtype=np.uint8), (72, 128))


def picture_file(image: npt.NDArray[Any], suffix: str) -> bytes:
    quickly = [cv2.IMWRITE_PNG_COMPRESSION, 1] if suffix == ".png" else []
    return bytes(cv2.imencode(suffix, image, quickly)[1])


def put_frame(folder: Path, number: int) -> None:
    for name, suffix, image in zip(
        ("rgb", "depth", "semantic"), (".jpg", ".png", ".png"), blocks(number), strict=True
    ):
        path = folder / name / f"{number:05}{suffix}"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(picture_file(np.repeat(np.repeat(image, BLOCK, axis=0), BLOCK, axis=1), suffix))


def put_pictures(folder: Path, name: str, frame: Frame, *, colour: str = ".png") -> None:
    for kind, suffix, image in (
        ("rgb", colour, frame.rgb),
        ("depth", ".png", frame.depth),
        ("labels", ".png", frame.labels),
    ):
        (folder / kind).mkdir(parents=True, exist_ok=True)
        (folder / kind / f"{name}{suffix}").write_bytes(picture_file(image, suffix.lower()))
