"""Training: from rendered frames to a model's weights, thresholds and card.

Trainings and imports need torch and onnx, and a calibration needs onnx (the extra `train`); measurements need neither.
"""

from sunset_lab.config import CONFIGS, MODALITIES, Phase, Schedule, TrainingConfig
from sunset_lab.frames import FrameSet, FrameSets, frames_of_bag, validation_flight
from sunset_lab.shapes import LiteShape, ReferenceShape

__all__ = [
    "CONFIGS",
    "MODALITIES",
    "FrameSet",
    "FrameSets",
    "LiteShape",
    "Phase",
    "ReferenceShape",
    "Schedule",
    "TrainingConfig",
    "frames_of_bag",
    "validation_flight",
]
