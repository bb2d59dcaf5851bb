"""When a live run does not count: the computer could not keep up."""

from dataclasses import replace
from pathlib import Path

import pytest

from sunset.experiments import RunTiming
from sunset.experiments.live_run import FrameCount
from sunset.metrics import Command, Injection, Timeline
from sunset.system import extended_system
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.rosgraph_msgs.msg import Clock
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header

S = 10**9
START_NS = 10 * S
TIMING = RunTiming(duration_s=2.0, warm_up_s=1.0)


def frames(*, lost: float | None = None, late: float | None = None, stop: float = 2.0) -> FrameCount:
    """A flight from -1 s on; two frames from `lost` on are not segmented, those from `late` on come 0.2 s late."""
    count = FrameCount()
    for number in range(round((stop + 1) * 10)):
        time = number / 10 - 1
        image = Image(header=Header(stamp=Time(sec=number)))
        delay = 0.2 if late is not None and time > late - 0.01 else 0.0
        time_ns = START_NS + round((time + delay) * S)
        count.note(time_ns, "/gt_segmentation", image)
        if lost is None or not -0.01 < time - lost < 0.11:
            count.note(time_ns + S // 20, "/managed_subsystem/segmentation", image)
    return count


def timeline(*, outage: bool = False, command: float | None = None) -> Timeline:
    injection = Injection(0.0, "gpu_failure", "F3", "/managed_subsystem/segmentation")
    return Timeline(
        thresholds={"entropy_threshold": 0.1, "sharpness_threshold": 1.0},
        injections=(injection,) if outage else (),
        commands=()
        if command is None
        else (Command(command, "/m", "/managed_subsystem/camera", "activate"),),
    )


def test_a_flight_without_loss_counts() -> None:
    assert frames().shortfall(START_NS, timeline(), TIMING) == ""


@pytest.mark.parametrize(
    ("lost", "seen", "counts"),
    [
        (-0.8, timeline(outage=True), False),  # before the injection
        (-0.1, timeline(outage=True), True),  # on its way when the node failed
        (0.8, timeline(outage=True), True),
        (0.8, timeline(), False),  # nothing is wrong that would take frames
        (1.2, timeline(command=1.5), True),  # perhaps the command's work
        (0.8, timeline(command=1.5), False),
    ],
)
def test_a_frame_may_be_lost_only_after_something_was_done(lost: float, seen: Timeline, counts: bool) -> None:
    reason = frames(lost=lost).shortfall(START_NS, seen, TIMING)
    assert (reason == "") is counts
    assert counts or "2 of" in reason


@pytest.mark.parametrize(("lost", "counts"), [(1, True), (4, True), (5, False)])
def test_one_frame_or_2_percent_of_them_may_be_lost(lost: int, counts: bool) -> None:
    timing = RunTiming(duration_s=24.0, warm_up_s=1.0)
    count = frames(stop=24.0)
    for stamp in list(count.segmented)[10 : 10 + lost]:
        del count.segmented[stamp]

    assert (count.shortfall(START_NS, timeline(), timing) == "") is counts
    assert count.losses(START_NS, timeline(), timing) == (245, lost)


def test_one_frame_may_be_lost_of_a_few() -> None:
    count = frames()
    count.segmented.popitem()
    del count.taken[next(iter(count.taken))]

    assert count.shortfall(START_NS, timeline(), TIMING) == ""


def test_frames_may_be_lost_to_an_outage_of_an_extension(tmp_path: Path) -> None:
    file = tmp_path / "deaf.py"
    file.write_text(
        "from sunset.system import *\n"
        "EXTENSION = Extension(failures=(Failure('F6', 'no depth', 'none', 'back', topic='depth_camera'),))\n"
    )
    injection = Injection(0.0, "deaf", "F6", "/managed_subsystem/depth")
    with extended_system([file]):
        seen = replace(timeline(), injections=(injection,))
        assert frames(lost=0.8).shortfall(START_NS, seen, TIMING) == ""


def test_frames_may_be_lost_to_whoever_ends_a_process() -> None:
    count = frames(lost=1.2)
    count.note_disturbance(START_NS + round(1.1 * S))
    count.note_disturbance(START_NS + round(1.9 * S))  # it is still as it was
    assert count.shortfall(START_NS, timeline(), TIMING) == ""
    count = frames(lost=0.3)
    count.note_disturbance(START_NS + round(1.1 * S))
    assert "2 of" in count.shortfall(START_NS, timeline(), TIMING)


def test_the_flight_itself_must_be_in_time() -> None:
    assert "0.30 s passed between" in frames(late=0.5).shortfall(START_NS, timeline(outage=True), TIMING)
    assert "25 of 30 frames" in frames(stop=1.5).shortfall(START_NS, timeline(outage=True), TIMING)


@pytest.mark.parametrize(
    ("shown_s", "late_s", "counts"), [(11.0, 0.05, True), (11.0, 0.4, False), (9.0, 0.4, True)]
)
def test_what_is_observed_must_be_timed_well(shown_s: float, late_s: float, counts: bool) -> None:
    count = frames()
    clock = Clock(clock=Time(sec=int(shown_s)))
    count.note(round((shown_s + late_s) * S), "/clock", clock)
    reason = count.shortfall(START_NS, timeline(), TIMING)
    assert (reason == "") is counts
    assert counts or "times are wrong by up to 0.40 s" in reason


def test_a_forged_time_of_any_kind_is_noted() -> None:
    count = FrameCount()
    count.note(5, "/clock", Clock(clock=Time(sec=-1, nanosec=7)))
    assert count.clock == [(5, -S + 7)]
