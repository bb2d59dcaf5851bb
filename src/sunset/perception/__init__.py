"""Segmentation networks and their inference, without ROS.

A model is a folder with up to three networks (RGB, depth, and both fused) and a card. `load_model` checks
it, and a `Segmenter` runs it.
"""

from sunset.perception.card import Modality as Modality
from sunset.perception.card import ModelCard as ModelCard
from sunset.perception.card import NetworkCard as NetworkCard
from sunset.perception.model import DEVICES as DEVICES
from sunset.perception.model import OFFERED as OFFERED
from sunset.perception.model import Model as Model
from sunset.perception.model import find_device as find_device
from sunset.perception.model import is_installed as is_installed
from sunset.perception.model import list_models as list_models
from sunset.perception.model import load_model as load_model
from sunset.perception.segmenter import Segmentation as Segmentation
from sunset.perception.segmenter import Segmenter as Segmenter
