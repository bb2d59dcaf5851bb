"""What became of faults, worked out by hand: cured, masked or missed; and needless adaptations."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from sunset.metrics import (
    Command,
    Frames,
    Injection,
    Samples,
    Setting,
    Timeline,
    score,
)
from sunset.system import (
    STATE,
    Adaptation,
    AdaptationKind,
    Extension,
    Fault,
    FaultKind,
    System,
    current_system,
)
from sunset.system.current import using_system

FUSION = "/managed_subsystem/sensor_fusion"
DECLARED = (
    Setting(-9.0, FUSION, "modality", "0", declared=True),
    Setting(-9.0, FUSION, "topic_camera_input", "rgb_camera", declared=True),
    Setting(-9.0, FUSION, "do_recalibration", "false", declared=True),
    Setting(-9.0, "/managed_subsystem/image_enhancement", STATE, "inactive"),
)
SHIFT = Injection(0.0, "image_shift", "F4", FUSION)
DEPTH = Injection(0.0, "depth_degradation", "F4", "/managed_subsystem/depth", internal=False)
DARK = Injection(0.0, "image_degradation", "F4", "/managed_subsystem/camera", internal=False)
GPU = Injection(0.0, "gpu_failure", "F3", "/managed_subsystem/segmentation", redeploy_only=True)
CUDA = Injection(0.0, "cuda_out_of_memory", "F3", "/managed_subsystem/segmentation")


class Run:
    """A run of 20 s that is told step by step; what is set is so a millisecond later."""

    def __init__(self, *faults: Injection, healthy: float = 0.5, bad: float = 0.25) -> None:
        self.faults = list(faults)
        self.commands: list[Command] = []
        self.settings = list(DECLARED)
        self.entropy = np.full(230, 0.1)
        self.iou = np.where(np.arange(230) < 30, healthy, bad)

    def command(self, time: float, node: str, kind: str, *pair: str) -> None:
        names, values = (pair[:1], pair[1:])
        self.commands.append(Command(time, "/mine", f"/managed_subsystem/{node}", kind, names, values))

    def set(self, time: float, name: str, value: str, node: str = "sensor_fusion") -> None:
        self.command(time, node, "set_parameters", name, value)
        self.settings.append(Setting(time + 0.001, f"/managed_subsystem/{node}", name, value))

    def recalibrate(self, time: float) -> None:
        """Set what the node sets back at once."""
        self.set(time, "do_recalibration", "true")
        self.settings.append(Setting(time + 0.001, FUSION, "do_recalibration", "false"))

    def state(self, time: float, node: str, kind: str, state: str) -> None:
        self.command(time, node, kind)
        self.settings.append(Setting(time + 0.001, f"/managed_subsystem/{node}", STATE, state))

    def unsure(self, start: float, stop: float) -> None:
        """Let every report of the entropy be over its threshold, which the mean of five is 0.3 s later."""
        self.entropy[round(start * 10) + 30 : round(stop * 10) + 30] = 0.9

    def timeline(self) -> Timeline:
        times = np.arange(-30, 200) / 10
        counts = np.ones((230, 28), np.int64)
        return Timeline(
            message_times={
                f"/managed_subsystem/{topic}": times
                for topic in ("rgb_camera", "sensors_fused", "segmentation")
            },
            thresholds={"entropy_threshold": 0.2, "sharpness_threshold": 0.1},
            samples={"segmentation_entropy": Samples(times, self.entropy)},
            injections=tuple(self.faults),
            commands=tuple(sorted(self.commands, key=lambda one: one.time)),
            settings=tuple(sorted(self.settings, key=lambda one: one.time)),
            frames=Frames(times, self.iou, counts, counts, counts),
        )

    @property
    def fates(self) -> list[tuple[str, str]]:
        return [(one.fault, one.fate) for one in score(self.timeline()).outcomes]

    @property
    def needless(self) -> list[str]:
        return [str(one) for one in score(self.timeline()).needless_adaptations]


def ended(fault: Injection, time: float, cause: str = "") -> Injection:
    return replace(fault, ended=time, cause=cause)


# Cured


def test_a_fault_that_an_adaptation_ended_is_cured_when_it_ended() -> None:
    run = Run(ended(replace(SHIFT, time=1.0), 4.5, "set sensor_fusion.do_recalibration to true"))
    run.recalibrate(4.4)
    (outcome,) = score(run.timeline()).outcomes
    assert (outcome.fate, outcome.cured, outcome.uncured_s) == ("cured", 4.5, 3.5)
    assert run.needless == []


def test_a_fault_that_heals_is_missed_and_uncured_until_then() -> None:
    run = Run(ended(SHIFT, 6.0))
    run.recalibrate(7.0)
    (outcome,) = score(run.timeline()).outcomes
    assert (outcome.fate, outcome.cured, outcome.uncured_s) == ("missed", None, 6.0)
    assert run.needless == ["set sensor_fusion.do_recalibration to true"]


def test_a_fault_that_is_kept_from_coming_again_is_cured_then() -> None:
    run = Run(replace(ended(GPU, 6.0), cured_away=7.5))
    run.command(7.4, "segmentation", "redeploy")
    run.command(7.6, "segmentation", "redeploy")
    (outcome,) = score(run.timeline()).outcomes
    assert (outcome.until, outcome.cured, outcome.uncured_s) == (6.0, 7.5, 6.0)
    assert [one.time for one in score(run.timeline()).needless_adaptations] == [7.6]


def test_a_process_that_ended_by_itself_cures_nothing() -> None:
    run = Run(ended(GPU, 5.0, "redeploy segmentation"))
    assert run.fates == [("gpu_failure", "missed")]
    run.command(4.9, "segmentation", "redeploy")
    assert run.fates == [("gpu_failure", "cured")]


def test_a_restart_cures_a_fault_that_comes_within_it() -> None:
    run = Run(ended(replace(CUDA, time=2.0), 2.3, "restart segmentation"))
    run.command(1.8, "segmentation", "deactivate")
    assert run.fates == [("cuda_out_of_memory", "missed")]
    run.command(2.2, "segmentation", "activate")
    assert (run.fates, run.needless) == ([("cuda_out_of_memory", "cured")], [])


def test_a_shutdown_with_the_redeploy_after_it_cures() -> None:
    run = Run(ended(GPU, 2.0, "shutdown"))
    run.command(1.9, "segmentation", "shutdown")
    run.command(2.5, "segmentation", "redeploy")
    assert (run.fates, run.needless) == ([("gpu_failure", "cured")], [])


def test_a_fault_that_is_there_at_the_end_is_uncured_until_then() -> None:
    (outcome,) = score(Run(replace(GPU, time=3.0)).timeline()).outcomes
    assert (outcome.cured, outcome.uncured_s) == (None, 17.0)


def test_a_fault_of_the_world_is_cured_when_the_last_step_of_a_cure_is_in_place() -> None:
    run = Run(DARK)
    run.state(2.0, "image_enhancement", "activate", "active")
    assert run.fates == [("image_degradation", "missed")]
    run.set(5.0, "topic_camera_input", "/managed_subsystem/rgb_enhanced")  # by its full name
    (outcome,) = score(run.timeline()).outcomes
    assert (outcome.cured, outcome.uncured_s) == (5.001, 5.001)
    assert run.needless == []


@pytest.mark.parametrize(("amount", "cured"), [("0.0", None), ("0.29", None), ("0.3", 5.001), ("0.9", 5.001)])
def test_a_cure_must_undo_a_third_of_the_fault(amount: str, cured: float | None) -> None:
    run = Run(DARK)
    run.set(-2.0, "image_degradation", amount, node="image_enhancement")
    run.settings.append(Setting(0.0, "/managed_subsystem/camera", "image_degradation", "0.9"))
    run.state(2.0, "image_enhancement", "activate", "active")
    run.set(5.0, "topic_camera_input", "rgb_enhanced")
    (outcome,) = score(run.timeline()).outcomes
    assert outcome.cured == cured


def test_a_cure_that_is_taken_back_after_a_second_has_cured_and_the_rest_is_uncured() -> None:
    run = Run(DEPTH)
    run.set(2.0, "modality", "1")
    run.set(9.0, "modality", "0")
    run.set(12.0, "modality", "1")
    (outcome,) = score(run.timeline()).outcomes
    assert (outcome.cured, outcome.uncured_s) == (2.001, 5.001 - 9.0 + 6.0 + 3.0)
    assert run.needless == ["set sensor_fusion.modality to 0"]


def test_a_cure_of_less_than_a_second_is_none() -> None:
    run = Run(DEPTH)
    run.set(2.0, "modality", "1")
    run.set(2.9, "modality", "0")
    run.set(19.5, "modality", "1")
    (outcome,) = score(run.timeline()).outcomes
    assert outcome.cured is None
    assert outcome.uncured_s == pytest.approx(20.0 - 0.9 - 0.499)


def test_a_cure_that_a_new_process_has_lost_is_in_place_until_then() -> None:
    run = Run(DEPTH)
    run.set(2.0, "modality", "1")
    run.settings.append(Setting(9.0, FUSION, "modality", "0", declared=True))
    (outcome,) = score(run.timeline()).outcomes
    assert outcome.uncured_s == pytest.approx(2.001 + 11.0)


def test_a_workaround_from_before_a_fault_leaves_it_uncured_at_no_time() -> None:
    run = Run(replace(DEPTH, time=4.0))
    run.set(-1.0, "modality", "1")
    (outcome,) = score(run.timeline()).outcomes
    assert (outcome.cured, outcome.uncured_s) == (4.0, 0.0)
    assert run.needless == ["set sensor_fusion.modality to 1"]


def test_a_fault_that_comes_again_after_its_end_is_another_one() -> None:
    run = Run(ended(SHIFT, 4.0), replace(SHIFT, time=6.0))
    assert [(one.began, one.until) for one in score(run.timeline()).outcomes] == [(0.0, 4.0), (6.0, 20.0)]
    assert score(run.timeline()).uncured_s == (4.0 + 14.0) / 2


def test_a_fault_that_is_injected_again_while_it_is_there_is_the_same_one() -> None:
    run = Run(SHIFT, ended(replace(SHIFT, time=6.0), 9.0, "redeploy sensor_fusion"))
    run.command(8.9, "sensor_fusion", "redeploy")
    (outcome,) = score(run.timeline()).outcomes
    assert (outcome.began, outcome.cured) == (0.0, 9.0)


# Masked


def test_a_fault_is_masked_while_its_symptom_has_gone_after_an_adaptation() -> None:
    run = Run(SHIFT)
    run.unsure(0.0, 5.0)
    run.set(5.0, "modality", "1")
    metrics = score(run.timeline())
    # the mean of five is over 0.2 as long as one of them is 0.9: until the sample of 5.4 s
    assert metrics.masked_s == pytest.approx(14.6)
    assert metrics.faults_masked == 1
    assert metrics.outcomes[0].masked_s == metrics.masked_s


def test_nothing_is_masked_while_the_symptom_holds_or_goes_without_an_adaptation() -> None:
    holds = Run(SHIFT)
    holds.unsure(0.0, 20.0)
    holds.set(5.0, "modality", "1")
    goes = Run(SHIFT)
    goes.unsure(0.0, 5.0)
    assert [score(run.timeline()).masked_s for run in (holds, goes)] == [0.0, 0.0]


@pytest.mark.parametrize(("bad", "fate"), [(0.43, "missed"), (0.42, "masked")])
def test_a_fault_is_masked_only_where_the_segmentation_is_bad(bad: float, fate: str) -> None:
    run = Run(SHIFT, bad=bad)
    run.unsure(0.0, 5.0)
    run.set(5.0, "modality", "1")
    assert run.fates == [("image_shift", fate)]


def test_a_frame_in_which_two_faults_are_masked_counts_once() -> None:
    run = Run(SHIFT, replace(DARK, time=1.0))
    run.unsure(0.0, 5.0)
    run.set(5.0, "modality", "1")
    metrics = score(run.timeline())
    assert metrics.faults_masked == 2
    assert metrics.masked_s == pytest.approx(14.6)


def test_on_a_flight_without_labels_nothing_is_masked() -> None:
    run = Run(SHIFT)
    times = np.arange(-30, 200) / 10
    metrics = score(replace(run.timeline(), frames=Frames(), without_truth=times))
    assert (metrics.masked_s, metrics.faults_masked, metrics.outcomes[0].masked_s) == (None, None, None)


# Needless


def test_what_cures_another_fault_than_is_there_is_needless() -> None:
    run = Run(GPU)
    run.command(1.0, "segmentation", "deactivate")
    run.command(1.1, "segmentation", "activate")
    run.command(2.0, "camera", "redeploy")
    run.set(3.0, "modality", "1")
    assert run.needless == ["restart segmentation", "redeploy camera", "set sensor_fusion.modality to 1"]


def test_the_parts_of_a_restart_are_steps_of_it() -> None:
    run = Run(ended(CUDA, 6.0, "restart segmentation"))
    run.state(2.0, "segmentation", "deactivate", "inactive")
    run.state(5.9, "segmentation", "activate", "active")
    run.state(8.0, "segmentation", "deactivate", "inactive")
    assert run.needless == ["deactivate segmentation"]


def test_the_strength_of_a_node_that_a_cure_activates_is_a_step_of_it() -> None:
    run, other = Run(DARK), Run(SHIFT)
    for one in (run, other):
        one.set(3.0, "image_degradation", "0.5", node="image_enhancement")
    assert (run.needless, other.needless) == ([], ["set image_enhancement.image_degradation to 0.5"])


def test_each_parameter_of_a_call_is_an_adaptation_of_its_own() -> None:
    run = Run(SHIFT)
    names, values = ("do_recalibration", "modality", "topic_camera_input"), ("true", "1", "rgb_camera")
    run.commands.append(Command(1.0, "/mine", FUSION, "set_parameters", names, values))
    assert run.needless == [
        "set sensor_fusion.modality to 1",
        "set sensor_fusion.topic_camera_input to rgb_camera",
    ]
    assert score(run.timeline()).cost_frames == 6.0


def test_an_adaptation_costs_its_price_in_healthy_frames() -> None:
    run = Run(SHIFT, healthy=0.5, bad=0.25)
    run.recalibrate(1.0)
    run.command(2.0, "segmentation", "redeploy")
    run.command(3.0, "camera", "deactivate")
    run.command(3.1, "camera", "activate")
    run.command(9.0, "camera", "configure")
    metrics = score(run.timeline())
    assert (metrics.cost_frames, metrics.iou_healthy, metrics.needless) == (2 + 10 + 4 + 2, 0.5, 3)
    assert metrics.utility == pytest.approx(0.25 - 18 * 0.5 / 200)


def test_without_a_fault_every_adaptation_is_needless() -> None:
    run = Run()
    run.command(1.0, "camera", "redeploy")
    metrics = score(run.timeline())
    assert (metrics.faults_injected, metrics.faults_cured, metrics.masked_s) == (0, None, None)
    assert (metrics.needless, metrics.uncured_s) == (1, None)


def test_a_fault_that_this_version_does_not_know_is_missed() -> None:
    run = Run(Injection(0.0, "gremlins", "F4", FUSION))
    run.recalibrate(1.0)
    assert run.fates == [("gremlins", "missed")]
    assert len(run.needless) == 1


# Extensions

_FOG = Fault(
    name="fog",
    failure="F4",
    node="camera",
    description="Fog.",
    kind=FaultKind.EXTERNAL,
    cures=(
        (
            Adaptation(AdaptationKind.SET_PARAMETER, "camera", "headlight", value=True),
            Adaptation(AdaptationKind.DEACTIVATE, "depth"),
        ),
    ),
)


@pytest.fixture
def foggy() -> Iterator[None]:
    """Let the system have a fault whose cure is of two steps."""
    with using_system(System(*current_system().parts, Extension(faults=(_FOG,))), {}):
        yield


@pytest.mark.usefixtures("foggy")
def test_the_cures_of_an_extension_are_known() -> None:
    run = Run(Injection(0.0, "fog", "F4", "/managed_subsystem/camera", internal=False))
    run.set(2.0, "headlight", "true", node="camera")
    run.state(4.0, "depth", "deactivate", "inactive")
    (outcome,) = score(run.timeline()).outcomes
    assert outcome.cured == 4.001
    assert run.needless == []


def test_arrays_of_frames_may_be_empty() -> None:
    limits = {"entropy_threshold": 0.2, "sharpness_threshold": 0.1}
    (outcome,) = score(Timeline(thresholds=limits, injections=(SHIFT,))).outcomes
    assert outcome.fate == "missed"
