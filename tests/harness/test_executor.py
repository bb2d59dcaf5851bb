"""Injecting a scenario into real nodes, and keeping the world as it says."""

from typing import TYPE_CHECKING

import pytest

from sunset.errors import ScenarioError
from sunset.harness.executor import ScenarioExecutor
from sunset.nodes import AdaptiveNode, Camera, Depth, Fusion, ImageEnhancement
from sunset.scenarios import Scenario, ScenarioFault, generate, suite
from sunset.system import current_system
from sunset.system_interfaces.msg import FaultInjection
from sunset_ros.interfaces.std_srvs.srv import Trigger

FAULTS = current_system().faults

if TYPE_CHECKING:
    from tests.conftest import World

NODES: tuple[type[AdaptiveNode], ...] = (Camera, Depth, ImageEnhancement, Fusion)


def start(world: "World", node_class: type[AdaptiveNode]) -> AdaptiveNode:
    delay = {} if node_class is ImageEnhancement else {"lifecycle_activation_delay": 0.0}
    node = world.start(node_class, parameters=delay)
    world.run(0.2)
    return node


def redeploy(world: "World", node_class: type[AdaptiveNode]) -> AdaptiveNode:
    assert world.transition(node_class.node_name, "shutdown")
    return start(world, node_class)


@pytest.fixture
def nodes(world: "World") -> dict[str, AdaptiveNode]:
    return {node_class.node_name: start(world, node_class) for node_class in NODES}


def inject(world: "World", *faults: str, within: float = 0.1) -> Trigger.Response:
    world.start(ScenarioExecutor, generate(faults))
    world.run(0.1)
    response: Trigger.Response = world.call(
        Trigger, "/scenario_executor/inject", Trigger.Request(), within=within
    )
    return response


def injections(world: "World") -> list[FaultInjection]:
    made: list[FaultInjection] = world.messages["/experiment/injections"]
    return made


def test_all_faults_are_injected_at_once_and_confirmed(
    world: "World", nodes: dict[str, AdaptiveNode]
) -> None:
    response = inject(world, "hardware_disconnect", "image_shift=25", "autofocus_needed")
    assert (response.success, response.message) == (True, "Injected 3 faults.")
    assert nodes["camera"].parameter_values["hardware_disconnect"] is True
    assert nodes["camera"].parameter_values["autofocus_needed"] is True
    assert nodes["sensor_fusion"].parameter_values["image_shift"] == 25
    assert [(one.fault, one.value, one.confirmed) for one in injections(world)] == [
        ("hardware_disconnect", "true", True),
        ("image_shift", "25", True),
        ("autofocus_needed", "true", True),
    ]
    assert len({(one.stamp.sec, one.stamp.nanosec) for one in injections(world)}) == 1


def test_an_injection_says_all_that_the_evaluation_needs(
    world: "World", nodes: dict[str, AdaptiveNode]
) -> None:
    assert nodes
    before = world.now
    inject(world, "memory_leakage", "depth_degradation")
    first, second = injections(world)
    assert (first.failure, first.node, first.parameter) == (
        "F2",
        "/managed_subsystem/sensor_fusion",
        "memory_leakage",
    )
    assert (first.internal, first.redeploy_only) == (True, True)
    assert (second.failure, second.internal, second.redeploy_only) == ("F4", False, False)
    assert before + 0.1 <= first.stamp.sec + first.stamp.nanosec / 1e9 <= before + 0.102


def test_nothing_to_inject_is_a_success(world: "World") -> None:
    world.start(ScenarioExecutor, Scenario("nofault"))
    world.run(0.1)
    assert world.call(Trigger, "/scenario_executor/inject", Trigger.Request()).success
    assert injections(world) == []


def test_a_node_that_is_not_there_is_reported(world: "World") -> None:
    response = inject(world, "gpu_failure", within=3.0)
    assert not response.success
    assert response.message == "gpu_failure: segmentation did not answer within 2 s"
    assert [one.confirmed for one in injections(world)] == [False]


def test_a_refusal_is_reported(world: "World", nodes: dict[str, AdaptiveNode]) -> None:
    assert nodes
    assert world.transition("image_enhancement", "cleanup")
    response = inject(world, "unneeded_enhancement", "autofocus_needed")
    assert not response.success
    assert response.message == "unneeded_enhancement: image_enhancement refused to be activated"
    assert [one.confirmed for one in injections(world)] == [False, True]


def test_the_scenario_may_be_named_by_a_parameter(world: "World") -> None:
    executor = world.start(ScenarioExecutor, parameters={"scenario": "gpu_failure+image_shift"})
    assert [fault.name for fault in executor.scenario.faults] == ["gpu_failure", "image_shift"]
    with pytest.raises(ScenarioError, match="no scenario 'gremlin'"):
        world.start(ScenarioExecutor, parameters={"scenario": "gremlin"})


@pytest.mark.parametrize("name", ["image_degradation", "depth_degradation"])
def test_an_external_fault_outlasts_a_redeploy(
    world: "World", nodes: dict[str, AdaptiveNode], name: str
) -> None:
    fault = FAULTS[name]
    inject(world, name)
    node = redeploy(world, type(nodes[fault.node]))
    assert node.parameter_values[name] == fault.value
    node = redeploy(world, type(nodes[fault.node]))
    assert node.parameter_values[name] == fault.value
    assert len(injections(world)) == 1


def test_an_external_fault_comes_when_its_node_is_back(
    world: "World", nodes: dict[str, AdaptiveNode]
) -> None:
    assert nodes
    world.start(ScenarioExecutor, generate(("image_degradation",)))
    world.run(0.1)
    assert world.transition("camera", "shutdown")
    response = world.call(Trigger, "/scenario_executor/inject", Trigger.Request(), within=3.0)
    assert (response.success, [one.confirmed for one in injections(world)]) == (True, [True])
    node = start(world, Camera)
    assert node.parameter_values["image_degradation"] == FAULTS["image_degradation"].value


def test_the_weather_does_not_change_by_a_parameter(world: "World", nodes: dict[str, AdaptiveNode]) -> None:
    inject(world, "image_degradation")
    assert world.set("camera", "image_degradation", 0.0).successful
    world.run(0.05)
    assert nodes["camera"].parameter_values["image_degradation"] == FAULTS["image_degradation"].value


def test_an_internal_fault_ends_with_the_process(world: "World", nodes: dict[str, AdaptiveNode]) -> None:
    inject(world, "hardware_disconnect", "image_degradation")
    node = redeploy(world, type(nodes["camera"]))
    assert node.parameter_values["hardware_disconnect"] is False


def test_a_configuration_outlasts_a_redeploy_of_either_node(
    world: "World", nodes: dict[str, AdaptiveNode]
) -> None:
    assert nodes
    inject(world, "unneeded_enhancement")
    for node_class in (Fusion, ImageEnhancement):
        redeploy(world, node_class)
    assert world.messages["/diagnostics"][-1] is not None
    states = {
        message.status[0].hardware_id: message.status[0].message for message in world.messages["/diagnostics"]
    }
    assert states["image_enhancement"] == "active"
    topics = dict(world.subscriptions_of("/managed_subsystem/sensor_fusion"))
    assert "/managed_subsystem/rgb_enhanced" in topics


def test_a_configuration_that_was_corrected_stays_corrected(
    world: "World", nodes: dict[str, AdaptiveNode]
) -> None:
    assert nodes
    inject(world, "unneeded_enhancement")
    assert world.set("sensor_fusion", "topic_camera_input", "rgb_camera").successful
    node = redeploy(world, Fusion)
    assert node.parameter_values["topic_camera_input"] == "rgb_camera"


def test_an_enhancement_that_was_removed_stays_removed(
    world: "World", nodes: dict[str, AdaptiveNode]
) -> None:
    assert nodes
    inject(world, "unneeded_enhancement")
    assert world.transition("image_enhancement", "deactivate")
    redeploy(world, ImageEnhancement)
    assert world.messages["/diagnostics"][-1].status[0].message == "inactive"


def test_before_the_injection_nothing_is_touched(world: "World", nodes: dict[str, AdaptiveNode]) -> None:
    assert nodes
    world.start(ScenarioExecutor, Scenario("dim", (ScenarioFault("image_degradation"),)))
    world.run(0.1)
    assert redeploy(world, Camera).parameter_values["image_degradation"] == 0.0


def test_what_is_as_a_fault_needs_it_already_is_injected_too(
    world: "World", nodes: dict[str, AdaptiveNode]
) -> None:
    assert world.transition("image_enhancement", "activate")

    assert inject(world, "unneeded_enhancement").success

    assert nodes["sensor_fusion"].parameter_values["topic_camera_input"] == "rgb_enhanced"


def test_a_node_that_cannot_be_activated_is_reported(world: "World", nodes: dict[str, AdaptiveNode]) -> None:
    assert world.transition("image_enhancement", "cleanup")

    response = inject(world, "unneeded_enhancement")

    assert nodes
    assert not response.success
    assert response.message == "unneeded_enhancement: image_enhancement refused to be activated"


def test_the_graph_tells_nothing_of_the_scenario(world: "World") -> None:
    def endpoints(scenario: Scenario) -> list[tuple[str, str, str]]:
        executor = world.start(ScenarioExecutor, scenario)
        found = [
            (str(info.kind), info.name, info.type_name)
            for info in world.sim.endpoints()
            if info.node_name == "scenario_executor"
        ]
        world.kill(executor.get_name())
        return found

    (one, *others) = [endpoints(scenario) for scenario in (Scenario("nofault"), *suite("paper"))]

    assert len(others) == 54
    assert all(other == one for other in others)
