"""The managed system: lifecycle nodes on one adaptive base class, and the nodes around them."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from sunset.nodes.bag_player import BagPlayer
from sunset.nodes.base import AdaptiveNode
from sunset.nodes.camera import Camera
from sunset.nodes.depth import Depth
from sunset.nodes.evaluator import Evaluator
from sunset.nodes.image_enhancement import ImageEnhancement
from sunset.nodes.monitor import Monitor
from sunset.nodes.parameters import FaultParameter, NodeParameter, TopicParameter, action
from sunset.nodes.segmentation import SegmentationNode
from sunset.nodes.sensor_fusion import Fusion
from sunset.ros.node import Node

__all__ = [
    "NODES",
    "AdaptiveNode",
    "BagPlayer",
    "Camera",
    "Depth",
    "Evaluator",
    "FaultParameter",
    "Fusion",
    "ImageEnhancement",
    "Monitor",
    "NodeParameter",
    "SegmentationNode",
    "TopicParameter",
    "action",
]

NODES: Final[Mapping[str, type[Node]]] = MappingProxyType(
    {
        "camera": Camera,
        "depth": Depth,
        "image_enhancement": ImageEnhancement,
        "sensor_fusion": Fusion,
        "segmentation": SegmentationNode,
        "bag_player": BagPlayer,
        "monitor": Monitor,
        "evaluator": Evaluator,
    }
)
"""Name → class of every node that a process can be made of."""
