"""The managed system: lifecycle nodes on one adaptive base class."""

from sunset.nodes.base import AdaptiveNode as AdaptiveNode
from sunset.nodes.camera import Camera as Camera
from sunset.nodes.depth import Depth as Depth
from sunset.nodes.image_enhancement import ImageEnhancement as ImageEnhancement
from sunset.nodes.parameters import FaultParameter as FaultParameter
from sunset.nodes.parameters import NodeParameter as NodeParameter
from sunset.nodes.parameters import TopicParameter as TopicParameter
from sunset.nodes.parameters import action as action
from sunset.nodes.segmentation import SegmentationNode as SegmentationNode
from sunset.nodes.sensor_fusion import Fusion as Fusion
