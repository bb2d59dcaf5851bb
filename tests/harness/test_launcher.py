"""How the launcher ends and starts processes, on a host that only keeps books."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

from sunset.harness.launcher import Launcher
from sunset.system_interfaces.srv import Redeploy
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState

if TYPE_CHECKING:
    from tests.conftest import World


class Host:
    """Processes by name; `done` says what was done to them."""

    def __init__(self, *running: str) -> None:
        self.running = set(running)
        self.done: list[str] = []
        self.on_exit: Callable[[str], object] = self.done.append

    def start(self, node: str) -> None:
        self.done.append(f"start {node}")
        self.running.add(node)

    def is_running(self, node: str) -> bool:
        return node in self.running

    def kill(self, node: str) -> None:
        self.done.append(f"kill {node}")
        self.end(node)

    def end(self, node: str) -> None:
        self.running.remove(node)
        self.on_exit(node)


@pytest.fixture
def host(world: "World") -> Host:
    host = Host("camera")
    world.start(lambda **options: Launcher(host, ("camera", "depth"), context=options["context"]))
    return host


def redeploy(world: "World", node: str) -> Redeploy.Response:
    response: Redeploy.Response = world.call(Redeploy, "/launcher/redeploy", Redeploy.Request(node=node))
    return response


def test_a_node_that_does_not_shut_down_is_killed_and_started_again(world: "World", host: Host) -> None:
    assert redeploy(world, "/managed_subsystem/camera").success
    world.run(0.9)
    assert host.done == []
    world.run(0.2)
    assert host.done == ["kill camera", "start camera"]
    world.run(5.0)
    assert host.done == ["kill camera", "start camera"]


def test_a_node_that_shuts_down_is_started_again_and_not_killed(world: "World", host: Host) -> None:
    asked: list[str] = []

    def answer(request: ChangeState.Request, response: ChangeState.Response) -> ChangeState.Response:
        asked.append(request.transition.label)
        host.end("camera")
        response.success = True
        return response

    world.tester.create_service(ChangeState, "/managed_subsystem/camera/change_state", answer)
    assert redeploy(world, "camera").success
    world.run(5.0)
    assert (asked, host.done) == (["shutdown"], ["start camera"])


def test_asking_twice_redeploys_once(world: "World", host: Host) -> None:
    redeploy(world, "camera")
    again = redeploy(world, "camera")
    assert (again.success, again.message) == (False, "camera is being redeployed already.")
    world.run(5.0)
    assert host.done == ["kill camera", "start camera"]


def test_a_node_that_is_dead_is_started(world: "World", host: Host) -> None:
    assert redeploy(world, "depth").success
    assert host.done == ["start depth"]


def test_a_process_that_ends_by_itself_stays_dead(world: "World", host: Host) -> None:
    host.end("camera")
    world.run(5.0)
    assert host.done == []


def test_a_node_that_does_not_exist_is_refused(world: "World", host: Host) -> None:
    response = redeploy(world, "lidar")
    assert not response.success
    assert response.message.endswith("named 'lidar': name one of camera, depth.")
    response = redeploy(world, "camra")
    assert response.message.endswith("named 'camra': did you mean 'camera', or name one of camera, depth.")
    assert host.done == []
