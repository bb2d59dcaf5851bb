"""The managed system: lifecycle nodes on one adaptive base class."""

from sunset.nodes.base import AdaptiveNode
from sunset.nodes.camera import Camera
from sunset.nodes.depth import Depth
from sunset.nodes.image_enhancement import ImageEnhancement
from sunset.nodes.parameters import FaultParameter, NodeParameter, TopicParameter, action
from sunset.nodes.segmentation import SegmentationNode
from sunset.nodes.sensor_fusion import Fusion

__all__ = [
    "AdaptiveNode",
    "Camera",
    "Depth",
    "FaultParameter",
    "Fusion",
    "ImageEnhancement",
    "NodeParameter",
    "SegmentationNode",
    "TopicParameter",
    "action",
]
