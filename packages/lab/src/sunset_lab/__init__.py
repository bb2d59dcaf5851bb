"""Training: from rendered frames to a model's weights, thresholds and card.

Trainings and imports need torch and onnx, and a calibration needs onnx (the extra `train`); measurements need neither.
"""

from sunset_lab.config import CONFIGS as CONFIGS
from sunset_lab.config import MODALITIES as MODALITIES
from sunset_lab.config import Schedule as Schedule
from sunset_lab.config import TrainingConfig as TrainingConfig
from sunset_lab.frames import FrameSet as FrameSet
from sunset_lab.frames import frames_of_bag as frames_of_bag
from sunset_lab.frames import validation_flight as validation_flight
