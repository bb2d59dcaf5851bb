"""Images as tools for robots expect them."""

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from sunset.classes import CLASSES, COLOURS
from sunset.harness.image_views import ImageViews
from sunset.image_messages import image_of_depth, image_of_labels
from sunset_ros import Node
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header

if TYPE_CHECKING:
    from tests.conftest import World

HEADER = Header(frame_id="camera_optical_frame")


def see(world: "World") -> None:
    depth = np.array([[0, 65535], [6554, 1]], dtype=np.uint16)
    labels = np.array([[CLASSES.index("car"), 255]], dtype=np.uint8)
    world.publish("/managed_subsystem/depth_camera", image_of_depth(HEADER, depth))
    world.publish("/managed_subsystem/segmentation", image_of_labels(HEADER, labels))
    world.run(0.05)


def test_nothing_is_converted_until_a_node_subscribes(world: "World") -> None:
    world.start(ImageViews)
    see(world)
    assert not {"/views/depth", "/views/labels"} & world.messages.keys()


def test_depth_is_in_metres_and_labels_are_in_colours(world: "World") -> None:
    world.start(ImageViews)
    seen: dict[str, Image] = {}
    viewer = world.start(Node, "viewer")
    for name in ("depth", "labels"):
        viewer.create_subscription(Image, f"/views/{name}", partial(seen.setdefault, name), 1)
    see(world)
    depth, labels = seen["depth"], seen["labels"]
    assert (depth.header, depth.encoding, depth.step) == (HEADER, "32FC1", 8)
    np.testing.assert_allclose(depth.data.view("<f4"), [0, 1000, 100.0076, 0.015259], rtol=1e-5)
    assert labels.encoding == "bgr8"
    assert labels.data.tolist() == [*reversed(COLOURS[CLASSES.index("car")]), 0, 0, 0]
