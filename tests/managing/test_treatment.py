"""Which failure is due, what a cure does, and what follows from its effect."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import pytest

from sunset.managing import ManagingSystem, Option, Symptoms, Treatment
from sunset.system.vocabulary import Failure, Value, frequency_entry

if TYPE_CHECKING:
    from tests.conftest import World

TOPICS = ("rgb_camera", "depth_camera", "sensors_fused", "segmentation")
ENHANCE = "activate image_enhancement and set sensor_fusion.topic_camera_input to rgb_enhanced"
USE_CAMERA = "set sensor_fusion.topic_camera_input to rgb_camera"
RECALIBRATE = "set sensor_fusion.do_recalibration to true"


class Recorded(ManagingSystem):
    """Keeps what is requested, at times that a test sets."""

    def on_start(self) -> None:
        self.time_s = 0.0
        self.done: list[str] = []
        self.treatment = Treatment(self)

    @property
    def now_s(self) -> float:
        return self.time_s

    def adapt(self, symptoms: Symptoms) -> None:
        """Do nothing: the tests decide."""

    def restart(self, node: str) -> None:  # type: ignore[override]
        self.done.append(f"restart {node}")

    def redeploy(self, node: str) -> None:  # type: ignore[override]
        self.done.append(f"redeploy {node}")

    def activate(self, node: str) -> None:  # type: ignore[override]
        self.done.append(f"activate {node}")

    def change_topic(self, node: str, parameter: str, topic: str) -> None:  # type: ignore[override]
        self.set_parameter(node, parameter, topic)

    def set_parameter(self, node: str, name: str, value: object) -> None:  # type: ignore[override]
        self.done.append(f"{node}.{name} = {value}")

    def due(self, after_s: float, symptoms: Symptoms) -> str:
        """Let time pass, and return the name of the failure that is due; empty if there is none."""
        self.time_s += after_s
        failure = self.treatment.due(symptoms)
        return failure.name if failure else ""

    def failure(self, name: str) -> Failure:
        """Return a failure by name."""
        return next(failure for failure in self.treatment.failures if failure.name == name)

    def option(self, name: str, cure: str) -> Option:
        """Return a cure of a failure by its words."""
        return next(one for one in self.treatment.options(self.failure(name)) if str(one) == cure)

    def untried(self, name: str) -> list[str]:
        """Return the untried cures of a failure in words."""
        return [str(option) for option in self.treatment.untried(self.failure(name))]


@pytest.fixture
def manager(world: "World") -> Recorded:
    thresholds = {"entropy_threshold": 0.1, "sharpness_threshold": 5.0}
    return world.start(Recorded, parameters=thresholds)


def show(*silent: str, entropy: float = 0.05, sharpness: float = 9.0) -> Symptoms:
    """Return symptoms with these topics silent."""
    values: Mapping[str, Value] = {
        **{frequency_entry(topic): 0.0 if topic in silent else 10.0 for topic in TOPICS},
        "segmentation_entropy": entropy,
        "camera_sharpness": sharpness,
    }
    return Symptoms(values)


def test_failures_are_in_the_order_of_the_pipeline_with_silences_that_no_catalogue_names(
    manager: Recorded,
) -> None:
    nodes = [manager.treatment.node(failure) for failure in manager.treatment.failures]
    assert sorted(set(nodes), key=nodes.index) == ["camera", "depth", "sensor_fusion", "segmentation"]
    (depth,) = [one for one in manager.treatment.failures if manager.treatment.node(one) == "depth"]
    assert list(map(str, manager.treatment.options(depth))) == ["restart depth", "redeploy depth"]


def test_a_cure_has_its_faults_and_the_time_until_it_shows(manager: Recorded) -> None:
    quick, slow = manager.treatment.options(manager.failure("F1"))
    assert (str(quick), quick.faults, quick.seconds) == ("restart camera", ("camera_driver_issue",), 0.5)
    assert (str(slow), slow.seconds) == ("redeploy camera", 4.5)
    assert slow.faults == ("camera_driver_issue", "hardware_disconnect")


def test_ripples_are_not_due(manager: Recorded) -> None:
    assert manager.due(1.0, show("rgb_camera", "sensors_fused", "segmentation", entropy=0.5)) == "F1"
    assert [failure.name for failure in manager.treatment.showing] == ["F1"]


def test_nothing_upstream_of_a_failure_waits_for_its_effect(manager: Recorded) -> None:
    both = show(entropy=0.5, sharpness=1.0)
    assert manager.due(1.0, both) == "F5"
    manager.treatment.try_cure(manager.failure("F5"), manager.treatment.untried(manager.failure("F5"))[0])
    assert manager.done == ["camera.perform_autofocus = True"]
    assert manager.due(0.2, both) == ""
    assert manager.due(0.8, show(entropy=0.5)) == "F4"


def test_a_cure_that_did_not_help_is_not_offered_for_a_while(manager: Recorded) -> None:
    silent = show("segmentation")
    assert manager.due(1.0, silent) == "F3"
    trial = manager.treatment.try_cure(
        manager.failure("F3"), manager.option("F3", "restart segmentation"), think_s=1.0
    )
    assert manager.due(1.4, silent) == ""
    outcomes = [trial.helped]
    assert manager.due(0.2, silent) == "F3"
    assert [*outcomes, trial.helped] == [None, False]
    assert manager.untried("F3") == ["redeploy segmentation"]
    manager.time_s += 8.0
    assert manager.untried("F3") == ["restart segmentation", "redeploy segmentation"]


def test_without_untried_cures_nothing_is_due(manager: Recorded) -> None:
    silent = show("segmentation")
    for cure in ("restart segmentation", "redeploy segmentation"):
        assert manager.due(0.6, silent) == "F3"
        manager.treatment.try_cure(manager.failure("F3"), manager.option("F3", cure))
    assert manager.due(2.6, silent) == ""


def test_after_a_cure_that_helped_all_cures_are_offered_again(manager: Recorded) -> None:
    assert manager.due(1.0, show("segmentation")) == "F3"
    trial = manager.treatment.try_cure(manager.failure("F3"), manager.option("F3", "restart segmentation"))
    assert manager.due(0.6, show()) == ""
    assert (trial.helped, trial.kept) == (True, True)
    assert manager.due(0.2, show("segmentation")) == "F3"
    assert manager.untried("F3") == ["restart segmentation", "redeploy segmentation"]


def test_a_cure_that_makes_the_signal_no_better_is_undone(manager: Recorded) -> None:
    assert manager.due(1.0, show(entropy=0.5)) == "F4"
    trial = manager.treatment.try_cure(manager.failure("F4"), manager.option("F4", ENHANCE))
    assert manager.done == ["activate image_enhancement", "sensor_fusion.topic_camera_input = rgb_enhanced"]
    assert manager.due(0.8, show(entropy=0.49)) == "F4"
    assert (trial.helped, trial.kept) == (False, False)
    assert manager.done[2:] == []  # it may think first
    manager.treatment.try_cure(manager.failure("F4"), manager.option("F4", RECALIBRATE))
    assert manager.done[2:] == [
        "sensor_fusion.topic_camera_input = rgb_camera",
        "sensor_fusion.do_recalibration = True",
    ]


def test_the_last_cure_is_undone_too(manager: Recorded) -> None:
    after_s = 0.8
    for option in reversed(manager.treatment.options(manager.failure("F4"))):
        assert manager.due(after_s, show(entropy=0.5)) == "F4"
        manager.treatment.try_cure(manager.failure("F4"), option)
        after_s = option.seconds + 0.1
    assert manager.done[-1] == "sensor_fusion.topic_camera_input = rgb_enhanced"
    assert manager.due(after_s, show(entropy=0.5)) == ""
    assert manager.done[-1] == "sensor_fusion.topic_camera_input = rgb_camera"


def test_a_cure_that_helps_against_one_of_two_faults_stays_and_is_not_offered(manager: Recorded) -> None:
    assert manager.due(1.0, show(entropy=0.2)) == "F4"
    trial = manager.treatment.try_cure(manager.failure("F4"), manager.option("F4", ENHANCE))
    assert manager.due(0.2, show(entropy=0.5)) == ""  # the mean was of frames from before the fault, too
    assert manager.due(0.6, show(entropy=0.3)) == "F4"
    assert (trial.helped, trial.kept) == (False, True)
    assert len(manager.done) == 2
    manager.time_s += 8.0
    assert ENHANCE not in manager.untried("F4")
    assert USE_CAMERA in manager.untried("F4")


def test_what_an_undone_cure_did_to_the_signal_does_not_speak_for_the_next(manager: Recorded) -> None:
    assert manager.due(1.0, show(entropy=0.5)) == "F4"
    manager.treatment.try_cure(manager.failure("F4"), manager.option("F4", ENHANCE))
    assert manager.due(0.8, show(entropy=0.8)) == "F4"
    trial = manager.treatment.try_cure(manager.failure("F4"), manager.option("F4", RECALIBRATE))
    assert manager.due(0.2, show(entropy=0.8)) == ""
    assert manager.due(0.6, show(entropy=0.5)) == "F4"
    assert trial.kept is False


def test_a_signal_counts_when_all_its_frames_are_new(manager: Recorded) -> None:
    assert manager.due(1.0, show("segmentation", entropy=0.5)) == "F3"
    assert manager.due(0.2, show(entropy=0.5)) == ""
    assert manager.due(0.8, show(entropy=0.5)) == "F4"
