"""The files that other viewers are given fit the record."""

import json
from pathlib import Path

import pytest
from rosbags.highlevel import AnyReader

import sunset

DOCS = Path(__file__).parents[2] / "docs"

pytestmark = pytest.mark.usefixtures("flight")


def test_the_layout_shows_topics_that_a_record_has(tmp_path: Path) -> None:
    sunset.run("image_shift", duration=2, images=True, out=tmp_path / "run")
    with AnyReader([tmp_path / "run" / "images.mcap"]) as reader:
        kinds = {connection.topic: connection.msgtype for connection in reader.connections}
    layout = json.loads((DOCS / "viewing" / "layout.json").read_text(encoding="utf-8"))
    panels = layout["configById"]

    pictures = [panel["imageMode"]["imageTopic"] for panel in panels.values() if "imageMode" in panel]
    plotted = [path["value"] for panel in panels.values() for path in panel.get("paths", [])]

    assert {kinds[topic] for topic in pictures} == {"sensor_msgs/msg/CompressedImage"}
    assert {kinds[path.removesuffix(".data")] for path in plotted} == {"std_msgs/msg/Float64"}
    placed = json.dumps(layout["layout"])
    assert all(f'"{name}"' in placed for name in panels)
