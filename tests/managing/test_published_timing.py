"""The baselines with the published code's timing, and the nodes that boot fast."""

from typing import TYPE_CHECKING

import pytest
from scripts.published_timing import EXTENSION, Patient

from sunset.managing import Symptoms
from sunset.nodes import AdaptiveNode, Camera, Fusion, SegmentationNode

if TYPE_CHECKING:
    from tests.conftest import World

CAMERA_HZ = "managed_subsystem_rgb_camera_freq"


class Recorded(Patient):
    """Writes down what it would redeploy."""

    def on_start(self) -> None:
        super().on_start()
        self.redeployed: list[str] = []

    def redeploy(self, node: str) -> None:  # type: ignore[override]
        self.redeployed.append(node)


def test_a_node_is_redeployed_when_its_topic_was_silent_for_3_7_s_at_a_stretch(world: "World") -> None:
    manager = world.start(Recorded)
    redeployed = []
    for frequency, seconds in ((0.0, 2.6), (0.0, 0.05), (10.0, 0.05), (0.0, 2.6), (0.0, 0.2), (0.0, 1.0)):
        manager.adapt(Symptoms({CAMERA_HZ: frequency}))
        redeployed.append(len(manager.redeployed))
        world.run(seconds)
    manager.adapt(Symptoms({CAMERA_HZ: 0.0}))

    assert redeployed == [0, 0, 0, 0, 0, 1]
    assert manager.redeployed == ["camera"]


@pytest.mark.parametrize(
    ("name", "node_class"),
    [("camera", Camera), ("sensor_fusion", Fusion), ("segmentation", SegmentationNode)],
)
def test_a_node_that_boots_fast_does_so_in_a_second(
    world: "World", name: str, node_class: type[AdaptiveNode]
) -> None:
    node = world.start(EXTENSION.node_classes[name])

    assert isinstance(node, node_class)
    assert node.lifecycle_activation_delay == 1.0
