"""Frames without labels: they are flown, and no figure of quality counts them."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import sunset
from sunset.cli import main
from sunset.data import read_bag, write_bag
from sunset.recording import read_messages
from sunset.system import EVALUATION_TOPIC, TRUTH_TOPIC
from sunset.system_interfaces.msg import FrameEvaluation, ImageDigest
from sunset_ros.interfaces.stamps import ns_of

QUALITY = ("iou", "iou_all", "iou_healthy", "utility", "miou", "faults_masked", "masked_s")


pytestmark = pytest.mark.xdist_group("without truth")  # thresholds on each flight are computed once

FRAMES = 140
"""What 8 s after the longest warm-up need: thresholds on more take long."""


@pytest.fixture(scope="module")
def labelled(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], Path]:
    """Return what writes the beginning of the default flight without the labels of every n-th frame; of none if 0."""

    @cache
    def write(every: int) -> Path:
        path = tmp_path_factory.mktemp("flight") / "bag"
        with read_bag(flight) as bag:
            frames = (
                replace(frame, labels=np.zeros_like(frame.labels)) if every and number % every == 0 else frame
                for number, frame in enumerate(map(bag.frame, range(FRAMES)))
            )
            return write_bag(path, frames, bag.stamps_ns[:FRAMES])

    return write


def flown(bag: Path, out: Path) -> sunset.Run:
    return sunset.run("hardware_disconnect", "baseline", bag=bag, out=out, duration=8)


@pytest.mark.thorough
def test_a_flight_has_the_quality_of_its_labelled_frames(
    labelled: Callable[[int], Path], tmp_path: Path
) -> None:
    whole, part = flown(labelled(0), tmp_path / "whole"), flown(labelled(3), tmp_path / "part")
    with read_bag(labelled(0)) as bag:
        known = {stamp for number, stamp in enumerate(bag.stamps_ns) if number % 3}
    messages = read_messages(tmp_path / "whole")
    start_ns = whole.record.start_ns or 0
    measured = {
        ns_of(one.message.header.stamp)
        for one in messages
        if one.topic == TRUTH_TOPIC
        and isinstance(one.message, ImageDigest)
        and start_ns <= one.time_ns < start_ns + 8e9
    }
    ious = [
        one.message.iou
        for one in messages
        if one.topic == EVALUATION_TOPIC
        and isinstance(one.message, FrameEvaluation)
        and ns_of(one.message.header.stamp) in measured & known
    ]
    assert (
        0 < len(ious) < len(measured & known) < len(measured) == 80
    )  # frames were lost, and others have no labels

    assert part.metrics.frames_without_truth == len(measured - known)
    assert part.metrics.iou == pytest.approx(np.mean(ious), abs=1e-9)
    assert part.metrics.iou_all == pytest.approx(sum(ious) / len(measured & known), abs=1e-9)
    others = set(whole.metrics.to_json()) - {*QUALITY, "frames_without_truth"}
    assert {name: part.metrics.to_json()[name] for name in others} == {
        name: whole.metrics.to_json()[name] for name in others
    }
    assert part.differing == ()


@pytest.mark.thorough
def test_a_flight_without_labels_is_flown_reported_and_viewed(
    labelled: Callable[[int], Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = labelled(1)
    out = tmp_path / "campaign"
    arguments = ["--scenarios", "single/hardware_disconnect", "--duration", "8", "--bag", str(bag)]

    assert main(["bench", "--suite", "single", "--managers", "none,baseline,oracle", "--repetitions", "1",
                 *arguments, "--no-references", "--out", str(out)]) == 0  # fmt: skip

    capsys.readouterr()
    assert main(["report", str(out), "--runs", "--format", "json"]) == 0
    runs = {run["manager"]: run for run in json.loads(capsys.readouterr().out)["runs"]}
    assert {name: runs["baseline"][name] for name in QUALITY} == dict.fromkeys(QUALITY)
    assert runs["baseline"]["frames_without_truth"] == 80
    whole = flown(labelled(0), tmp_path / "whole").metrics
    for name in ("episodes", "episodes_resolved", "adaptations", "t_down_s", "t_react_s", "faults_cured"):
        assert runs["baseline"][name] == getattr(whole, name)
    for form in ("table", "latex", "html", "json"):
        assert main(["report", str(out), "--recompute", "--format", form]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert ": 80 frames of a run have no labels and count for no figure of quality." in told
    folder = out / "runs" / "single" / "baseline" / "hardware_disconnect" / "seed-1"
    assert main(["report", str(folder)]) == 0
    assert "80 frames without labels left out" in capsys.readouterr().out
    page = tmp_path / "page.html"
    assert main(["view", str(folder), "--bag", str(bag), "--out", str(page), "--no-open"]) == 0
    assert "there is no IoU, since the flight has no labels" in page.read_text()
