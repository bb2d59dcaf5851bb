"""What became of faults, worked out by hand: cured, masked or missed, and what treated none."""

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
    unnecessary_redeploys,
)
from sunset.system import STATE, Adaptation, AdaptationKind, Extension, Fault, FaultKind
from sunset.system.current import _process

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
    def mistreating(self) -> list[str]:
        return [str(one) for one in score(self.timeline()).mistreating]


def ended(fault: Injection, time: float, cause: str = "") -> Injection:
    return replace(fault, ended=time, cause=cause)


def test_what_is_set_back_does_not_excuse_what_is_changed_beside_it() -> None:
    run = Run(GPU)
    run.settings.append(Setting(-3.0, FUSION, "delta_t_threshold", "0.01", declared=True))
    run.set(2.0, "modality", "1")
    names, values = ("modality", "delta_t_threshold"), ("0", "0.02")
    run.commands.append(Command(4.0, "/mine", FUSION, "set_parameters", names, values))
    run.settings += [Setting(4.001, FUSION, name, value) for name, value in zip(names, values, strict=True)]
    assert len(run.mistreating) == 2
    run.set(6.0, "modality", "1")
    run.set(8.0, "modality", "0")
    assert len(run.mistreating) == 3


# Cured


def test_a_fault_that_an_adaptation_ended_is_cured_when_it_ended() -> None:
    run = Run(ended(replace(SHIFT, time=1.0), 4.5, "set sensor_fusion.do_recalibration to true"))
    run.recalibrate(4.4)
    (outcome,) = score(run.timeline()).outcomes
    assert (outcome.fate, outcome.cured, outcome.observed_s) == ("cured", 4.5, 3.5)
    assert run.mistreating == []


def test_a_fault_that_heals_is_not_cured_and_was_observed_until_then() -> None:
    run = Run(ended(SHIFT, 6.0))
    run.recalibrate(7.0)
    (outcome,) = score(run.timeline()).outcomes
    assert (outcome.fate, outcome.cured, outcome.observed_s) == ("missed", None, 6.0)
    assert run.mistreating == ["set sensor_fusion.do_recalibration to true"]


def test_a_fault_that_is_kept_from_coming_again_is_cured_then() -> None:
    away = replace(ended(GPU, 6.0), cured_away=7.5)
    run = Run(away)
    assert run.fates == [("gpu_failure", "missed")]  # its process has ended by itself
    run.command(7.4, "segmentation", "redeploy")
    run.command(7.6, "segmentation", "redeploy")
    (outcome,) = score(run.timeline()).outcomes
    assert (outcome.fate, outcome.until, outcome.cured, outcome.observed_s) == ("cured", 6.0, 7.5, 6.0)
    assert [one.time for one in score(run.timeline()).mistreating] == [7.6]
    unnecessary = unnecessary_redeploys(score(run.timeline()).executed, run.timeline().injections)
    assert [one.time for one in unnecessary] == [7.6]


def test_what_is_done_after_a_cure_treats_no_fault_that_comes_later() -> None:
    later = replace(SHIFT, time=12.0)
    run = Run(replace(ended(SHIFT, 6.0), cured_away=7.5), later)
    for time in (7.4, 9.0, 10.0):
        run.recalibrate(time)
    assert [one.time for one in score(run.timeline()).mistreating] == [9.0, 10.0]
    run.faults = [ended(SHIFT, 6.0), later]
    assert [one.time for one in score(run.timeline()).mistreating] == [7.4, 9.0, 10.0]


def test_a_restart_cures_a_fault_that_comes_within_it() -> None:
    run = Run(ended(replace(CUDA, time=2.0), 2.3, "restart segmentation"))
    run.command(1.8, "segmentation", "deactivate")
    assert run.fates == [("cuda_out_of_memory", "missed")]
    run.command(2.2, "segmentation", "activate")
    assert (run.fates, run.mistreating) == ([("cuda_out_of_memory", "cured")], [])


def test_what_is_set_and_set_back_while_a_fault_is_away_is_no_preparation_for_it() -> None:
    run = Run(ended(DEPTH, 4.0), ended(replace(DEPTH, time=8.0), 12.0))
    for time, modality in ((5.0, "1"), (5.5, "2"), (6.0, "1")):
        run.set(time, "modality", modality)
    assert [one.time for one in score(run.timeline()).mistreating] == [5.0, 5.5]


def test_what_is_done_while_a_fault_is_away_treats_it_if_it_comes_again() -> None:
    first, second = ended(DEPTH, 4.0), ended(replace(DEPTH, time=8.0), 12.0)
    run = Run(first, second)
    run.set(6.0, "modality", "1")
    assert [(one.fate, one.cured) for one in score(run.timeline()).outcomes] == [
        ("missed", None),
        ("cured", 8.0),
    ]
    assert run.mistreating == []
    run.faults = [first]
    assert run.mistreating == ["set sensor_fusion.modality to 1"]


def test_a_process_that_ended_by_itself_cures_nothing() -> None:
    run = Run(ended(GPU, 5.0, "redeploy segmentation"))
    assert run.fates == [("gpu_failure", "missed")]
    run.command(4.9, "segmentation", "redeploy")
    assert run.fates == [("gpu_failure", "cured")]


def test_a_fault_that_is_there_at_the_end_was_observed_until_then() -> None:
    (outcome,) = score(Run(replace(GPU, time=3.0)).timeline()).outcomes
    assert (outcome.cured, outcome.observed_s) == (None, 17.0)


def test_a_fault_of_the_world_is_cured_when_the_last_step_of_a_cure_is_in_place() -> None:
    run = Run(DARK)
    run.state(2.0, "image_enhancement", "activate", "active")
    assert run.fates == [("image_degradation", "missed")]
    run.set(5.0, "topic_camera_input", "/managed_subsystem/rgb_enhanced")  # by its full name
    (outcome,) = score(run.timeline()).outcomes
    assert outcome.cured == 5.001
    assert run.mistreating == []


@pytest.mark.parametrize(("amount", "cured"), [("0.0", None), ("0.29", None), ("0.3", 5.001), ("0.9", 5.001)])
def test_a_cure_that_undoes_next_to_nothing_is_none(amount: str, cured: float | None) -> None:
    run = Run(DARK)
    run.set(-2.0, "image_degradation", amount, node="image_enhancement")
    run.settings.append(Setting(0.0, "/managed_subsystem/camera", "image_degradation", "0.9"))
    run.state(2.0, "image_enhancement", "activate", "active")
    run.set(5.0, "topic_camera_input", "rgb_enhanced")
    (outcome,) = score(run.timeline()).outcomes
    assert outcome.cured == cured
    run.set(9.0, "image_degradation", "0.9", node="image_enhancement")
    (outcome,) = score(run.timeline()).outcomes
    assert outcome.cured == (cured or 9.001)


def test_a_cure_that_is_taken_back_is_none() -> None:
    run = Run(DEPTH)
    run.set(2.0, "modality", "1")
    run.set(9.0, "modality", "0")
    assert run.fates == [("depth_degradation", "missed")]
    assert run.mistreating == ["set sensor_fusion.modality to 0"]
    run.set(12.0, "modality", "1")
    (outcome,) = score(run.timeline()).outcomes
    assert outcome.cured == 12.001


def test_a_cure_that_a_new_process_has_lost_is_none() -> None:
    run = Run(DEPTH)
    run.set(2.0, "modality", "1")
    run.settings.append(Setting(9.0, FUSION, "modality", "0", declared=True))
    assert run.fates == [("depth_degradation", "missed")]


def test_a_cure_in_the_last_second_is_none() -> None:
    run = Run(DEPTH)
    run.set(19.5, "modality", "1")
    assert run.fates == [("depth_degradation", "missed")]


def test_what_is_in_place_when_a_fault_heals_has_cured_it() -> None:
    run = Run(ended(DEPTH, 8.0))
    run.set(2.0, "modality", "1")
    run.set(9.0, "modality", "0")  # which is right: there is nothing to work around any more
    (outcome,) = score(run.timeline()).outcomes
    assert (outcome.cured, outcome.until) == (2.001, 8.0)
    assert run.mistreating == []


def test_a_work_around_from_before_a_fault_cures_at_once_and_was_blind() -> None:
    run = Run(replace(DEPTH, time=4.0))
    run.set(-1.0, "modality", "1")
    (outcome,) = score(run.timeline()).outcomes
    assert outcome.observed_s == 0.0
    assert run.mistreating == ["set sensor_fusion.modality to 1"]


def test_a_fault_that_comes_again_after_its_end_is_another_one() -> None:
    run = Run(ended(SHIFT, 4.0), replace(SHIFT, time=6.0))
    assert [(one.began, one.until) for one in score(run.timeline()).outcomes] == [(0.0, 4.0), (6.0, 20.0)]


def test_a_fault_that_is_injected_again_while_it_is_there_is_the_same_one() -> None:
    run = Run(SHIFT, ended(replace(SHIFT, time=6.0), 9.0, "redeploy sensor_fusion"))
    run.command(8.9, "sensor_fusion", "redeploy")
    (outcome,) = score(run.timeline()).outcomes
    assert (outcome.began, outcome.cured) == (0.0, 9.0)


# Masked


def masking(run: Run) -> Run:
    """Let the entropy fall at 5 s, since only the colour image is segmented from then on."""
    run.unsure(0.0, 5.0)
    run.set(5.0, "modality", "1")
    return run


def test_a_fault_is_masked_while_its_symptom_is_gone_and_it_is_not() -> None:
    run = masking(Run(SHIFT))
    metrics = score(run.timeline())
    # the mean of five is over 0.2 as long as one of them is 0.9: until the sample of 5.4 s
    assert metrics.masked_s == pytest.approx(14.6)
    assert metrics.faults_masked == 1
    assert metrics.outcomes[0].masked_s == metrics.masked_s
    assert run.mistreating == ["set sensor_fusion.modality to 1"]


def test_nothing_is_masked_of_which_the_symptom_holds() -> None:
    run = Run(SHIFT)
    run.unsure(0.0, 20.0)
    run.set(5.0, "modality", "1")
    assert run.fates == [("image_shift", "missed")]


def test_a_symptom_that_goes_by_itself_masks_nothing() -> None:
    run = Run(SHIFT)
    run.unsure(0.0, 5.0)
    run.recalibrate(1.0)
    run.command(2.0, "segmentation", "redeploy")
    assert run.fates == [("image_shift", "missed")]


def test_what_was_set_downstream_masks_nothing() -> None:
    run = Run(Injection(0.0, "autofocus_needed", "F5", "/managed_subsystem/camera"))
    run.set(1.0, "modality", "1")
    assert run.fates == [("autofocus_needed", "missed")]


@pytest.mark.parametrize(("bad", "fate"), [(0.42, "masked"), (0.43, "missed")])
def test_a_fault_is_masked_only_where_the_segmentation_is_bad(bad: float, fate: str) -> None:
    # 0.85 of 0.5 is 0.425
    assert masking(Run(SHIFT, bad=bad)).fates == [("image_shift", fate)]


def test_without_healthy_frames_to_compare_with_what_is_calm_is_masked() -> None:
    run = masking(Run(SHIFT, bad=0.5))
    assert run.fates == [("image_shift", "missed")]
    run.set(-2.7, "sharpness_threshold", "0.0", node="camera")  # at the fourth frame
    assert run.fates == [("image_shift", "masked")]


def test_only_what_lasts_a_second_masks() -> None:
    run = Run(SHIFT)
    run.unsure(0.0, 20.0)
    run.set(5.0, "modality", "1")
    for start in (6, 9, 12):
        run.entropy[30 + start * 10 : 30 + start * 10 + 13] = 0.1  # 0.9 s of means
    assert run.fates == [("image_shift", "missed")]
    run.entropy[30 + 73 : 30 + 75] = 0.1
    assert score(run.timeline()).masked_s == pytest.approx(1.1)


def test_what_masks_on_both_sides_of_lost_frames_lasts_a_second_on_one_of_them() -> None:
    run = Run(SHIFT)
    run.unsure(0.0, 5.0)
    run.unsure(7.0, 20.0)
    run.set(4.0, "modality", "1")
    whole = run.timeline()
    assert score(whole).masked_s == pytest.approx(1.6)
    frames = whole.frames
    came = ~((frames.times > 6.05) & (frames.times < 6.45))
    some = {name: getattr(frames, name)[came] for name in ("intersection", "predicted", "truth")}
    lossy = replace(whole, frames=Frames(frames.times[came], frames.iou[came], **some))
    assert score(lossy).masked_s == 0.0


def test_frames_without_truth_change_no_masked_time() -> None:
    whole = masking(Run(SHIFT)).timeline()
    frames = whole.frames
    known = np.arange(len(frames.times)) % 3 > 0
    some = {name: getattr(frames, name)[known] for name in ("intersection", "predicted", "truth")}
    part = replace(
        whole,
        frames=Frames(frames.times[known], frames.iou[known], **some),
        without_truth=frames.times[~known],
    )
    assert score(part).masked_s == score(whole).masked_s == pytest.approx(14.6)


def test_where_only_healthy_frames_have_a_truth_nothing_is_called_masked() -> None:
    whole = masking(Run(SHIFT)).timeline()
    frames = whole.frames
    known = frames.times < 0
    some = {name: getattr(frames, name)[known] for name in ("intersection", "predicted", "truth")}
    healthy = Frames(frames.times[known], frames.iou[known], **some)
    assert score(replace(whole, frames=healthy, without_truth=frames.times[~known])).masked_s == 0.0


def test_on_a_flight_without_truth_nothing_is_called_masked() -> None:
    whole = masking(Run(SHIFT)).timeline()
    metrics = score(replace(whole, frames=Frames(), without_truth=whole.frames.times))
    assert (metrics.iou, metrics.iou_all, metrics.iou_net, metrics.miou) == (None,) * 4
    assert (metrics.masked_s, metrics.faults_masked, metrics.outcomes[0].fate) == (None, None, "missed")
    assert metrics.frames_without_truth == 200


def test_what_masks_two_faults_counts_once_in_all() -> None:
    other = Injection(0.0, "unneeded_enhancement", "F4", FUSION, internal=False)
    metrics = score(masking(Run(SHIFT, other)).timeline())
    assert metrics.masked_s == pytest.approx(14.6)
    assert metrics.faults_masked == 2


def test_a_cure_of_one_fault_may_mask_another() -> None:
    run = masking(Run(SHIFT, DEPTH))
    assert run.fates == [("image_shift", "masked"), ("depth_degradation", "cured")]
    assert run.mistreating == []


def test_a_toggle_masks_through_the_mean_of_five_frames() -> None:
    run = Run(SHIFT)
    for number in range(40):
        run.set(number * 0.5, "modality", str(1 - number % 2))
    assert run.fates == [("image_shift", "masked")]
    assert len(run.mistreating) == 20  # what sets it back is not counted again


# Mistreated


def test_what_treats_another_fault_than_is_there_mistreats() -> None:
    run = Run(GPU)
    run.command(1.0, "segmentation", "deactivate")
    run.command(1.1, "segmentation", "activate")
    run.command(2.0, "camera", "redeploy")
    run.set(3.0, "modality", "1")
    assert run.mistreating == [
        "restart segmentation",
        "redeploy camera",
        "set sensor_fusion.modality to 1",
    ]


def test_the_parts_of_a_restart_are_steps_of_it_however_far_apart() -> None:
    run = Run(ended(CUDA, 6.0, "restart segmentation"))
    run.state(2.0, "segmentation", "deactivate", "inactive")
    run.state(5.9, "segmentation", "activate", "active")
    assert run.mistreating == []
    run.state(8.0, "segmentation", "deactivate", "inactive")
    assert run.mistreating == ["deactivate segmentation"]
    run.state(12.0, "segmentation", "activate", "active")  # as it was
    assert run.mistreating == ["deactivate segmentation"]


def test_a_step_of_a_cure_that_is_in_place_already_treats_nothing() -> None:
    run = Run(DEPTH)
    for time in (2.0, 3.0, 4.0):
        run.set(time, "modality", "1")
    assert run.mistreating == ["set sensor_fusion.modality to 1"] * 2


def test_what_is_set_of_a_node_that_a_cure_activates_is_a_step_of_it() -> None:
    run = Run(DARK)
    run.state(2.0, "image_enhancement", "activate", "active")
    run.set(3.0, "image_degradation", "0.5", node="image_enhancement")
    assert run.mistreating == []
    run.settings.append(Setting(0.0, "/managed_subsystem/camera", "image_degradation", "0.9"))
    run.set(4.0, "image_degradation", "0.2", node="image_enhancement")
    run.set(5.0, "image_degradation", "0.4", node="image_enhancement")
    assert run.mistreating == ["set image_enhancement.image_degradation to 0.2"]  # it undoes next to nothing
    other = Run(SHIFT)
    other.set(3.0, "image_degradation", "0.5", node="image_enhancement")
    assert other.mistreating == ["set image_enhancement.image_degradation to 0.5"]


def test_before_the_first_fault_everything_mistreats_but_setting_back() -> None:
    run = Run(SHIFT)
    run.set(-2.0, "modality", "2")
    run.set(-1.0, "modality", "0")
    run.set(-0.5, "modality", "0")  # as it is
    assert run.mistreating == ["set sensor_fusion.modality to 2", "set sensor_fusion.modality to 0"]


def test_a_call_that_sets_several_parameters_hides_none_that_treats_nothing() -> None:
    run = Run(SHIFT)
    names, values = ("do_recalibration", "modality", "topic_camera_input"), ("true", "1", "rgb_camera")
    run.commands.append(Command(1.0, "/mine", FUSION, "set_parameters", names, values))
    assert run.mistreating == [
        "set sensor_fusion.modality to 1"
    ]  # the topic stays as it was, which is no harm
    run.commands.append(Command(3.0, "/mine", FUSION, "set_parameters", names[1:], values[1:]))
    assert run.mistreating[1:] == [
        "set sensor_fusion.modality to 1",
        "set sensor_fusion.topic_camera_input to rgb_camera",
    ]


def test_a_shutdown_with_the_redeploy_after_it_cures() -> None:
    run = Run(ended(Injection(0.0, "gpu_failure", "F3", "/managed_subsystem/segmentation"), 2.0, "shutdown"))
    run.command(1.9, "segmentation", "shutdown")
    run.command(2.5, "segmentation", "redeploy")
    assert run.fates == [("gpu_failure", "cured")]
    assert run.mistreating == []


def test_each_adaptation_that_treats_nothing_costs_a_frame() -> None:
    run = Run(SHIFT, bad=0.5)
    untreated = score(run.timeline())
    run.recalibrate(1.0)
    treated = score(run.timeline())
    for second in range(2, 12):
        run.command(second, "segmentation", "redeploy")
    mistreated = score(run.timeline())
    for place in range(400):
        run.command(12 + place / 100, "segmentation", "redeploy")
    flooded = score(run.timeline())
    assert {one.iou_all for one in (untreated, treated, mistreated, flooded)} == {0.5}
    assert (untreated.iou_net, treated.iou_net, flooded.iou_net) == (0.5, 0.5, 0.0)
    assert mistreated.iou_net == pytest.approx(0.5 * 190 / 200)


def test_a_run_without_a_fault_has_nothing_to_cure() -> None:
    run = Run()
    run.command(1.0, "camera", "redeploy")
    metrics = score(run.timeline())
    assert (metrics.faults_injected, metrics.faults_cured, metrics.masked_s) == (0, None, None)
    assert metrics.adaptations_mistreated == 1


def test_a_fault_that_this_version_does_not_know_is_missed() -> None:
    run = Run(Injection(0.0, "gremlins", "F4", FUSION))
    run.recalibrate(1.0)
    assert run.fates == [("gremlins", "missed")]
    assert len(run.mistreating) == 1


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
def foggy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let this process's system have a fault whose cure is of two steps."""
    system = _process.system
    monkeypatch.setattr(_process, "system", type(system)(*system.parts, Extension(faults=(_FOG,))))


@pytest.mark.usefixtures("foggy")
def test_the_cures_of_an_extension_are_known() -> None:
    run = Run(Injection(0.0, "fog", "F4", "/managed_subsystem/camera", internal=False))
    run.set(2.0, "headlight", "true", node="camera")
    run.state(4.0, "depth", "deactivate", "inactive")
    (outcome,) = score(run.timeline()).outcomes
    assert outcome.cured == 4.001
    assert run.mistreating == []


def test_arrays_of_frames_may_be_empty() -> None:
    limits = {"entropy_threshold": 0.2, "sharpness_threshold": 0.1}
    (outcome,) = score(Timeline(thresholds=limits, injections=(SHIFT,))).outcomes
    assert outcome.fate == "missed"
