"""The camera, the depth camera and the enhancement."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import pytest

from sunset.faults import blur, degrade_depth, degrade_image, enhance_image, sharpness
from sunset.image_messages import array_of_bgr, array_of_depth, image_of_bgr
from sunset.nodes import Camera, Depth, ImageEnhancement
from sunset.system import BLUR_SIGMA, current_system
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.seeding import generator

FAULTS = current_system().faults

if TYPE_CHECKING:
    from tests.conftest import World

Make = Callable[[float], Image]

RGB_OUT = "/managed_subsystem/rgb_camera"
DEPTH_OUT = "/managed_subsystem/depth_camera"
ENHANCED_OUT = "/managed_subsystem/rgb_enhanced"

SUITE_STRENGTH = float(FAULTS["image_degradation"].value)


@pytest.fixture
def camera(world: "World") -> Camera:
    node = world.start(Camera, parameters={"sharpness_threshold": 1.0, "lifecycle_activation_delay": 0.0})
    world.run(0.1)
    return node


@pytest.fixture
def depth_camera(world: "World") -> Depth:
    node = world.start(Depth, parameters={"seed": 7, "lifecycle_activation_delay": 0.0})
    world.run(0.1)
    return node


@pytest.mark.usefixtures("camera")
def test_a_refusal_offers_nothing_that_a_managing_system_must_not_set(world: "World") -> None:
    result = world.set("camera", "autofocus", True)
    assert result.reason.endswith(
        "is not declared: did you mean 'perform_autofocus', or name one of sharpness_threshold, perform_autofocus."
    )


def feed(world: "World", topic: str, out: str, *images: Image) -> list[Image]:
    before = len(world.messages[out])
    for image in images:
        world.publish(topic, image)
        world.run(0.1)
    made: list[Image] = world.messages[out][before:]
    return made


def reported(world: "World", key: str) -> list[str]:
    return [
        item.value
        for message in world.messages["/diagnostics"]
        for item in message.status[0].values
        if item.key == key
    ]


def pixels(image: Image) -> npt.NDArray[np.int64]:
    return array_of_bgr(image).astype(np.int64)


def test_the_default_boot_times_are_the_papers(world: "World") -> None:
    assert world.start(Camera).lifecycle_activation_delay == 4.0
    assert world.start(Depth).lifecycle_activation_delay == 4.0
    assert world.start(ImageEnhancement).lifecycle_activation_delay < 0


@pytest.mark.usefixtures("camera")
def test_a_healthy_camera_changes_nothing(world: "World", rgb: Make) -> None:
    (out,) = feed(world, "/rgb_raw", RGB_OUT, rgb(1.0))
    assert out == rgb(1.0)


@pytest.mark.parametrize("fault", ["camera_driver_issue", "hardware_disconnect"])
@pytest.mark.usefixtures("camera")
def test_an_outage_is_silence_and_only_its_cures_end_it(world: "World", rgb: Make, fault: str) -> None:
    assert world.set("camera", fault, value=True).successful
    assert feed(world, "/rgb_raw", RGB_OUT, rgb(1.0)) == []
    assert world.set("camera", "perform_autofocus", value=True).successful
    assert feed(world, "/rgb_raw", RGB_OUT, rgb(1.1)) == []
    assert world.transition("camera", "deactivate")
    assert world.transition("camera", "activate")
    assert len(feed(world, "/rgb_raw", RGB_OUT, rgb(1.2))) == (fault == "camera_driver_issue")


@pytest.mark.usefixtures("camera")
def test_a_degraded_image_is_darker_everywhere_and_never_wraps(world: "World", rgb: Make) -> None:
    world.set("camera", "image_degradation", 1.5)
    (out,) = feed(world, "/rgb_raw", RGB_OUT, rgb(1.0))
    np.testing.assert_array_equal(array_of_bgr(out), degrade_image(array_of_bgr(rgb(1.0)), 1.5))
    assert (pixels(out) <= 0.25 * pixels(rgb(1.0)).max(axis=2, keepdims=True) + 1).all()


@pytest.mark.usefixtures("camera")
def test_the_blur_survives_a_restart_and_ends_with_the_autofocus(world: "World", rgb: Make) -> None:
    world.set("camera", "autofocus_needed", value=True)
    sigma = BLUR_SIGMA * 64 / 256
    (out,) = feed(world, "/rgb_raw", RGB_OUT, rgb(1.0))
    np.testing.assert_array_equal(array_of_bgr(out), blur(array_of_bgr(rgb(1.0)), sigma))
    assert world.transition("camera", "deactivate")
    assert world.transition("camera", "activate")
    assert feed(world, "/rgb_raw", RGB_OUT, rgb(1.1)) != [rgb(1.1)]
    world.set("camera", "perform_autofocus", value=True)
    assert feed(world, "/rgb_raw", RGB_OUT, rgb(1.2)) == [rgb(1.2)]


def test_sharpness_is_measured_on_what_is_published(world: "World", camera: Camera, rgb: Make) -> None:
    feed(world, "/rgb_raw", RGB_OUT, rgb(1.0))
    world.set("camera", "autofocus_needed", value=True)
    (out,) = feed(world, "/rgb_raw", RGB_OUT, rgb(1.1))
    world.run(0.1)
    expected = [sharpness(array_of_bgr(rgb(1.0))), sharpness(array_of_bgr(out))]
    assert [float(value) for value in reported(world, "sharpness")] == expected
    assert expected[1] < expected[0]
    assert camera.autofocus_needed


@pytest.mark.usefixtures("camera")
def test_autofocus_needed_is_derived_from_the_image_not_from_the_fault(world: "World", rgb: Make) -> None:
    smooth = [image_of_bgr(rgb(t).header, blur(array_of_bgr(rgb(t)), 3.0)) for t in range(6)]
    feed(world, "/rgb_raw", RGB_OUT, *smooth)
    world.run(0.1)
    assert reported(world, "autofocus_needed") == ["true", "true"]


@pytest.mark.usefixtures("camera")
def test_autofocus_needed_looks_at_the_mean_of_five_images(world: "World", rgb: Make) -> None:
    flat = image_of_bgr(rgb(2.0).header, np.full((36, 64, 3), 9, dtype=np.uint8))
    feed(world, "/rgb_raw", RGB_OUT, *(rgb(1 + t / 10) for t in range(5)), flat, *(flat for _ in range(4)))
    world.run(0.1)
    answers = reported(world, "autofocus_needed")
    assert len(answers) == 6
    assert answers[:2] == ["false", "false"]
    assert answers[-1] == "true"


@pytest.mark.usefixtures("camera")
def test_sharpness_from_before_a_restart_does_not_count(world: "World", rgb: Make) -> None:
    feed(world, "/rgb_raw", RGB_OUT, *(rgb(1 + t / 10) for t in range(5)))
    assert world.transition("camera", "deactivate")
    assert world.transition("camera", "activate")
    feed(world, "/rgb_raw", RGB_OUT, *(rgb(2 + t / 10) for t in range(5)))
    world.run(0.1)
    assert len(reported(world, "autofocus_needed")) == 2


@pytest.mark.usefixtures("depth_camera")
def test_healthy_depth_is_passed_on(world: "World", depth: Make) -> None:
    assert feed(world, "/depth_raw", DEPTH_OUT, depth(1.0)) == [depth(1.0)]


@pytest.mark.usefixtures("depth_camera")
def test_depth_noise_saturates_and_never_wraps(world: "World", depth: Make) -> None:
    world.set("depth", "depth_degradation", 10.0)
    (out,) = feed(world, "/depth_raw", DEPTH_OUT, depth(1.0))
    clean, noisy = array_of_depth(depth(1.0)).astype(float), array_of_depth(out).astype(float)
    assert np.abs(noisy - clean).max() < 6 * 655.35
    assert (noisy[:, :8] == 0).mean() > 0.4
    assert (noisy[:, -8:] == 65535).mean() > 0.4
    inner = (noisy - clean)[:, 8:-8]
    assert abs(inner.mean()) < 60
    assert 600 < inner.std() < 710


@pytest.mark.parametrize("earlier", [[], [1.0, 1.1]])
@pytest.mark.usefixtures("depth_camera")
def test_the_noise_depends_on_seed_and_frame_only(world: "World", depth: Make, earlier: list[float]) -> None:
    world.set("depth", "depth_degradation", 10.0)
    feed(world, "/depth_raw", DEPTH_OUT, *(depth(stamp) for stamp in earlier))
    (out,) = feed(world, "/depth_raw", DEPTH_OUT, depth(3.0))
    expected = degrade_depth(array_of_depth(depth(3.0)), 10.0, generator(7, "depth", 3_000_000_000))
    np.testing.assert_array_equal(array_of_depth(out), expected)


def test_the_enhancement_is_inactive_until_activated_and_undoes_the_degradation(
    world: "World", rgb: Make
) -> None:
    world.start(ImageEnhancement)
    world.run(1.0)
    degraded = image_of_bgr(rgb(1.0).header, degrade_image(array_of_bgr(rgb(1.0)), SUITE_STRENGTH))
    assert feed(world, RGB_OUT, ENHANCED_OUT, degraded) == []
    assert world.transition("image_enhancement", "activate")
    (out,) = feed(world, RGB_OUT, ENHANCED_OUT, degraded)
    assert np.abs(pixels(out) - pixels(rgb(1.0))).max() <= 8


@pytest.mark.parametrize("strength", [0.5, 1.5])
def test_the_enhancement_undoes_the_strength_that_its_parameter_says(
    world: "World", rgb: Make, strength: float
) -> None:
    world.start(ImageEnhancement, parameters={"image_degradation": strength})
    world.run(0.1)
    assert world.transition("image_enhancement", "activate")
    (out,) = feed(world, RGB_OUT, ENHANCED_OUT, rgb(1.0))
    np.testing.assert_array_equal(array_of_bgr(out), enhance_image(array_of_bgr(rgb(1.0)), strength))


def test_the_enhancement_of_a_good_image_saturates_and_never_wraps(world: "World", rgb: Make) -> None:
    world.start(ImageEnhancement)
    world.run(0.1)
    assert world.transition("image_enhancement", "activate")
    (out,) = feed(world, RGB_OUT, ENHANCED_OUT, rgb(1.0))
    np.testing.assert_array_equal(array_of_bgr(out), enhance_image(array_of_bgr(rgb(1.0)), SUITE_STRENGTH))
    bright = array_of_bgr(rgb(1.0)).min(axis=2) > 128
    assert (array_of_bgr(out)[bright].max(axis=1) == 255).all()
