"""The segmentation node, with the model that is shipped."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from sunset.image_messages import array_of_labels, image_of_bgr, image_of_depth
from sunset.nodes import SegmentationNode
from sunset.perception import Modality, Segmenter, load_model
from sunset.system_interfaces.msg import FusionType, SensorFusion
from sunset_ros import CallbackError
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header

if TYPE_CHECKING:
    from tests.conftest import World

IN = "/managed_subsystem/sensors_fused"
OUT = "/managed_subsystem/segmentation"

ROWS, COLUMNS = np.mgrid[0:144, 0:256]
BGR = np.stack([COLUMNS, ROWS, (COLUMNS + ROWS) % 200], axis=-1).astype(np.uint8)
DEPTH = (3000 + 8 * ROWS).astype(np.uint16)


@pytest.fixture
def segmentation(world: "World") -> SegmentationNode:
    node = world.start(SegmentationNode, parameters={"lifecycle_activation_delay": 0.0})
    world.run(0.1)
    return node


def fused(modality: Modality, second: int = 1) -> SensorFusion:
    header = Header(stamp=Time(sec=second))
    return SensorFusion(
        header=header,
        rgb=image_of_bgr(header, BGR) if modality.needs_rgb else Image(),
        depth=image_of_depth(header, DEPTH) if modality.needs_depth else Image(),
        modality=FusionType(fusion_type=modality.value),
    )


def feed(world: "World", message: SensorFusion) -> list[Image]:
    before = len(world.messages[OUT])
    world.publish(IN, message)
    world.run(0.2)
    made: list[Image] = world.messages[OUT][before:]
    return made


def entropies(world: "World") -> list[float]:
    return [
        float(item.value)
        for message in world.messages["/diagnostics"]
        for item in message.status[0].values
        if item.key == "entropy"
    ]


def test_its_boot_time_is_the_papers(world: "World") -> None:
    assert world.start(SegmentationNode).lifecycle_activation_delay == 2.0


@pytest.mark.parametrize("modality", list(Modality))
@pytest.mark.usefixtures("segmentation")
def test_the_network_of_the_modality_is_used(world: "World", modality: Modality) -> None:
    expected = Segmenter(load_model("lite")).segment(modality, BGR, DEPTH)
    (out,) = feed(world, fused(modality))
    np.testing.assert_array_equal(array_of_labels(out), expected.labels)
    assert (out.header.stamp.sec, out.encoding) == (1, "8UC1")
    assert entropies(world) == [expected.entropy]


HEADER = Header(stamp=Time(sec=1))


@pytest.mark.parametrize(
    ("message", "why"),
    [
        (
            SensorFusion(rgb=image_of_bgr(HEADER, BGR[::2]), modality=FusionType(fusion_type=1)),
            "The model lite takes images of 256x144 pixels, got 256x72.",
        ),
        (
            SensorFusion(rgb=image_of_depth(HEADER, DEPTH), modality=FusionType(fusion_type=1)),
            "An image must have the encoding bgr8 here, got '16UC1'.",
        ),
        (SensorFusion(modality=FusionType(fusion_type=3)), "There is no modality 3."),
    ],
)
@pytest.mark.usefixtures("segmentation")
def test_what_the_model_cannot_take_is_dropped(world: "World", message: SensorFusion, why: str) -> None:
    assert feed(world, message) == []
    (line,) = [log.msg for log in world.messages["/rosout"] if log.name.endswith("segmentation")]
    assert line == f"Dropped images: {why}"
    assert len(feed(world, fused(Modality.RGB, 2))) == 1


@pytest.mark.usefixtures("segmentation")
def test_entropy_is_reported_for_new_frames_only(world: "World") -> None:
    feed(world, fused(Modality.RGB))
    world.run(1.0)
    assert len(entropies(world)) == 1


@pytest.mark.parametrize("fault", ["cuda_out_of_memory", "gpu_failure"])
@pytest.mark.usefixtures("segmentation")
def test_an_outage_is_silence_and_only_its_cures_end_it(world: "World", fault: str) -> None:
    assert world.set("segmentation", fault, value=True).successful
    assert feed(world, fused(Modality.RGB)) == []
    assert entropies(world) == []
    assert world.transition("segmentation", "deactivate")
    assert world.transition("segmentation", "activate")
    assert len(feed(world, fused(Modality.RGB))) == (fault == "cuda_out_of_memory")


@pytest.mark.usefixtures("segmentation")
def test_only_the_newest_frame_waits_while_it_works(world: "World") -> None:
    for second in range(5):
        world.publish(IN, fused(Modality.RGB, second))
    world.run(0.2)
    stamps = [image.header.stamp.sec for image in world.messages[OUT]]
    assert stamps[-1] == 4
    assert len(stamps) < 5


def test_answers_may_come_from_a_cache(world: "World", tmp_path: Path) -> None:
    cache = tmp_path / "answers.sqlite"
    world.start(
        SegmentationNode, parameters={"lifecycle_activation_delay": 0.0, "inference_cache": str(cache)}
    )
    world.run(0.1)
    first, second = feed(world, fused(Modality.RGB)) + feed(world, fused(Modality.RGB))
    assert first == second
    assert cache.is_file()


def test_a_model_that_is_not_there_is_named(world: "World") -> None:
    world.start(SegmentationNode, parameters={"model": "no/such/model"})
    with pytest.raises(CallbackError, match="no/such/model"):
        world.run(0.1)


def test_a_device_that_there_is_not_is_named(world: "World") -> None:
    world.start(SegmentationNode, parameters={"device": "abacus"})
    with pytest.raises(CallbackError, match="'abacus'"):
        world.run(0.1)


def test_all_networks_are_warmed_up_while_it_boots(world: "World", monkeypatch: pytest.MonkeyPatch) -> None:
    opened: dict[object, object] = {}
    monkeypatch.setattr("sunset.perception.model._sessions", opened)
    node = world.start(SegmentationNode)
    world.run(0.12)
    assert (len(world.messages["/diagnostics"]), len(opened)) == (1, 0)  # no heartbeat waits for that
    world.run(0.4)
    assert len(opened) == len(Modality)
    assert entropies(world) == []
    world.run(node.lifecycle_activation_delay)
    assert len(feed(world, fused(Modality.RGB))) == 1


def test_what_it_is_given_is_not_warmed_up(world: "World", monkeypatch: pytest.MonkeyPatch) -> None:
    opened: dict[object, object] = {}
    monkeypatch.setattr("sunset.perception.model._sessions", opened)
    world.start(SegmentationNode, segmenter=Segmenter(load_model("lite")))
    world.run(3.0)
    assert opened == {}
