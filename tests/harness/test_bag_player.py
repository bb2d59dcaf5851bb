"""The bag player: the bag's frames, with the bag's stamps, at the rate asked for."""

import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from sunset.data import Frame, write_bag
from sunset.errors import DataError, ParameterError
from sunset.harness.bag_player import BagPlayer
from sunset.image_messages import array_of_bgr, array_of_depth, array_of_labels, stamp_ns
from sunset_ros.interfaces.std_srvs.srv import Trigger
from sunset_ros.seeding import generator

if TYPE_CHECKING:
    from tests.conftest import World

STAMPS = [10**11 + 10**8 * number for number in range(12)]


@pytest.fixture(scope="module")
def frames() -> list[Frame]:
    rng = generator(1, "frames")
    return [
        Frame(
            rgb=rng.integers(0, 256, (6, 8, 3), dtype=np.uint8),
            depth=rng.integers(0, 65536, (6, 8), dtype=np.uint16),
            labels=rng.integers(0, 23, (6, 8), dtype=np.uint8),
        )
        for _ in STAMPS
    ]


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory, frames: list[Frame]) -> str:
    folder = tmp_path_factory.mktemp("player") / "bag"
    write_bag(folder, frames, STAMPS)
    return str(folder)


def play(world: "World", **parameters: object) -> float:
    """Start a player; return when it was told to play."""
    world.start(BagPlayer, parameters=parameters)
    world.run(0.5)
    began = world.now
    response = world.call(Trigger, "/bag_player/start", Trigger.Request(), within=0.01)
    assert response.success
    return began


def test_nothing_is_played_before_the_start(world: "World", bag: str) -> None:
    world.start(BagPlayer, parameters={"bag": bag})
    world.run(5.0)
    assert world.messages["/rgb_raw"] == []


def test_all_frames_are_played_unchanged_with_the_bags_stamps(
    world: "World", bag: str, frames: list[Frame]
) -> None:
    play(world, bag=bag)
    world.run(3.0)
    assert len(world.messages["/rgb_raw"]) == len(frames)
    for number, frame in enumerate(frames):
        rgb, depth, truth, clock = (
            world.messages[topic][number]
            for topic in ("/rgb_raw", "/depth_raw", "/gt_segmentation", "/clock")
        )
        np.testing.assert_array_equal(array_of_bgr(rgb), frame.rgb)
        np.testing.assert_array_equal(array_of_depth(depth), frame.depth)
        np.testing.assert_array_equal(array_of_labels(truth), frame.labels)
        stamps = {stamp_ns(image.header) for image in (rgb, depth, truth)}
        assert stamps == {clock.clock.sec * 10**9 + clock.clock.nanosec} == {STAMPS[number]}


def test_frames_come_at_the_rate_after_the_phase(world: "World", bag: str) -> None:
    began = play(world, bag=bag, rate=20.0, phase=0.03)
    world.run(3.0)
    times = np.array(world.times["/rgb_raw"]) - began
    np.testing.assert_allclose(times, 0.03 + 0.05 * np.arange(12), atol=0.002)


def test_a_part_is_played(world: "World", bag: str) -> None:
    play(world, bag=bag, start_frame=3, frames=4)
    world.run(3.0)
    assert [stamp_ns(image.header) for image in world.messages["/rgb_raw"]] == STAMPS[3:7]


@pytest.mark.parametrize("count", [0, 25])
def test_a_bag_that_loops_goes_on_with_its_first_frame_and_later_stamps(
    world: "World", bag: str, count: int
) -> None:
    play(world, bag=bag, start_frame=9, frames=count, loop=True)
    world.run(2.95)
    stamps = [stamp_ns(image.header) for image in world.messages["/rgb_raw"]]
    assert stamps == [STAMPS[0] + 10**8 * number for number in range(9, 9 + (count or 30))]
    assert [
        image.clock.sec + image.clock.nanosec / 1e9 for image in world.messages["/clock"]
    ] == pytest.approx([stamp / 1e9 for stamp in stamps])
    images = world.messages["/rgb_raw"]
    for number in range(12):
        np.testing.assert_array_equal(images[number].data, images[number + 12].data)


def test_a_bag_of_one_frame_loops_at_the_rate(world: "World", tmp_path: Path, frames: list[Frame]) -> None:
    write_bag(tmp_path / "bag", frames[:1], [5])
    play(world, bag=str(tmp_path / "bag"), frames=3, loop=True, rate=20.0)
    world.run(1.0)
    stamps = [stamp_ns(image.header) for image in world.messages["/rgb_raw"]]
    assert stamps == [5, 50_000_005, 100_000_005]


@pytest.mark.parametrize(
    ("options", "said"),
    [({"loop": True}, "Playing the bag in a loop."), ({"loop": True, "frames": 25}, "Playing 25 frames.")],
)
def test_the_player_says_what_it_plays(
    world: "World", bag: str, options: dict[str, object], said: str
) -> None:
    world.start(BagPlayer, parameters={"bag": bag, **options})
    world.run(0.5)
    assert world.call(Trigger, "/bag_player/start", Trigger.Request()).message == said


def test_a_second_start_begins_anew(world: "World", bag: str) -> None:
    play(world, bag=bag, frames=5)
    world.run(0.25)
    world.call(Trigger, "/bag_player/start", Trigger.Request())
    world.run(3.0)
    stamps = [stamp_ns(image.header) for image in world.messages["/rgb_raw"]]
    assert stamps == STAMPS[:3] + STAMPS[:5]


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"start_frame": 12}, "12 frames, which is too few for any from frame 12 on"),
        ({"start_frame": 5, "frames": 8}, "too few for 8 from frame 5 on"),
        ({"frames": 13}, "too few for 13 from frame 0 on"),
        ({"start_frame": 12, "loop": True}, "too few for any from frame 12 on"),
    ],
)
def test_a_bag_that_is_too_short_is_refused(
    world: "World", bag: str, parameters: dict[str, object], said: str
) -> None:
    with pytest.raises(ParameterError, match=said):
        world.start(BagPlayer, parameters={"bag": bag, **parameters})


def test_a_bag_that_was_replaced_is_read_anew(world: "World", tmp_path: Path, frames: list[Frame]) -> None:
    for part in (frames[:2], frames[2:5]):
        shutil.rmtree(tmp_path / "bag", ignore_errors=True)
        write_bag(tmp_path / "bag", part, STAMPS[: len(part)])
        world.messages["/rgb_raw"].clear()
        play(world, bag=str(tmp_path / "bag"))
        world.run(2.0)
        world.kill("bag_player")
        made = [array_of_bgr(image) for image in world.messages["/rgb_raw"]]
        np.testing.assert_array_equal(made, [frame.rgb for frame in part])


def test_a_bag_must_be_named_and_be_there(world: "World", tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="needs the parameter bag"):
        world.start(BagPlayer)
    with pytest.raises(DataError, match="nowhere"):
        world.start(BagPlayer, parameters={"bag": str(tmp_path / "nowhere")})
