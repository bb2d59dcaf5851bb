"""The figure of an outage, where there is little to draw."""

import re
from pathlib import Path

from sunset.evaluation.figures import outage_figure
from sunset.metrics import Timeline

THRESHOLDS = {"entropy_threshold": 0.1, "sharpness_threshold": 1.0}


def test_a_topic_that_sent_nothing_at_all_is_silent_from_the_beginning(tmp_path: Path) -> None:
    timeline = Timeline(duration_s=3.0, thresholds=THRESHOLDS)
    topics = ["rgb_camera", "sensors_fused", "segmentation"]

    outage_figure(timeline, (), tmp_path / "silent.svg", topics=topics, title="")

    texts = re.findall(r"<!-- (.*?) -->", (tmp_path / "silent.svg").read_text(encoding="utf-8"))
    assert texts.count("4.0 s") == 3
