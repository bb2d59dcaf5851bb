"""Segmentation networks and their inference, without ROS.

A model is a folder with up to three networks (RGB, depth, and both fused) and a card. `load_model` checks
it, a `Segmenter` runs it, and an `InferenceCache` stores the results.
"""

from sunset.perception.cache import InferenceCache
from sunset.perception.card import Modality, ModelCard, NetworkCard
from sunset.perception.model import (
    DEVICES,
    OFFERED,
    Model,
    find_device,
    is_installed,
    list_models,
    load_model,
)
from sunset.perception.segmenter import Segmentation, Segmenter

__all__ = [
    "DEVICES",
    "OFFERED",
    "InferenceCache",
    "Modality",
    "Model",
    "ModelCard",
    "NetworkCard",
    "Segmentation",
    "Segmenter",
    "find_device",
    "is_installed",
    "list_models",
    "load_model",
]
