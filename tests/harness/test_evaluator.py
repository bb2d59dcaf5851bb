"""The evaluator node: results against the truth of the same stamp."""

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from sunset.harness.evaluator import Evaluator
from sunset.image_messages import image_of_bgr, image_of_labels
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header

if TYPE_CHECKING:
    from tests.conftest import World

RESULT = "/managed_subsystem/segmentation"
TRUTH = "/gt_segmentation"


@pytest.fixture
def evaluator(world: "World") -> Evaluator:
    return world.start(Evaluator)


def labels(second: int, *values: int) -> Image:
    return image_of_labels(Header(stamp=Time(sec=second)), np.array([values], dtype=np.uint8))


def feed(world: "World", *arrivals: tuple[str, Image]) -> list[tuple[int, float]]:
    for topic, image in arrivals:
        world.publish(topic, image)
        world.run(0.01)
    return [(message.header.stamp.sec, message.iou) for message in world.messages["/seg_metrics"]]


@pytest.mark.usefixtures("evaluator")
def test_classes_are_compared_not_recorded_ids(world: "World") -> None:
    road, car = 7, 100
    assert feed(world, (TRUTH, labels(1, road, car)), (RESULT, labels(1, 5, 22))) == [(1, 1.0)]
    message = world.messages["/seg_metrics"][0]
    assert (message.truth[5], message.predicted[22], message.intersection.sum()) == (1, 1, 2)


@pytest.mark.usefixtures("evaluator")
def test_results_are_matched_by_stamp_in_either_order(world: "World") -> None:
    arrivals = [(TRUTH, labels(1, 7)), (TRUTH, labels(2, 1)), (RESULT, labels(2, 0)), (RESULT, labels(1, 0))]
    assert feed(world, *arrivals) == [(2, 1.0), (1, 0.0)]
    assert feed(world, (RESULT, labels(3, 5)), (TRUTH, labels(3, 7)))[-1] == (3, 1.0)


@pytest.mark.usefixtures("evaluator")
def test_a_truth_without_any_class_is_said_at_once_and_compared_with_nothing(world: "World") -> None:
    ((second, iou),) = feed(world, (TRUTH, labels(1, 0, 4)))
    assert second == 1
    assert math.isnan(iou)
    assert not world.messages["/seg_metrics"][0].truth.any()
    assert (
        len(feed(world, (RESULT, labels(1, 5, 5)), (RESULT, labels(2, 5, 5)), (TRUTH, labels(2, 0, 10)))) == 2
    )


@pytest.mark.usefixtures("evaluator")
def test_what_cannot_be_compared_is_dropped(world: "World") -> None:
    colour = image_of_bgr(Header(stamp=Time(sec=1)), np.zeros((1, 1, 3), dtype=np.uint8))
    assert feed(world, (TRUTH, labels(1, 7)), (RESULT, colour)) == []
    assert feed(world, (TRUTH, labels(2, 7)), (RESULT, labels(2, 5, 5))) == []
    logs = [log.msg for log in world.messages["/rosout"] if log.name == "evaluator"]
    assert [log.split(":")[0] for log in logs] == [
        "Dropped a segmentation",
        "Dropped a segmentation of 2x1 pixels, where the truth has 1x1.",
    ]


@pytest.mark.usefixtures("evaluator")
def test_a_frame_is_evaluated_once_and_none_without_its_truth(world: "World") -> None:
    assert len(feed(world, (TRUTH, labels(1, 7)), (RESULT, labels(1, 5)), (RESULT, labels(1, 5)))) == 1
    assert len(feed(world, (RESULT, labels(2, 5)), (TRUTH, labels(3, 7)))) == 1


def test_frames_without_a_partner_do_not_pile_up(world: "World", evaluator: Evaluator) -> None:
    feed(world, *((TRUTH, labels(second, 7)) for second in range(150)))
    assert len(evaluator._truths) == 100
    assert feed(world, (RESULT, labels(0, 5))) == []
    assert feed(world, (RESULT, labels(149, 5))) == [(149, 1.0)]


def test_it_is_no_part_of_the_managed_system(world: "World", evaluator: Evaluator) -> None:
    assert evaluator.get_fully_qualified_name() == "/evaluator"
    assert dict(world.subscriptions_of("/evaluator")).keys() >= {RESULT, TRUTH}


@pytest.mark.usefixtures("evaluator")
def test_frames_of_a_far_future_do_not_crowd_out_the_present(world: "World") -> None:
    feed(world, *((TRUTH, labels(2**31 - second, 7)) for second in range(1, 150)))
    feed(world, *((RESULT, labels(2**31 - second, 7)) for second in range(200, 350)))
    assert feed(world, (TRUTH, labels(1, 7)), (RESULT, labels(1, 5))) == [(1, 1.0)]
