"""The sensor fusion: pairs, modalities, faults, and the published exemplar's stale frames."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest

from sunset.image_messages import array_of_bgr, stamp_ns
from sunset.nodes import Fusion
from sunset.system_interfaces.msg import SensorFusion
from sunset_ros.interfaces.sensor_msgs.msg import Image

if TYPE_CHECKING:
    from tests.conftest import World

Make = Callable[[float], Image]

RGB_IN = "/managed_subsystem/rgb_camera"
ENHANCED_IN = "/managed_subsystem/rgb_enhanced"
DEPTH_IN = "/managed_subsystem/depth_camera"
OUT = "/managed_subsystem/sensors_fused"


@pytest.fixture
def fusion(world: "World") -> Fusion:
    node = world.start(Fusion, parameters={"lifecycle_activation_delay": 0.0})
    world.run(0.1)
    return node


def feed(world: "World", *arrivals: tuple[str, Image]) -> list[SensorFusion]:
    before = len(world.messages[OUT])
    for topic, image in arrivals:
        world.publish(topic, image)
        world.run(0.01)
    made: list[SensorFusion] = world.messages[OUT][before:]
    return made


def stamps(fused: list[SensorFusion]) -> list[float]:
    return [stamp_ns(message.header) / 1e9 for message in fused]


def restart(world: "World") -> None:
    assert world.transition("sensor_fusion", "deactivate")
    assert world.transition("sensor_fusion", "activate")


def test_its_boot_time_is_the_papers(world: "World") -> None:
    assert world.start(Fusion).lifecycle_activation_delay == 2.0


@pytest.mark.usefixtures("fusion")
@pytest.mark.parametrize("modality", [0, 1])
def test_what_is_no_colour_image_is_dropped(world: "World", rgb: Make, depth: Make, modality: int) -> None:
    world.set("sensor_fusion", "modality", modality)
    world.set("sensor_fusion", "topic_camera_input", "depth_camera")
    assert feed(world, (DEPTH_IN, depth(1.0))) == []
    (line,) = [log.msg for log in world.messages["/rosout"] if log.name.endswith("sensor_fusion")]
    assert line.startswith("Dropped an image on depth_camera: An image must have the encoding bgr8")
    world.set("sensor_fusion", "topic_camera_input", "rgb_camera")
    assert len(feed(world, (RGB_IN, rgb(2.0)), (DEPTH_IN, depth(2.0)))) == 1


@pytest.mark.usefixtures("fusion")
def test_a_matched_pair_is_published_unchanged(world: "World", rgb: Make, depth: Make) -> None:
    (fused,) = feed(world, (RGB_IN, rgb(1.0)), (DEPTH_IN, depth(1.0)))
    assert (fused.rgb, fused.depth, fused.header) == (rgb(1.0), depth(1.0), rgb(1.0).header)
    assert fused.modality.fusion_type == 0


@pytest.mark.usefixtures("fusion")
def test_images_too_far_apart_are_no_pair(world: "World", rgb: Make, depth: Make) -> None:
    assert feed(world, (RGB_IN, rgb(1.0)), (DEPTH_IN, depth(1.02))) == []
    assert world.set("sensor_fusion", "delta_t_threshold", 0.05).successful
    assert stamps(feed(world, (RGB_IN, rgb(1.04)))) == [1.04]


@pytest.mark.usefixtures("fusion")
def test_a_stale_frame_is_never_published_again(world: "World", rgb: Make, depth: Make) -> None:
    feed(world, (RGB_IN, rgb(1.0)), (DEPTH_IN, depth(1.0)))
    again = [(RGB_IN, rgb(1.0)), (DEPTH_IN, depth(1.0))] * 3
    assert feed(world, *again) == []
    # the camera is dead, the depth goes on: nothing may come out
    assert feed(world, *((DEPTH_IN, depth(1.1 + t / 10)) for t in range(20))) == []


@pytest.mark.usefixtures("fusion")
def test_what_arrives_late_is_not_published_after_something_newer(
    world: "World", rgb: Make, depth: Make
) -> None:
    arrivals = [(RGB_IN, rgb(1.0)), (RGB_IN, rgb(1.1)), (DEPTH_IN, depth(1.1)), (DEPTH_IN, depth(1.0))]
    assert stamps(feed(world, *arrivals)) == [1.1]


@pytest.mark.usefixtures("fusion")
def test_out_of_order_arrivals_are_matched_by_stamp(world: "World", rgb: Make, depth: Make) -> None:
    arrivals = [(DEPTH_IN, depth(1.1)), (DEPTH_IN, depth(1.0)), (RGB_IN, rgb(1.0)), (RGB_IN, rgb(1.1))]
    assert stamps(feed(world, *arrivals)) == [1.0, 1.1]


@pytest.mark.parametrize(("modality", "published"), [(1, RGB_IN), (2, DEPTH_IN)])
@pytest.mark.usefixtures("fusion")
def test_one_modality_needs_one_sensor(
    world: "World", rgb: Make, depth: Make, modality: int, published: str
) -> None:
    assert world.set("sensor_fusion", "modality", modality).successful
    (fused,) = feed(world, (RGB_IN, rgb(1.0))) + feed(world, (DEPTH_IN, depth(1.0)))
    assert fused.modality.fusion_type == modality
    assert fused.rgb == (rgb(1.0) if published == RGB_IN else Image())
    assert fused.depth == (depth(1.0) if published == DEPTH_IN else Image())
    again = feed(world, (RGB_IN, rgb(1.0)), (DEPTH_IN, depth(1.0)))
    assert again == []


@pytest.mark.parametrize("modality", [0, 1, 2])
@pytest.mark.usefixtures("fusion")
def test_false_stamps_and_a_clock_set_back_silence_nothing(
    world: "World", rgb: Make, depth: Make, modality: int
) -> None:
    assert world.set("sensor_fusion", "modality", modality).successful
    for stamp in (100.0, 4e6, 100.1, 4e6, 100.2, 0.0, 0.1):
        frame = (RGB_IN, rgb(stamp)), (DEPTH_IN, depth(stamp))
        assert stamps(feed(world, *frame, *frame)) == [stamp]


@pytest.mark.usefixtures("fusion")
def test_a_wide_tolerance_is_no_clock_set_back(world: "World", rgb: Make, depth: Make) -> None:
    assert world.set("sensor_fusion", "delta_t_threshold", 10.0).successful
    assert feed(world, (RGB_IN, rgb(1.0))) == []
    assert world.set("sensor_fusion", "modality", 2).successful
    assert stamps(feed(world, (DEPTH_IN, depth(9.0)))) == [9.0]
    assert world.set("sensor_fusion", "modality", 0).successful
    assert feed(world, (DEPTH_IN, depth(9.1))) == []  # its pair is of 1.0


@pytest.mark.usefixtures("fusion")
def test_a_frame_is_published_once_across_modalities(world: "World", rgb: Make, depth: Make) -> None:
    feed(world, (RGB_IN, rgb(1.0)), (DEPTH_IN, depth(1.0)))
    assert world.set("sensor_fusion", "modality", 1).successful
    assert stamps(feed(world, (RGB_IN, rgb(1.0)), (RGB_IN, rgb(1.1)))) == [1.1]


@pytest.mark.usefixtures("fusion")
def test_no_image_of_the_topic_before_is_published_after_the_change(
    world: "World", rgb: Make, depth: Make
) -> None:
    assert feed(world, (RGB_IN, rgb(1.0))) == []
    assert world.set("sensor_fusion", "topic_camera_input", "rgb_enhanced").successful
    assert feed(world, (DEPTH_IN, depth(1.0)), (RGB_IN, rgb(1.1)), (DEPTH_IN, depth(1.1))) == []
    assert stamps(feed(world, (ENHANCED_IN, rgb(1.1)))) == [1.1]


@pytest.mark.parametrize("fault", ["sync_issue", "memory_leakage"])
@pytest.mark.usefixtures("fusion")
def test_an_outage_is_silence_and_only_its_cures_end_it(
    world: "World", rgb: Make, depth: Make, fault: str
) -> None:
    assert world.set("sensor_fusion", fault, value=True).successful
    assert feed(world, (RGB_IN, rgb(1.0)), (DEPTH_IN, depth(1.0))) == []
    assert world.set("sensor_fusion", "do_recalibration", value=True).successful
    assert world.set("sensor_fusion", "modality", 1).successful
    assert feed(world, (RGB_IN, rgb(1.1))) == []
    restart(world)
    assert len(feed(world, (RGB_IN, rgb(1.2)))) == (fault == "sync_issue")


@pytest.mark.usefixtures("fusion")
def test_a_shift_moves_the_colour_image_in_proportion_to_its_width(
    world: "World", rgb: Make, depth: Make
) -> None:
    assert world.set("sensor_fusion", "image_shift", 40).successful
    (fused,) = feed(world, (RGB_IN, rgb(1.0)), (DEPTH_IN, depth(1.0)))
    original, shifted = array_of_bgr(rgb(1.0)), array_of_bgr(fused.rgb)
    np.testing.assert_array_equal(shifted[:, 10:], original[:, :-10])
    assert not shifted[:, :10].any()
    assert fused.depth == depth(1.0)


@pytest.mark.usefixtures("fusion")
def test_a_shift_survives_a_restart_and_ends_with_the_recalibration(
    world: "World", rgb: Make, depth: Make
) -> None:
    assert world.set("sensor_fusion", "image_shift", 40).successful
    restart(world)
    (fused,) = feed(world, (RGB_IN, rgb(1.0)), (DEPTH_IN, depth(1.0)))
    assert fused.rgb != rgb(1.0)
    assert world.set("sensor_fusion", "do_recalibration", value=True).successful
    (fused,) = feed(world, (RGB_IN, rgb(1.1)), (DEPTH_IN, depth(1.1)))
    assert fused.rgb == rgb(1.1)


@pytest.mark.usefixtures("fusion")
def test_images_without_a_partner_do_not_pile_up(world: "World", rgb: Make, fusion: Fusion) -> None:
    feed(world, *((RGB_IN, rgb(1.0 + t / 10)) for t in range(30)))
    assert len(fusion._pairs._left.waiting) == 10
