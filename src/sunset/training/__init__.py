"""Training: rendered frames become a model's weights, thresholds and card; never imported when flying.

It needs the `train` extra (torch and onnx), but can be imported without.
"""

from sunset.training.batches import FrameSet
from sunset.training.config import CONFIGS, MODALITIES, Phase, Schedule, TrainingConfig
from sunset.training.frames import FrameCounts, FrameSets, render_sets
from sunset.training.lite import LiteShape
from sunset.training.reference import ReferenceShape
from sunset.training.run import train, train_on

__all__ = [
    "CONFIGS",
    "MODALITIES",
    "FrameCounts",
    "FrameSet",
    "FrameSets",
    "LiteShape",
    "Phase",
    "ReferenceShape",
    "Schedule",
    "TrainingConfig",
    "render_sets",
    "train",
    "train_on",
]
