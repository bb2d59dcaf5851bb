"""The monitor: what a managing system is shown."""

from typing import TYPE_CHECKING

import pytest

from sunset.harness.monitor import Monitor
from sunset.managing.symptoms import read_parameters
from sunset.nodes import Camera, Depth, Fusion, ImageEnhancement, SegmentationNode
from sunset.system_interfaces.msg import SensorFusion
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sunset_ros.interfaces.rosgraph_msgs.msg import Clock
from sunset_ros.interfaces.sensor_msgs.msg import Image

if TYPE_CHECKING:
    from tests.conftest import World


@pytest.fixture
def monitor(world: "World") -> Monitor:
    return world.start(Monitor)


def blackboard(world: "World") -> dict[str, object]:
    world.run(0.11)
    return dict(read_parameters(world.messages["/blackboard_group"][-1].bb_params))


def beat(world: "World", state: str, **values: str) -> None:
    items = [KeyValue(key=key, value=value) for key, value in values.items()]
    status = DiagnosticStatus(name="camera: heartbeat", hardware_id="camera", message=state, values=items)
    world.publish("/diagnostics", DiagnosticArray(status=[status]))


@pytest.mark.usefixtures("monitor")
def test_it_publishes_ten_times_a_second(world: "World") -> None:
    world.run(2.01)
    assert len(world.messages["/blackboard_group"]) == 20


@pytest.mark.usefixtures("monitor")
def test_a_topic_has_a_frequency_from_its_first_message_on(world: "World") -> None:
    assert blackboard(world) == {}
    world.publish("/rgb_raw", Image())
    assert blackboard(world)["rgb_raw_freq"] == 1.0
    world.run(1.0)
    assert blackboard(world)["rgb_raw_freq"] == 0.0


@pytest.mark.usefixtures("monitor")
def test_the_last_message_on_a_topic_has_an_age(world: "World") -> None:
    world.run(0.05)
    world.publish("/rgb_raw", Image())
    assert blackboard(world)["rgb_raw_age"] == pytest.approx(0.05, abs=0.002)  # as of 0.1 s
    world.run(0.4)
    assert blackboard(world)["rgb_raw_age"] == pytest.approx(0.55, abs=0.002)  # as of 0.6 s
    world.publish("/rgb_raw", Image())
    world.run(0.1)
    assert blackboard(world)["rgb_raw_age"] == pytest.approx(
        0.13, abs=0.002
    )  # published at 0.67 s, as of 0.8 s


@pytest.mark.usefixtures("monitor")
def test_a_frequency_is_the_count_of_the_last_second(world: "World") -> None:
    for _ in range(7):
        world.publish("/managed_subsystem/rgb_camera", Image())
        world.run(0.1)
    assert blackboard(world)["managed_subsystem_rgb_camera_freq"] == 7.0
    world.run(0.4)
    assert 0.0 < float(str(blackboard(world)["managed_subsystem_rgb_camera_freq"])) < 7.0
    world.run(1.0)
    assert blackboard(world)["managed_subsystem_rgb_camera_freq"] == 0.0


@pytest.mark.usefixtures("monitor")
def test_the_fused_topic_is_heard_too(world: "World") -> None:
    world.publish("/managed_subsystem/sensors_fused", SensorFusion())
    assert blackboard(world)["managed_subsystem_sensors_fused_freq"] == 1.0


@pytest.mark.usefixtures("monitor")
def test_numbers_are_means_of_the_last_five(world: "World") -> None:
    for value in ("100", "1", "2", "3", "4", "5"):
        beat(world, "active", sharpness=value)
    assert blackboard(world)["camera_sharpness"] == 3.0
    assert blackboard(world)["camera_sharpness"] == 3.0


@pytest.mark.usefixtures("monitor")
def test_no_verdict_is_made_of_less_than_five_numbers(world: "World") -> None:
    for value in ("1", "2", "3", "4"):
        assert "camera_sharpness" not in blackboard(world)
        beat(world, "active", sharpness=value)
    assert "camera_sharpness" not in blackboard(world)
    beat(world, "active", sharpness="5")
    assert blackboard(world)["camera_sharpness"] == 3.0


@pytest.mark.usefixtures("monitor")
def test_after_a_gap_numbers_from_before_it_do_not_count(world: "World") -> None:
    for _ in range(5):
        beat(world, "active", sharpness="100")
    world.run(1.5)
    for value in ("1", "2", "3", "4"):
        beat(world, "active", sharpness=value)
        assert blackboard(world)["camera_sharpness"] == 100.0
    beat(world, "active", sharpness="5")
    assert blackboard(world)["camera_sharpness"] == 3.0


@pytest.mark.usefixtures("monitor")
def test_flags_and_texts_are_the_last_ones(world: "World") -> None:
    beat(world, "active", autofocus_needed="true", mood="fine")
    assert blackboard(world)["camera_autofocus_needed"] is True
    beat(world, "active", autofocus_needed="false", mood="well")
    assert blackboard(world)["camera_autofocus_needed"] is False
    assert blackboard(world)["camera_mood"] == "well"


@pytest.mark.usefixtures("monitor")
def test_states_and_heartbeats_of_a_real_node(world: "World") -> None:
    world.start(Camera)
    world.run(1.5)
    seen = blackboard(world)
    assert (seen["camera_lc_state"], seen["camera_heartbeat_freq"]) == ("inactive", 10.0)
    world.run(3.0)
    assert blackboard(world)["camera_lc_state"] == "active"
    world.kill("camera")
    world.run(1.1)
    seen = blackboard(world)
    assert (seen["camera_lc_state"], seen["camera_heartbeat_freq"]) == ("unknown", 0.0)


def test_it_does_not_listen_to_the_truth(world: "World", monitor: Monitor) -> None:
    topics = {topic for topic, _ in world.subscriptions_of(monitor.get_fully_qualified_name())}
    assert not topics & {"/gt_segmentation", "/seg_metrics", "/experiment/injections", "/parameter_events"}


@pytest.mark.usefixtures("monitor")
def test_its_subscriptions_match_what_the_pipeline_publishes(world: "World") -> None:
    subscribed = set(world.subscriptions_of("/monitor"))
    published: set[tuple[str, str]] = set()
    for node_class in (Camera, Depth, ImageEnhancement, Fusion, SegmentationNode):
        world.start(node_class)
        published |= set(world.publishers_of(f"/managed_subsystem/{node_class.node_name}"))
    raw = {("/rgb_raw", "sensor_msgs/msg/Image"), ("/depth_raw", "sensor_msgs/msg/Image")}
    assert subscribed - raw <= published


@pytest.mark.usefixtures("monitor")
def test_a_value_is_what_was_said_last_be_it_number_flag_or_text(world: "World") -> None:
    for value, expected in (("broken", "broken"), ("true", True), ("broken", "broken")):
        beat(world, "active", sharpness=value)
        assert blackboard(world)["camera_sharpness"] == expected
    for value in ("1", "2", "3", "4", "5"):
        beat(world, "active", sharpness=value)
    assert blackboard(world)["camera_sharpness"] == 3.0


@pytest.mark.usefixtures("monitor")
def test_diagnostics_of_other_nodes_are_not_on_the_blackboard(world: "World") -> None:
    for name in ("robot", "none", "", "camera_sharpness", "image"):
        values = [KeyValue(key="enhancement_heartbeat_freq", value="1")] * 5
        status = DiagnosticStatus(name=f"{name}: heartbeat", hardware_id=name, values=values)
        world.publish("/diagnostics", DiagnosticArray(status=[status]))
    assert blackboard(world) == {}


def test_a_frequency_is_right_again_when_time_was_set_forth_and_back(world: "World") -> None:
    world.start(Monitor, parameters={"use_sim_time": True})
    for number in (1.0, 2e9, 2.0):
        seconds = int(number)
        world.publish("/clock", Clock(clock=Time(sec=seconds)))
        world.run(0.01)
        world.publish("/rgb_raw", Image())
        world.run(0.01)
    for tick in range(40):
        world.publish("/clock", Clock(clock=Time(sec=2 + tick // 10, nanosec=tick % 10 * 10**8)))
        world.run(0.01)
    assert blackboard(world)["rgb_raw_freq"] == 0.0
