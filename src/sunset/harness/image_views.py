"""A node for viewers, which converts depth images and labels to the encodings of ROS's tools."""

from typing import Unpack

import numpy as np

from sunset.classes import PALETTE
from sunset.faults import DEPTH_COUNTS_PER_METRE
from sunset.image_messages import array_of_depth, array_of_labels, image_of_bgr, image_of_metres
from sunset.system import HARNESS, RESULT_TOPIC, full_name
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.node import Node, NodeOptions


class ImageViews(Node):
    """Publishes the managed system's depth images in metres (`32FC1`, REP 118), and its labels in colours (`bgr8`).

    It converts images only while a node subscribes to them.
    """

    def __init__(self, **options: Unpack[NodeOptions]) -> None:
        super().__init__("image_views", **options)
        topics = HARNESS["image_views"].outputs
        self._depth, self._labels = (self.create_publisher(Image, topic, 1) for topic in topics)
        self.create_subscription(Image, full_name("depth_camera"), self._on_depth, 1)
        self.create_subscription(Image, RESULT_TOPIC, self._on_labels, 1)

    def _on_depth(self, message: Image) -> None:
        if self._depth.get_subscription_count():
            metres = array_of_depth(message).astype(np.float32) / np.float32(DEPTH_COUNTS_PER_METRE)
            self._depth.publish(image_of_metres(message.header, metres))

    def _on_labels(self, message: Image) -> None:
        if self._labels.get_subscription_count():
            bgr = PALETTE[array_of_labels(message)][..., ::-1]
            self._labels.publish(image_of_bgr(message.header, bgr))
