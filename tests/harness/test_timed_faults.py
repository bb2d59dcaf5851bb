"""Faults that come later, grow, heal, come and go, and follow each other, in real nodes."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

from sunset.harness.executor import ScenarioExecutor
from sunset.nodes import AdaptiveNode, Camera, Depth, Fusion, ImageEnhancement
from sunset.scenarios import parse_scenario
from sunset_ros.interfaces.stamps import ns_of
from sunset_ros.interfaces.std_srvs.srv import Trigger

if TYPE_CHECKING:
    from tests.conftest import World

NODES: tuple[type[AdaptiveNode], ...] = (Camera, Depth, ImageEnhancement, Fusion)


def start(world: "World", node_class: type[AdaptiveNode], boot: float = 0.0) -> AdaptiveNode:
    delay = {} if node_class is ImageEnhancement else {"lifecycle_activation_delay": boot}
    return world.start(node_class, parameters=delay)


def redeploy(world: "World", node_class: type[AdaptiveNode], boot: float = 0.5) -> AdaptiveNode:
    assert world.transition(node_class.node_name, "shutdown")
    return start(world, node_class, boot)


class Play:
    """A scenario that has begun, at time 0."""

    def __init__(self, world: "World", *faults: str, before: Callable[[], object] = lambda: None) -> None:
        self.world = world
        self.nodes = {node_class.node_name: start(world, node_class) for node_class in NODES}
        text = "name: played\nfaults:\n" + "".join(f"- {{{fault}}}\n" for fault in faults)
        world.start(ScenarioExecutor, parse_scenario(text, "here"))
        world.run(0.3)
        before()
        world.run(0.2)
        client = world.tester.create_client(Trigger, "/scenario_executor/inject")
        self.answer = client.call_async(Trigger.Request())
        self.world.run(0.0005)  # it is on its way
        self.begin = self.world.now

    def until(self, time: float) -> None:
        self.world.run(self.begin + time - self.world.now)

    def value(self, node: str, parameter: str) -> object:
        return self.nodes[node].parameter_values[parameter]

    def seen(self, topic: str) -> list[tuple[float, str]]:
        """When faults came or ended, to a hundredth, and which."""
        return [
            (round(ns_of(one.stamp) / 1e9 - self.begin, 2), getattr(one, "cause", "") or one.fault)
            for one in self.world.messages[f"/experiment/{topic}"]
        ]

    @property
    def onsets(self) -> list[tuple[float, str]]:
        assert all(one.confirmed for one in self.world.messages["/experiment/injections"])
        return self.seen("injections")

    @property
    def ends(self) -> list[tuple[float, str]]:
        """The cause of an end, or the fault that healed."""
        return self.seen("fault_ends")


def test_a_fault_comes_and_heals_when_the_scenario_says_so(world: "World") -> None:
    play = Play(
        world, "name: hardware_disconnect, at: 1, until: 2", "name: image_degradation, at: 0.5, until: 2"
    )
    play.until(0.45)
    answer = play.answer.result()
    assert answer is not None
    assert answer.message == "Injected 0 faults; 2 more may follow."
    assert (play.value("camera", "hardware_disconnect"), play.value("camera", "image_degradation")) == (
        False,
        0.0,
    )
    play.until(1.5)
    assert (play.value("camera", "hardware_disconnect"), play.value("camera", "image_degradation")) == (
        True,
        0.9,
    )
    play.until(3)
    assert (play.value("camera", "hardware_disconnect"), play.value("camera", "image_degradation")) == (
        False,
        0.0,
    )
    assert play.value("camera", "fault_access") is False
    assert play.onsets == [(0.5, "image_degradation"), (1.0, "hardware_disconnect")]
    assert sorted(play.ends) == [(2.0, "hardware_disconnect"), (2.0, "image_degradation")]


def test_a_fault_that_was_cured_does_not_heal_again(world: "World") -> None:
    play = Play(world, "name: hardware_disconnect, until: 1.5", "name: camera_driver_issue, until: 1.5")
    play.until(0.3)
    assert world.transition("camera", "deactivate")
    assert world.transition("camera", "activate")
    play.until(0.6)
    redeploy(world, Camera)
    play.until(3)
    assert [cause for _, cause in play.ends] == ["restart camera", "redeploy camera"]


def test_a_fault_comes_again_after_it_was_cured(world: "World") -> None:
    play = Play(world, "name: autofocus_needed, until: 2", "name: autofocus_needed, at: 3")
    play.until(0.5)
    assert world.set("camera", "perform_autofocus", value=True).successful
    play.until(2.5)
    assert play.value("camera", "autofocus_needed") is False
    assert [cause for _, cause in play.ends] == ["set camera.perform_autofocus to true"]
    play.until(3.5)
    assert play.value("camera", "autofocus_needed") is True
    assert play.onsets == [(0.0, "autofocus_needed"), (3.0, "autofocus_needed")]


@pytest.mark.parametrize(
    ("fault", "node", "parameter", "half"),
    [
        ("name: image_shift, value: 10", "sensor_fusion", "image_shift", 5),
        ("name: depth_degradation, value: 0.5", "depth", "depth_degradation", 0.25),
    ],
)
def test_a_ramp_grows_from_nothing(
    world: "World", fault: str, node: str, parameter: str, half: float
) -> None:
    play = Play(world, f"{fault}, at: 1, until: 5, profile: {{kind: ramp, rise: 2}}")
    play.until(1.05)
    assert play.value(node, parameter) == 0
    play.until(2.05)
    assert play.value(node, parameter) == pytest.approx(half)
    play.until(4)
    assert play.value(node, parameter) == 2 * half
    assert play.onsets == [(1.0, parameter)]
    play.until(5.5)
    assert play.value(node, parameter) == 0
    assert play.ends == [(5.0, parameter)]


def test_a_ramp_ends_with_the_cure(world: "World") -> None:
    play = Play(world, "name: image_shift, profile: {kind: ramp, rise: 4}", "name: depth_degradation")
    play.until(2.05)
    assert world.set("sensor_fusion", "do_recalibration", value=True).successful
    play.until(5)
    assert play.value("sensor_fusion", "image_shift") == 0
    assert play.ends == [(2.05, "set sensor_fusion.do_recalibration to true")]


def test_an_external_ramp_goes_on_through_a_redeploy_and_an_attempt_to_set_it_back(world: "World") -> None:
    play = Play(world, "name: image_degradation, value: 1.0, profile: {kind: ramp, rise: 4}")
    play.until(1.01)
    assert world.set("camera", "image_degradation", 0.0).successful
    play.until(1.05)
    assert play.value("camera", "image_degradation") == pytest.approx(0.25)
    play.nodes["camera"] = redeploy(world, Camera)
    play.until(3.05)
    assert play.value("camera", "image_degradation") == pytest.approx(0.75)
    assert play.ends == []


def test_an_intermittent_fault_comes_and_goes_until_it_is_cured(world: "World") -> None:
    play = Play(
        world,
        "name: camera_driver_issue, at: 1, profile: {kind: intermittent, on: 1, off: 0.5}",
        "name: depth_degradation, until: 4, profile: {kind: intermittent, on: 1, off: 1}",
    )
    play.until(4.2)
    driver, noise = "camera_driver_issue", "depth_degradation"
    assert play.onsets == [(0.0, noise), (1.0, driver), (2.0, noise), (2.5, driver), (4.0, driver)]
    assert play.ends == [(1.0, noise), (2.0, driver), (3.0, noise), (3.5, driver)]  # and not at 4 again
    play.until(5.2)  # it is away
    assert world.transition("camera", "deactivate")
    assert world.transition("camera", "activate")
    play.until(8)
    assert play.onsets[-1] == (4.0, driver)
    assert play.ends[-2:] == [(5.0, driver), (5.25, "restart camera")]


def test_an_intermittent_fault_that_has_healed_for_good_is_not_cured(world: "World") -> None:
    play = Play(
        world, "name: camera_driver_issue, at: 1, until: 4, profile: {kind: intermittent, on: 1, off: 5}"
    )
    play.until(3)
    assert world.transition("camera", "deactivate")
    assert world.transition("camera", "activate")
    play.until(5)
    assert play.ends == [(2.0, "camera_driver_issue")]


def test_a_fault_follows_another_one_that_is_still_there(world: "World") -> None:
    play = Play(
        world,
        "name: camera_driver_issue",
        "name: hardware_disconnect, after: {fault: camera_driver_issue, delay: 2}",
        "name: sync_issue, at: 1",
        "name: memory_leakage, after: {fault: sync_issue, delay: 2}",
    )
    play.until(2.5)
    assert world.transition("sensor_fusion", "deactivate")
    assert world.transition("sensor_fusion", "activate")
    play.until(4)
    assert [fault for _, fault in play.onsets] == ["camera_driver_issue", "sync_issue", "hardware_disconnect"]
    assert play.onsets[-1] == (2.0, "hardware_disconnect")
    assert play.value("sensor_fusion", "memory_leakage") is False


@pytest.mark.parametrize("topic", ["rgb_enhanced", "/managed_subsystem/rgb_enhanced", "rgb_camera"])
def test_a_topic_of_a_cure_may_have_its_full_name(world: "World", topic: str) -> None:
    play = Play(
        world, "name: image_degradation", "name: image_shift, after: {fault: image_degradation, delay: 2}"
    )
    play.until(0.5)
    assert world.transition("image_enhancement", "activate")
    assert world.set("sensor_fusion", "topic_camera_input", topic).successful
    play.until(3)
    assert play.value("sensor_fusion", "image_shift") == (10 if topic == "rgb_camera" else 0)


@pytest.mark.parametrize("topic", ["/managed_subsystem/rgb_enhanced", "/managed_subsystem/rgb_camera"])
def test_a_configuration_is_over_when_another_topic_is_set_by_whatever_name(
    world: "World", topic: str
) -> None:
    play = Play(world, "name: unneeded_enhancement")
    play.until(0.5)
    assert world.set("sensor_fusion", "topic_camera_input", topic).successful
    play.until(1)
    assert len(play.ends) == topic.endswith("rgb_camera")


@pytest.mark.parametrize("cured", [True, False])
def test_an_external_fault_is_followed_unless_a_cure_works_around_it(world: "World", *, cured: bool) -> None:
    play = Play(
        world, "name: depth_degradation", "name: image_shift, after: {fault: depth_degradation, delay: 2}"
    )
    play.until(1)
    assert world.set("sensor_fusion", "modality", 1 if cured else 2).successful
    play.until(3)
    assert play.value("sensor_fusion", "image_shift") == (0 if cured else 10)


def test_a_configuration_heals_and_leaves_alone_what_was_there_before(world: "World") -> None:
    play = Play(
        world, "name: unneeded_enhancement, at: 1, until: 2", "name: unneeded_enhancement, at: 3, until: 5"
    )
    play.until(1.5)
    assert play.value("sensor_fusion", "topic_camera_input") == "rgb_enhanced"
    play.until(2.5)
    assert play.value("sensor_fusion", "topic_camera_input") == "rgb_camera"
    assert (
        world.messages["/managed_subsystem/image_enhancement/transition_event"][-1].goal_state.label
        == "inactive"
    )
    assert world.transition("image_enhancement", "activate")
    play.until(3.5)
    assert world.set("sensor_fusion", "topic_camera_input", "rgb_camera").successful
    play.until(6)
    assert (
        world.messages["/managed_subsystem/image_enhancement/transition_event"][-1].goal_state.label
        == "active"
    )
    assert [cause for _, cause in play.ends] == [
        "unneeded_enhancement",
        "set sensor_fusion.topic_camera_input to rgb_camera",
    ]


def test_a_ramp_holds_up_no_other_fault(world: "World") -> None:
    play = Play(
        world,
        "name: image_shift, value: 1, profile: {kind: ramp, rise: 3600}",
        "name: hardware_disconnect",
    )
    play.until(2)
    assert sorted(fault for _, fault in play.onsets) == ["hardware_disconnect", "image_shift"]
    assert all(time < 0.1 or fault == "image_shift" for time, fault in play.onsets)


def test_a_ramp_that_heals_before_its_first_step_never_comes(world: "World") -> None:
    play = Play(world, "name: image_degradation, at: 1, until: 1.05, profile: {kind: ramp, rise: 2}")
    play.until(3)
    assert play.onsets == play.ends == []


def test_an_internal_fault_waits_until_its_node_is_up(world: "World") -> None:
    play = Play(world, "name: camera_driver_issue, at: 1", "name: autofocus_needed, at: 1, until: 1.5")
    play.until(0.7)
    play.nodes["camera"] = redeploy(world, Camera, boot=2.0)
    play.until(2)
    assert play.value("camera", "camera_driver_issue") is False
    play.until(4)
    assert play.value("camera", "camera_driver_issue") is True
    ((onset, fault),) = play.onsets
    assert fault == "camera_driver_issue"
    assert 2.7 < onset < 2.8


def test_a_redeploy_before_the_measured_time_averts_no_fault(world: "World") -> None:
    play = Play(
        world,
        "name: camera_driver_issue",
        "name: sync_issue",
        before=lambda: redeploy(world, Camera, boot=2.0),
    )
    play.until(1)
    assert [fault for _, fault in play.onsets] == ["sync_issue"]
    answer = play.answer.result()
    assert answer is not None
    assert (answer.success, answer.message) == (True, "Injected 1 fault; 1 more may follow.")
    play.until(4)
    (_, (onset, fault)) = play.onsets
    assert fault == "camera_driver_issue"
    assert 1.4 < onset < 2.1
    assert play.ends == []


def test_a_fault_that_is_there_cannot_be_set_back_by_others(world: "World") -> None:
    play = Play(world, "name: hardware_disconnect")
    play.until(0.5)
    result = world.set("camera", "hardware_disconnect", value=False)
    assert (result.successful, result.reason) == (
        False,
        "hardware_disconnect is True and ends only with a redeploy of camera.",
    )
    assert play.ends == []


def test_nothing_of_the_scenario_is_logged(world: "World") -> None:
    play = Play(world, "name: image_degradation, at: 0.5, until: 1", "name: sync_issue, at: 1")
    world.kill("camera")
    play.until(4)
    assert not [line for line in world.messages["/rosout"] if line.name == "scenario_executor"]


def test_an_internal_fault_comes_when_a_node_that_was_killed_is_back(world: "World") -> None:
    play = Play(world, "name: camera_driver_issue, at: 1", "name: autofocus_needed, at: 1, until: 3")
    world.kill("camera")
    play.until(4)
    assert play.onsets == []
    play.nodes["camera"] = start(world, Camera)
    play.until(8)
    assert play.value("camera", "camera_driver_issue") is True
    assert [fault for _, fault in play.onsets] == ["camera_driver_issue"]


def test_steps_that_are_all_refused_are_all_said(world: "World") -> None:
    world.start(ScenarioExecutor, parse_scenario("name: a\nfaults: [unneeded_enhancement]\n", "here"))
    world.run(0.3)
    answer = world.call(Trigger, "/scenario_executor/inject", Trigger.Request(), within=3.0)
    assert answer.message == (
        "unneeded_enhancement: image_enhancement did not answer within 2 s; "
        "unneeded_enhancement: sensor_fusion did not answer within 2 s"
    )
