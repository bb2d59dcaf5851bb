"""`sunset node`: one process, which ends when it should."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest
from tests.live.systems import PATIENCE_S, Tool

from sunset_ros.interfaces.lifecycle_msgs.msg import Transition
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.rmw.dds.domains import free_domain_id

pytestmark = [pytest.mark.xdist_group("processes"), pytest.mark.thorough]

Process = subprocess.Popen[str]


@pytest.fixture
def domain_id() -> Iterator[int]:
    with free_domain_id() as number:
        yield number


@pytest.fixture
def tool(domain_id: int) -> Iterator[Tool]:
    made = Tool(domain_id)
    yield made
    made.node.context.try_shutdown()


@pytest.fixture
def camera(domain_id: int, tool: Tool) -> Iterator[Process]:
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "sunset", "node", "camera"),
            *("--ros-args", "-p", "lifecycle_activation_delay:=0.1"),
        ],
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"ROS_DOMAIN_ID": str(domain_id)},
    )
    assert tool.spin(lambda: ("camera", "/managed_subsystem") in tool.node.get_node_names_and_namespaces())
    with process:
        yield process
        process.kill()


def is_gone(tool: Tool) -> bool:
    nodes = tool.node.get_node_names_and_namespaces
    return tool.spin(lambda: ("camera", "/managed_subsystem") not in nodes())


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_leaves_the_graph_on_a_signal(camera: Process, tool: Tool, number: int) -> None:
    camera.send_signal(number)
    assert camera.wait(PATIENCE_S) == 0
    assert is_gone(tool)


def test_it_ends_when_its_lifecycle_is_shut_down(camera: Process, tool: Tool) -> None:
    request = ChangeState.Request(transition=Transition(label="shutdown"))
    assert tool.call(ChangeState, "/managed_subsystem/camera/change_state", request).success
    assert camera.wait(PATIENCE_S) == 0
    assert is_gone(tool)


def test_it_outlives_a_message_that_it_cannot_use(camera: Process, tool: Tool) -> None:
    images: list[Image] = []
    tool.node.create_subscription(Image, "/managed_subsystem/rgb_camera", images.append, 10)
    publisher = tool.node.create_publisher(Image, "/rgb_raw", 10)
    assert tool.spin(lambda: publisher.get_subscription_count() == 1)  # the camera is active
    publisher.publish(Image(width=7, height=5, encoding="bgr8", step=21, data=[1, 2, 3]))
    good = Image(width=2, height=1, encoding="bgr8", step=6, data=range(6))

    def arrived() -> bool:
        publisher.publish(good)
        return bool(images)

    assert tool.spin(arrived)
    assert (images[0].width, images[0].height) == (2, 1)
    assert camera.poll() is None


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["rotor"], "rotor"),
        (["camera", "--manager", "none"], "no other node has one"),
        (["managing_system"], "says which managing system"),
        (["camera", "--ros-args", "-p", "seven"], "NAME:=VALUE"),
        (["camera", "--ros-args", "-p", "image_degradation:=99.0"], "99"),
        (["bag_player"], "needs the parameter bag"),
        (["managing_system", "--manager", "nobody"], "nobody"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(domain_id: int, arguments: list[str], expected: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "sunset", "node", *arguments],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
        env=os.environ | {"ROS_DOMAIN_ID": str(domain_id)},
    )
    assert done.returncode == 2, done.stderr
    (sentence,) = done.stderr.strip().splitlines()
    assert sentence.startswith("sunset")
    assert expected in sentence
