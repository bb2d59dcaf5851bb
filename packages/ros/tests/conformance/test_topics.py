import numpy as np
import pytest

from conformance.harness import Harness
from sunset_ros import CallbackError
from sunset_ros.interfaces.rcl_interfaces.msg import Log
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header, String
from sunset_ros.qos import (
    DurabilityPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_rosout_default,
    qos_profile_sensor_data,
)


def test_messages_arrive_in_order_and_as_sent(harness: Harness) -> None:
    harness.start("Talker")
    heard = harness.collect(String, "/chatter")
    assert harness.spin(lambda: len(heard) >= 5)
    numbers = [int(message.data) for message in heard]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))


def test_images_go_there_and_back(harness: Harness) -> None:
    harness.start("Echo")
    pixels = np.arange(256 * 144 * 3, dtype=np.uint32).astype(np.uint8)
    image = Image(
        header=Header(frame_id="test"), height=144, width=256, encoding="bgr8", step=768, data=pixels
    )
    publisher = harness.node.create_publisher(Image, "/images_in", 10)
    returned = harness.collect(Image, "/images_out")
    assert harness.spin(lambda: publisher.get_subscription_count() == 1)
    assert harness.spin(lambda: harness.node.count_publishers("/images_out") == 1)
    harness.pause(0.3)
    publisher.publish(image)
    assert harness.spin(lambda: len(returned) == 1)
    image.header.frame_id = "test/echo"
    assert returned == [image]


def test_a_late_comer_gets_what_was_latched(harness: Harness) -> None:
    harness.start("Talker")
    heard = harness.collect(String, "/chatter")
    assert harness.spin(lambda: bool(heard))  # its name was told before
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    volatile = harness.collect(String, "/talker/name")
    harness.pause(0.5)
    names = harness.collect(String, "/talker/name", latched)
    assert harness.spin(lambda: len(names) == 1)
    harness.pause(0.5)
    assert names == [String(data="/talker")]
    assert volatile == []


def test_a_reliable_reader_gets_nothing_from_a_best_effort_writer(harness: Harness) -> None:
    publisher = harness.node.create_publisher(String, "/best_effort", qos_profile_sensor_data)
    reliable = harness.collect(String, "/best_effort", QoSProfile(depth=10))
    best_effort = harness.collect(
        String, "/best_effort", QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    )
    assert harness.spin(lambda: publisher.get_subscription_count() == 1)
    harness.pause(0.3)
    publisher.publish(String(data="x"))
    assert harness.spin(lambda: len(best_effort) == 1)
    harness.pause(0.3)
    assert reliable == []


def test_names_are_remapped_from_the_command_line(harness: Harness) -> None:
    harness.start("Talker", "-r", "__ns:=/uav", "-r", "__node:=speaker", "-r", "chatter:=talk")
    heard = harness.collect(String, "/uav/talk")
    names = harness.collect(
        String, "/uav/speaker/name", QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    )
    assert harness.spin(lambda: bool(heard and names))
    assert names == [String(data="/uav/speaker")]


def test_logs_reach_late_comers_on_rosout(harness: Harness) -> None:
    harness.start("Talker", "-r", "__ns:=/uav")
    harness.pause(0.55)
    logs = harness.collect(Log, "/rosout", qos_profile_rosout_default)
    assert harness.spin(lambda: len(logs) >= 3)
    assert (logs[0].name, logs[0].level, logs[0].msg) == ("uav.talker", Log.INFO, "said 1")
    assert (logs[0].file, logs[0].function) == ("nodes.py", "tick")


def test_what_a_callback_raises_comes_out_of_spin(harness: Harness) -> None:
    harness.start("Talker")

    def fail(message: String) -> None:
        raise ValueError(message.data)

    harness.node.create_subscription(String, "/chatter", fail, 10)
    with pytest.raises(
        CallbackError, match=r"subscription of /chatter\) of node /tester raised ValueError"
    ) as caught:
        harness.spin(lambda: False)
    assert isinstance(caught.value.__cause__, ValueError)


def test_a_killed_talker_falls_silent_and_a_new_one_is_heard(harness: Harness) -> None:
    harness.start("Talker")
    heard = harness.collect(String, "/chatter")
    assert harness.spin(lambda: len(heard) >= 2)
    harness.kill("Talker")
    assert harness.spin(lambda: not harness.is_running("Talker"))
    harness.pause(0.3)
    before = len(heard)
    harness.pause(0.5)
    assert len(heard) == before
    harness.start("Talker")
    assert harness.spin(lambda: len(heard) >= before + 2)
