"""Which node has stopped first, and how long one waits for it."""

from typing import TYPE_CHECKING

import pytest

from sunset.managing import NoAdaptation, Symptoms, Waits, Wiring
from sunset.system.vocabulary import frequency_entry

if TYPE_CHECKING:
    from tests.conftest import World


@pytest.mark.parametrize(
    ("silent", "node"),
    [
        ((), ""),
        (("segmentation",), "segmentation"),
        (("segmentation", "sensors_fused", "rgb_camera"), "camera"),
        (("segmentation", "sensors_fused", "depth_camera"), "depth"),
        (("rgb_enhanced",), ""),  # nothing comes of it when all is well
    ],
)
def test_the_node_furthest_upstream_is_named(silent: tuple[str, ...], node: str) -> None:
    frequencies = {frequency_entry(topic): 10.0 for topic in Wiring().topics}
    symptoms = Symptoms({**frequencies, **{frequency_entry(topic): 0.0 for topic in silent}})

    assert Wiring().first_silent(symptoms) == node


def test_what_was_never_heard_is_not_silent() -> None:
    assert Wiring().first_silent(Symptoms({})) == ""


def test_boot_times_are_those_of_the_description() -> None:
    assert Wiring().boot_s == {
        "camera": 4.0,
        "depth": 4.0,
        "image_enhancement": 0.0,
        "sensor_fusion": 2.0,
        "segmentation": 2.0,
    }


def test_a_wait_is_over_after_its_time_and_begins_again(world: "World") -> None:
    waits = Waits(world.start(NoAdaptation))

    assert waits.over("camera")
    waits.start("camera", 1.0)
    world.run(0.9)
    assert not waits.over("camera")
    assert waits.over("depth")
    world.run(0.2)
    assert waits.over("camera")
    waits.start("camera", 1.0)
    assert not waits.over("camera")
