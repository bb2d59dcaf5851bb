"""Training: rendered frames become a model's weights, thresholds and card; never imported when flying.

It needs the `train` extra (torch and onnx), but can be imported without.
"""

from sunset.training.batches import FrameSet
from sunset.training.config import CONFIGS, MODALITIES, Phase, Schedule, TrainingConfig
from sunset.training.frames import FrameCounts, FrameSets, render_sets
from sunset.training.importing import import_checkpoints
from sunset.training.lite import LiteShape
from sunset.training.recalibrate import calibrate_model, frames_of_bag
from sunset.training.reference import ReferenceShape
from sunset.training.run import train, train_on
from sunset.training.training_log import draw_log

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
    "calibrate_model",
    "draw_log",
    "frames_of_bag",
    "import_checkpoints",
    "render_sets",
    "train",
    "train_on",
]
