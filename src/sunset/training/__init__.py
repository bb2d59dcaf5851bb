"""Training: rendered frames become a model's weights, thresholds and card; never imported when flying.

It needs the `train` extra (torch and onnx), but can be imported without.
"""

from sunset.training.architecture import NetworkShape
from sunset.training.batches import FrameSet
from sunset.training.config import MODALITIES, Schedule, TrainingConfig
from sunset.training.frames import FrameCounts, FrameSets, render_sets
from sunset.training.run import train, train_on

__all__ = [
    "MODALITIES",
    "FrameCounts",
    "FrameSet",
    "FrameSets",
    "NetworkShape",
    "Schedule",
    "TrainingConfig",
    "render_sets",
    "train",
    "train_on",
]
