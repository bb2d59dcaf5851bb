"""What a page knows of a run is what its record has."""

from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
import pytest
from tests.viewing.conftest import Shown, attributes_of, data_of
from tests.viewing.unpacking import unpack

import sunset
from sunset.classes import CLASS_OF_CARLA_ID
from sunset.recording import StoredImage, read_images, read_messages
from sunset.viewing import Viewed, page_text

pytestmark = pytest.mark.xdist_group("viewing")  # the runs that are shown are made once

SOON = 0.01
"""Seconds in which a command takes effect, in the simulation."""


@pytest.fixture(scope="module")
def page(ten: Shown) -> Any:
    return attributes_of(ten.page.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def view(page: Any) -> Any:
    return page.runs[0]


def commands(run: sunset.Run, parameter: str = "", kind: str = "") -> list[float]:
    """Return when the managing system set a parameter, or did something else."""
    return [
        one.time
        for one in run.timeline.commands
        if one.client == "/managing_system" and (parameter in one.parameters or (kind and one.kind == kind))
    ]


def test_a_fault_is_drawn_from_its_injection_to_its_end(ten: Shown, view: Any) -> None:
    injected = {one.fault: one.time for one in ten.run.timeline.injections}
    redeployed = commands(ten.run, kind="redeploy")[0]
    assert len(injected) == 10

    assert [fault.name for fault in view.faults] == list(injected)
    for fault in view.faults:
        ((since, until),) = fault.spans
        assert since == pytest.approx(injected[fault.name])
        in_the_world = fault.name in {"image_degradation", "depth_degradation"}
        assert until == pytest.approx(view.end if in_the_world else redeployed, abs=SOON)


def test_what_makes_up_for_a_fault_is_drawn_while_it_is_in_place(ten: Shown, view: Any) -> None:
    around = {fault.name: fault.around for fault in view.faults if fault.around}
    only_colour, only_depth, _ = commands(ten.run, "modality")
    (enhanced,) = commands(ten.run, "topic_camera_input")

    assert set(around) == {"depth_degradation", "image_degradation"}
    assert around["depth_degradation"] == [pytest.approx((only_colour, only_depth), abs=SOON)]
    assert around["image_degradation"] == [pytest.approx((enhanced, view.end), abs=SOON)]


def test_a_fault_of_the_configuration_ends_when_the_topic_is_set_back(tmp_path: Path) -> None:
    run = sunset.run("unneeded_enhancement", _SetBack, out=tmp_path / "run", duration=3)

    (fault,) = data_of(page_text([Viewed(run, None)]))["runs"][0]["faults"]
    (since, until), *others = fault["spans"]
    assert not others
    assert since == pytest.approx(run.timeline.injections[0].time)
    assert until == pytest.approx(commands(run, "topic_camera_input")[0], abs=SOON)


COMES_AND_GOES = """\
name: comes_and_goes
duration: 5
faults:
  - {name: camera_driver_issue, at: 0.5, profile: {kind: intermittent, on: 1.0, off: 1.0}}
"""


@pytest.fixture(scope="module")
def returning(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A run of a fault that comes and goes, and is there at the end."""
    assert flight.exists()
    folder = tmp_path_factory.mktemp("returning")
    (folder / "scenario.yaml").write_text(COMES_AND_GOES, encoding="utf-8")
    run = sunset.run(folder / "scenario.yaml", "none", out=folder / "run")
    return attributes_of(page_text([Viewed(run, None)])).runs[0]


def test_a_fault_that_comes_and_goes_is_drawn_once_for_each_time(returning: Any) -> None:
    (fault,) = returning.faults

    times = [time for span in fault.spans for time in span]
    assert times == pytest.approx([0.5, 1.5, 2.5, 3.5, 4.5, 5.0], abs=SOON)


class _SetBack(sunset.ManagingSystem):
    def adapt(self, symptoms: sunset.Symptoms) -> None:
        if symptoms.unsure:
            self.set_parameter("sensor_fusion", "topic_camera_input", "rgb_camera")


def test_episodes_adaptations_and_figures_are_those_of_the_run(ten: Shown, view: Any) -> None:
    drawn = [
        (failure.name, episode.began, episode.holds, episode.ended)
        for failure in view.failures
        for episode in failure.episodes
    ]
    expected = [(one.failure, one.began, one.holds, one.ended) for one in ten.run.episodes]
    assert sorted(drawn, key=str) == sorted(expected, key=str)
    assert {failure for failure, *_ in drawn} >= {"F1", "F2", "F3", "F4"}
    outcomes = {one.outcome for failure in view.failures for one in failure.episodes}
    assert any(one.startswith("resolved by 'redeploy") for one in outcomes)

    assert [(one.time, one.text) for one in view.adaptations] == [
        (one.time, str(one)) for one in ten.run.adaptations
    ]
    assert [(one.time, one.text) for one in view.log] == [
        (line.time, line.text) for line in ten.run.log if line.logger == "managing_system"
    ]
    assert [one.value for one in view.figures][3] == f"{ten.run.metrics.t_down_s:.2f} s"


def test_iou_and_rates_are_drawn_at_the_times_of_the_record(ten: Shown, view: Any) -> None:
    messages: Any = read_messages(ten.run.folder)
    start_ns = next(one.message.timestamp for one in messages if one.topic == "/experiment/log")
    taken = {
        (one.message.header.stamp.sec, one.message.header.stamp.nanosec): one.time_ns
        for one in messages
        if one.topic == "/gt_segmentation"
    }
    evaluated = [
        (
            (taken[one.message.header.stamp.sec, one.message.header.stamp.nanosec] - start_ns) / 1e9,
            one.message.iou,
        )
        for one in messages
        if one.topic == "/seg_metrics"
    ]
    assert len(evaluated) > 30
    assert np.allclose(list(zip(*view.iou, strict=True)), evaluated, atol=1e-5)

    for topic in view.topics:
        sent = [(one.time_ns - start_ns) / 1e9 for one in messages if one.topic == topic.name]
        assert np.allclose(topic.times, sent, atol=1e-6)
    frames = dict(zip(view.frames.times, view.frames.iou, strict=True))
    for time, iou in evaluated:
        if time <= view.end:
            assert frames[round(time, 6)] == pytest.approx(iou, abs=1e-5)


def test_signals_are_drawn_with_the_mean_that_their_threshold_is_for(ten: Shown, view: Any) -> None:
    entropy = next(one for one in view.signals if one.name == "segmentation_entropy")
    samples = ten.run.timeline.samples["segmentation_entropy"]

    assert entropy.threshold == ten.run.record.entropy_threshold
    assert np.allclose(entropy.values, samples.values, rtol=1e-4)
    assert entropy.means[:4] == [None] * 4
    assert entropy.means[4] == pytest.approx(samples.values[:5].mean(), rel=1e-4)


def test_lifecycles_are_those_of_redeployed_nodes(ten: Shown, view: Any) -> None:
    redeployed = commands(ten.run, kind="redeploy")
    states = {
        node.name: [(one.state, one.since) for one in node.states if one.until - one.since > SOON]
        for node in view.nodes
    }

    assert [state for state, _ in states["depth"]] == ["active"]
    assert [state for state, _ in states["image_enhancement"]] == ["inactive", "active"]
    for node, delay, time in zip(
        ("camera", "sensor_fusion", "segmentation"), (4.0, 2.0, 2.0), redeployed, strict=True
    ):
        assert [state for state, _ in states[node]] == ["active", "inactive", "active"]
        assert states[node][1][1] == pytest.approx(time, abs=SOON)
        assert states[node][2][1] == pytest.approx(time + delay, abs=SOON)


def test_the_network_s_input_is_what_the_modality_says(ten: Shown, view: Any) -> None:
    (given,) = (panel for panel in view.frames.panels if panel.name == "given")
    redeployed = commands(ten.run, kind="redeploy")[0]
    only_colour, only_depth, both = commands(ten.run, "modality")
    margin = 0.1

    def kinds(since: float, until: float) -> set[tuple[bool, bool]]:
        return {
            (given.pictures[place] >= 0, given.beside[place] >= 0)
            for place, time in enumerate(view.frames.times)
            if since + margin < time < until - margin
        }

    assert kinds(view.start, 0) == {(True, True)}
    assert kinds(0, redeployed) == {(False, False)}  # nothing stale stands for what did not come
    assert kinds(only_colour, only_depth) == {(True, False)}
    assert kinds(only_depth, both) == {(False, True)}
    assert kinds(both, view.end) == {(True, True)}


def test_labels_and_truth_are_exact_and_colour_is_as_near_as_the_page_says(ten: Shown, page: Any) -> None:
    frames, pictures = page.runs[0].frames, page.pictures
    places = {
        topic: panel.pictures
        for panel in frames.panels
        for topic in {
            "camera": ["rgb_camera"],
            "labels": ["segmentation"],
            "truth": ["/gt_segmentation"],
        }.get(panel.name, [])
    }
    number = {stamp: place for place, stamp in enumerate(frames.stamps)}
    losses, compared = [], 0
    for image in read_images(ten.run.folder):
        topic = image.topic.removeprefix("/managed_subsystem/")
        place = number.get(str(image.stamp_ns))
        if topic not in places or place is None:
            continue
        compared += 1
        data = msgspec.json.decode(f'"{pictures.data[places[topic][place]]}"', type=bytes)
        if topic == "rgb_camera":
            losses.append(_difference(data, image))
            continue
        labels = unpack(data, pictures.height, pictures.width)
        expected = image.pixels if topic == "segmentation" else CLASS_OF_CARLA_ID[image.pixels]
        assert np.array_equal(labels, expected)
    assert compared == sum(place >= 0 for listed in places.values() for place in listed)
    assert np.mean(losses) < 6


def _difference(data: bytes, image: StoredImage) -> float:
    shown = np.asarray(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR), np.int16)
    return float(np.abs(shown - image.pixels).mean())


def test_what_happened_is_told_in_sentences(view: Any) -> None:
    told = " ".join(view.story)

    assert told.startswith("Ten faults were injected at 0 s: camera_driver_issue (F1), ")
    assert "carried out 8 adaptations" in told
    assert "failure episodes were resolved" in told


def test_a_managing_system_that_failed_is_said_to_have_failed(tmp_path: Path) -> None:
    run = sunset.run("camera_driver_issue", _Failing, out=tmp_path / "run", duration=3)

    (shown,) = data_of(page_text([Viewed(run, None)]))["runs"]
    assert "_Failing failed in camera_driver_issue, seed 1: it raised ValueError: no plan" in shown["remark"]
    assert shown["remark"].endswith(" The run went on without it.")
    assert shown["story"][1].endswith("_Failing failed before it did anything.")


class _Failing(sunset.ManagingSystem):
    def adapt(self, symptoms: sunset.Symptoms) -> None:
        if symptoms.stopped("rgb_camera"):
            raise ValueError("no plan")


def test_what_came_again_is_told_once_with_its_times_to_a_tenth_of_a_second(returning: Any) -> None:
    assert returning.story[:2] == [
        "Three faults were injected: camera_driver_issue (F1) three times, at 0.5, 2.5 and 4.5 s.",
        "camera_driver_issue healed by itself two times, at 1.5 and 3.5 s.",
    ]


def test_what_healed_is_no_fault_that_came(returning: Any) -> None:
    kinds = [(one.kind, round(one.time, 1)) for one in returning.events if one.kind in {"fault", "healed"}]

    assert kinds == [("fault", 0.5), ("healed", 1.5), ("fault", 2.5), ("healed", 3.5), ("fault", 4.5)]


def test_a_cure_while_a_fault_was_away_is_told(tmp_path: Path) -> None:
    (tmp_path / "scenario.yaml").write_text(COMES_AND_GOES, encoding="utf-8")
    run = sunset.run(tmp_path / "scenario.yaml", _Late, out=tmp_path / "run")

    (shown,) = data_of(page_text([Viewed(run, None)]))["runs"]
    assert shown["story"][1:3] == [
        "camera_driver_issue healed by itself at 1.5 s.",
        "camera_driver_issue was cured at 1.9 s, while it was away.",
    ]


class _Late(sunset.ManagingSystem):
    """Restarts the camera when its images have been away, and are back."""

    def on_start(self) -> None:
        self.were_away = self.is_done = False

    def adapt(self, symptoms: sunset.Symptoms) -> None:
        frequency = symptoms.frequency("rgb_camera")
        self.were_away |= frequency < 2.0
        if self.were_away and not self.is_done and frequency > 2.0:
            self.is_done = True
            self.restart("camera")
