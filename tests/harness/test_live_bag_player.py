"""The bag player of a live system: it gives the time, and stamps what it plays with it."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pytest

from sunset.data import Frame, write_bag
from sunset.harness.bag_player import LiveBagPlayer
from sunset.image_messages import stamp_ns
from sunset_ros.interfaces.std_srvs.srv import Trigger
from sunset_ros.seeding import generator

if TYPE_CHECKING:
    from tests.conftest import World

FRAMES = 6


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> str:
    rng = generator(1, "frames")
    frames = [
        Frame(
            rgb=rng.integers(0, 256, (6, 8, 3), dtype=np.uint8),
            depth=rng.integers(0, 65536, (6, 8), dtype=np.uint16),
            labels=rng.integers(0, 23, (6, 8), dtype=np.uint8),
        )
        for _ in range(FRAMES)
    ]
    folder = tmp_path_factory.mktemp("live player") / "bag"
    write_bag(folder, frames, [10**11 + 10**8 * number for number in range(FRAMES)])
    return str(folder)


def clock_ns(world: "World") -> list[int]:
    return [one.clock.sec * 10**9 + one.clock.nanosec for one in world.messages["/clock"]]


def played(world: "World", topic: str = "/rgb_raw") -> Iterator[tuple[float, float]]:
    """Give (time, stamp) of every image, in seconds."""
    for time, image in zip(world.times[topic], world.messages[topic], strict=True):
        yield time, stamp_ns(image.header) / 1e9


def start(world: "World") -> None:
    assert world.call(Trigger, "/bag_player/start", Trigger.Request()).success


@pytest.mark.parametrize("speed", [0.5, 1.0, 4.0])
def test_the_clock_runs_from_the_start_on_in_steps_of_a_hundredth(
    world: "World", bag: str, speed: float
) -> None:
    world.start(LiveBagPlayer, parameters={"bag": bag, "speed": speed})
    world.run(2.0)
    times = np.array(clock_ns(world)) / 1e9
    assert times[0] > 0
    np.testing.assert_allclose(np.diff(times), 0.01, atol=0.003)
    np.testing.assert_allclose(times[-1], 2.0 * speed, atol=0.1)


def test_the_clock_may_have_begun_before(world: "World", bag: str) -> None:
    world.run(3.0)
    world.start(LiveBagPlayer, parameters={"bag": bag, "origin_ns": 10**9})
    world.run(1.0)
    np.testing.assert_allclose(np.array(clock_ns(world)) / 1e9 + 1.0, world.times["/clock"], atol=0.002)


def test_the_camera_is_described_beside_its_images(world: "World", bag: str) -> None:
    world.start(LiveBagPlayer, parameters={"bag": bag, "field_of_view": 90.0})
    world.run(0.1)
    start(world)
    world.run(0.3)
    images, infos = world.messages["/rgb_raw"], world.messages["/camera_info"]
    assert [info.header for info in infos] == [image.header for image in images]
    assert infos == world.messages["/managed_subsystem/camera_info"]
    info = infos[0]
    assert (info.height, info.width, info.header.frame_id) == (6, 8, "camera_optical_frame")
    corner = np.array([-0.5, -0.5, 1.0])  # of the first pixel, whose ray goes 45 degrees to the left
    np.testing.assert_allclose(np.linalg.solve(info.k.reshape(3, 3), corner), [-1.0, -0.75, 1.0])
    np.testing.assert_allclose(info.p.reshape(3, 4)[:, :3], info.k.reshape(3, 3))


def test_the_images_frame_is_in_the_tree_of_transforms(world: "World", bag: str) -> None:
    world.start(LiveBagPlayer, parameters={"bag": bag})
    world.run(0.1)
    ((transform,),) = (message.transforms for message in world.messages["/tf_static"])
    assert (transform.header.frame_id, transform.child_frame_id) == ("camera_link", "camera_optical_frame")
    rotation = transform.transform.rotation
    x, y, z, w = rotation.x, rotation.y, rotation.z, rotation.w
    forward = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]  # of the image's z axis
    right = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]
    np.testing.assert_allclose([forward, right], [[1, 0, 0], [0, -1, 0]])


def test_frames_are_stamped_with_the_time_at_which_they_are_played(world: "World", bag: str) -> None:
    world.start(LiveBagPlayer, parameters={"bag": bag, "origin_ns": 1, "speed": 2.0})
    start(world)
    world.run(2.0)
    frames = list(played(world))
    assert len(frames) == FRAMES
    assert next(played(world, "/gt_segmentation"))[1] == frames[0][1]
    for time, stamp in frames:
        assert stamp == pytest.approx(2.0 * time, abs=0.002)
    np.testing.assert_allclose(np.diff([stamp for _, stamp in frames]), 0.1, atol=0.002)


def test_a_flight_that_loops_goes_on_with_later_stamps(world: "World", bag: str) -> None:
    world.start(LiveBagPlayer, parameters={"bag": bag, "loop": True, "rate": 20.0})
    start(world)
    world.run(1.0)
    stamps = [stamp for _, stamp in played(world)]
    assert len(stamps) > 2 * FRAMES
    np.testing.assert_allclose(np.diff(stamps), 0.05, atol=0.002)
    images = world.messages["/rgb_raw"]
    np.testing.assert_array_equal(images[0].data, images[FRAMES].data)


def test_frames_have_the_size_that_is_asked_for(world: "World", bag: str) -> None:
    world.start(LiveBagPlayer, parameters={"bag": bag, "width": 4, "height": 3})
    start(world)
    world.run(0.5)
    assert (world.messages["/rgb_raw"][0].width, world.messages["/rgb_raw"][0].height) == (4, 3)


def test_the_clock_goes_on_when_somebody_lets_the_player_follow_it(world: "World", bag: str) -> None:
    world.start(LiveBagPlayer, parameters={"bag": bag, "use_sim_time": True})
    world.run(1.0)
    assert len(clock_ns(world)) > 90
