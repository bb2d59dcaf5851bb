"""Stored runs to evaluate."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from tests.recording.runs import RUN

from sunset.metrics import score
from sunset.recording import RecordWriter, timeline_of
from sunset.recording.timelines import measured_topics
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

START_NS = 3 * 10**9
OUTAGE_S = (2.0, 6.0)

Store = Callable[..., Path]


def stamp(time_ns: int) -> Time:
    return Time(sec=time_ns // 10**9, nanosec=time_ns % 10**9)


def at(seconds: float) -> int:
    return START_NS + round(seconds * 1e9)


def messages(run: str, command_s: float, iou: float) -> list[tuple[str, int, Message]]:
    """Return a flight with one outage of everything, and one redeploy of the camera within it."""
    camera = "/managed_subsystem/camera"
    rows: list[tuple[str, int, Message]] = [
        (
            "/experiment/log",
            at(0),
            ExperimentLogging(timestamp=START_NS, scenario=run, source="experiment", rule_name="start"),
        ),
        (
            "/experiment/injections",
            at(OUTAGE_S[0]),
            FaultInjection(
                stamp=stamp(at(OUTAGE_S[0])),
                fault="camera_driver_issue",
                failure="F1",
                node=camera,
                internal=True,
                confirmed=True,
            ),
        ),
        (
            "/experiment/commands",
            at(command_s),
            Command(
                stamp=stamp(at(command_s)),
                client="/baseline",
                service="/launcher/redeploy",
                node=camera,
                kind="redeploy",
                successful=True,
            ),
        ),
    ]
    for number in range(-10, 200):
        seconds = number / 10
        if OUTAGE_S[0] <= seconds < OUTAGE_S[1]:
            continue
        header = Header(stamp=stamp(at(seconds)))
        picture = Image(header=header, height=1, width=1, encoding="8UC1", step=1, data=np.zeros(1, np.uint8))
        half = np.zeros(28, np.uint32)
        half[3] = 100
        right = np.zeros(28, np.uint32)
        right[3] = round(100 * iou)
        rows += [
            ("/managed_subsystem/rgb_camera", at(seconds), picture),
            ("/managed_subsystem/sensors_fused", at(seconds), SensorFusion(header=header, rgb=picture)),
            ("/managed_subsystem/segmentation", at(seconds), picture),
            (
                "/seg_metrics",
                at(seconds),
                FrameEvaluation(header=header, iou=iou, intersection=right, predicted=right, truth=half),
            ),
            (
                "/diagnostics",
                at(seconds),
                DiagnosticArray(
                    status=[
                        DiagnosticStatus(
                            hardware_id="segmentation", values=[KeyValue(key="entropy", value="0.1")]
                        )
                    ]
                ),
            ),
        ]
    return rows


@pytest.fixture
def store(tmp_path: Path) -> Store:
    """Return a function that writes a run's record below `tmp_path` and returns its folder."""

    def write(name: str, *, command_s: float = 3.5, iou: float = 0.5, **about: Any) -> Path:
        folder = tmp_path / name
        described = {
            "scenario": "paper/camera_driver_issue",
            "suite": "paper",
            "manager": "baseline",
            "seed": 1,
            "model_checksums": {"fusion": "0f"},
            "entropy_threshold": 0.2,
            "sharpness_threshold": 0.1,
            **about,
        }
        record = replace(RUN, **described)
        with RecordWriter(folder) as writer:
            # two flights never have the same messages
            run = f"{record.scenario}, seed {record.seed}, {about.get('faults')}"
            for topic, time_ns, message in messages(run, command_s, iou):
                writer.write(topic, time_ns, message)
            recorded = writer.messages(measured_topics())
            observed = timeline_of(record, recorded)
            figures = score(observed)
            writer.close(
                replace(
                    record,
                    metrics=figures.to_json(),
                    fault_outcomes=figures.outcomes,
                )
            )
        return folder

    return write


@pytest.fixture
def edit() -> Callable[..., None]:
    """Return a function that changes keys of a stored run's `run.json`; `...` removes one."""

    def change(folder: Path, **changes: Any) -> None:
        file = folder / "run.json"
        run = json.loads(file.read_text()) | changes
        file.write_text(json.dumps({key: value for key, value in run.items() if value is not ...}))

    return change
