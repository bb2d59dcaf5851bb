"""A small experiment, as messages."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tests.recording.runs import RUN

from sunset.recording import RecordWriter
from sunset.system_interfaces.msg import (
    Command,
    ExperimentLogging,
    FaultInjection,
    FrameEvaluation,
    SensorFusion,
)
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header

Row = tuple[str, int, Message]

MS = 10**6
START_NS = 3000 * MS


def stamp(time_ns: int) -> Time:
    return Time(sec=time_ns // 10**9, nanosec=time_ns % 10**9)


def image(number: int, encoding: str = "bgr8") -> Image:
    """Return the frame of this number; its stamp is the bag's, far from the experiment's clock."""
    header = Header(stamp=stamp(10**12 + number * 100 * MS), frame_id="camera")
    pixels = np.full(12, number % 256, np.uint8)
    return Image(header=header, height=2, width=2, encoding=encoding, step=6, data=pixels)


def report(node: str, **values: float) -> DiagnosticArray:
    pairs = [KeyValue(key=key, value=repr(value)) for key, value in values.items()]
    return DiagnosticArray(status=[DiagnosticStatus(hardware_id=node, values=pairs)])


def frame(number: int, time_ns: int) -> list[Row]:
    """Return what one frame leaves on its way through the pipeline, which takes 50 ms."""
    rgb, labels = image(number), image(number, "8UC1")
    counts = np.arange(28) + number
    evaluation = FrameEvaluation(
        header=labels.header, iou=0.5, intersection=counts, predicted=counts * 2, truth=counts * 3
    )
    fused = SensorFusion(header=rgb.header, rgb=rgb, depth=image(number, "16UC1"))
    return [
        ("/gt_segmentation", time_ns, labels),
        ("/managed_subsystem/rgb_camera", time_ns + 2 * MS, rgb),
        ("/managed_subsystem/sensors_fused", time_ns + 5 * MS, fused),
        ("/managed_subsystem/segmentation", time_ns + 45 * MS, labels),
        ("/diagnostics", time_ns + 46 * MS, report("segmentation", entropy=0.05, other=9.0)),
        ("/diagnostics", time_ns + 47 * MS, report("camera", sharpness=0.4)),
        ("/seg_metrics", time_ns + 50 * MS, evaluation),
    ]


@pytest.fixture
def rows() -> list[Row]:
    """Ten frames, two of them before the experiment starts, one injection, one command."""
    started = ExperimentLogging(timestamp=START_NS, source="experiment", rule_name="start")
    injection = FaultInjection(
        stamp=stamp(START_NS),
        fault="hardware_disconnect",
        failure="F1",
        node="/managed_subsystem/camera",
        internal=True,
        redeploy_only=True,
        confirmed=True,
    )
    command = Command(
        stamp=stamp(START_NS + 200 * MS),
        client="/manager",
        node="/managed_subsystem/camera",
        kind="set_parameters",
        parameters=["a"],
        values=["1"],
        successful=True,
    )
    rows = [
        ("/experiment/log", START_NS, started),
        ("/experiment/injections", START_NS + 3 * MS, injection),
        ("/experiment/commands", START_NS + 201 * MS, command),
    ]
    for number in range(10):
        rows += frame(number, START_NS + (number - 2) * 100 * MS + 20 * MS)
    return sorted(rows, key=lambda row: row[1])


@pytest.fixture
def record(tmp_path: Path, rows: list[Row]) -> Path:
    """The finished record of the small experiment."""
    return write(tmp_path / "record", rows)


@pytest.fixture
def write_record() -> Callable[[Path, list[Row]], Path]:
    return write


def write(folder: Path, rows: list[Row]) -> Path:
    with RecordWriter(folder) as writer:
        for row in rows:
            writer.write(*row)
        writer.close(RUN)
    return folder
