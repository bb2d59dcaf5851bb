"""`sunset up`: a process a node, redeploy, faults that outlast it, and no orphans."""

import os
import signal
from collections.abc import Iterator

import pytest
from tests.live.systems import Tool, Up, eventually, exists, going_up

from sunset.system_interfaces.srv import Redeploy
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState, GetState
from sunset_ros.interfaces.rcl_interfaces.srv import GetParameters

pytestmark = [pytest.mark.xdist_group("processes"), pytest.mark.thorough]

NODES = {
    *("camera", "depth", "image_enhancement", "sensor_fusion", "segmentation"),
    *("bag_player", "monitor", "evaluator", "scenario_executor"),
}
MANAGED = ("camera", "depth", "sensor_fusion", "segmentation", "image_enhancement")
TRANSITIONS = {"configure": Transition.TRANSITION_CONFIGURE, "activate": Transition.TRANSITION_ACTIVATE}
STRENGTH = 0.8


@pytest.fixture(scope="module")
def system(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Up, Tool]]:
    scenario = tmp_path_factory.mktemp("up") / "dark.yaml"
    scenario.write_text(f"name: dark\nfaults: [{{name: image_degradation, value: {STRENGTH}}}]\n")
    with going_up("--scenario", str(scenario)) as pair:
        assert pair[0].tells("The faults are injected")
        yield pair


def state(tool: Tool, node: str) -> str:
    response = tool.call(GetState, f"/managed_subsystem/{node}/get_state", GetState.Request())
    label: str = response.current_state.label
    return label


def redeploy(tool: Tool, node: str) -> str:
    response = tool.call(Redeploy, "/launcher/redeploy", Redeploy.Request(node=node))
    assert response.success, response.message
    message: str = response.message
    return message


def test_every_node_is_a_process_of_its_own(system: tuple[Up, Tool]) -> None:
    pids = system[0].pids
    assert set(pids) == NODES
    assert len(set(pids.values())) == len(pids)
    assert all(exists(pid) for pid in pids.values())


def test_all_nodes_are_on_the_graph(system: tuple[Up, Tool]) -> None:
    tool = system[1]

    def names() -> set[str]:
        return {name for name, _ in tool.node.get_node_names_and_namespaces()}

    assert tool.spin(lambda: names() >= NODES | {"launcher", "operator"})


def test_time_comes_from_the_bag_player(system: tuple[Up, Tool]) -> None:
    request = GetParameters.Request(names=["use_sim_time"])
    for node, expected in {"/managed_subsystem/camera": True, "/monitor": True, "/bag_player": False}.items():
        (value,) = system[1].call(GetParameters, f"{node}/get_parameters", request).values
        assert value.bool_value is expected


def test_a_redeployed_node_has_a_new_process_and_the_fault_of_the_world(system: tuple[Up, Tool]) -> None:
    up, tool = system
    before = up.pids["camera"]
    assert redeploy(tool, "camera") == "camera is shut down and started again."
    assert eventually(lambda: up.pids["camera"] != before and up.state("camera").startswith("active"))
    assert not exists(before)
    name = "/managed_subsystem/camera/get_parameters"
    request = GetParameters.Request(names=["image_degradation", "sharpness_threshold"])

    def values() -> list[float]:
        return [value.double_value for value in tool.call(GetParameters, name, request).values]

    assert eventually(lambda: values()[0] == STRENGTH)
    assert values()[1] > 0  # as the first one's


def test_a_node_whose_process_dies_stays_dead_until_somebody_redeploys_it(system: tuple[Up, Tool]) -> None:
    up, tool = system
    before = up.pids["depth"]
    os.kill(before, signal.SIGKILL)
    assert eventually(lambda: up.state("depth").startswith("ended by signal 9"))
    assert up.pids["depth"] == before
    assert redeploy(tool, "depth") == "depth was not running and is started."
    assert eventually(lambda: up.pids["depth"] != before and up.state("depth").startswith("active"))


def test_a_node_that_does_not_react_is_redeployed_by_force(system: tuple[Up, Tool]) -> None:
    up, tool = system
    before = up.pids["segmentation"]
    os.kill(before, signal.SIGSTOP)
    redeploy(tool, "segmentation")
    assert eventually(lambda: up.pids["segmentation"] != before)
    assert not exists(before)
    assert eventually(lambda: up.state("segmentation").startswith("active"))
    assert state(tool, "segmentation") == "active"


def test_unknown_nodes_are_not_redeployed(system: tuple[Up, Tool]) -> None:
    response = system[1].call(Redeploy, "/launcher/redeploy", Redeploy.Request(node="rotor"))
    assert not response.success
    assert "rotor" in response.message


def test_sigterm_ends_all_processes(system: tuple[Up, Tool]) -> None:
    up = system[0]
    pids = up.pids
    assert up.end(signal.SIGTERM) == 0
    assert [node for node, pid in pids.items() if exists(pid)] == []


def test_all_processes_end_with_a_parent_that_is_killed_even_one_that_is_stopped() -> None:
    with going_up() as (up, _):
        os.kill(up.pids["depth"], signal.SIGSTOP)
        up.process.kill()
        pids = up.pids.values()
        assert eventually(lambda: not any(exists(pid) for pid in pids))


def test_a_lifecycle_manager_brings_the_system_up() -> None:
    with going_up("--no-autostart", until="unconfigured") as (up, tool):
        for label in ("configure", "activate"):  # all of the one, then all of the other
            for node in MANAGED:
                name = f"/managed_subsystem/{node}/change_state"
                request = ChangeState.Request(transition=Transition(id=TRANSITIONS[label]))
                assert tool.call(ChangeState, name, request).success, f"{label} {node}"
                assert state(tool, node) == {"configure": "inactive", "activate": "active"}[label]
        assert up.is_up()
