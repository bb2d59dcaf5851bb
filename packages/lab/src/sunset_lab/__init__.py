"""Training: from rendered frames to a model's weights, thresholds and card.

Trainings and imports need torch and onnx, and a calibration needs onnx (the extra `train`); measurements need neither.
"""

from importlib.util import find_spec

from sunset.errors import MissingExtraError
from sunset_lab.batches import FrameSet
from sunset_lab.config import CONFIGS, MODALITIES, Phase, Schedule, TrainingConfig
from sunset_lab.frames import FrameCounts, FrameSets, frames_of_bag, render_sets, validation_flight
from sunset_lab.lite import LiteShape
from sunset_lab.reference import ReferenceShape

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
    "check_extra",
    "frames_of_bag",
    "render_sets",
    "validation_flight",
]


def check_extra(purpose: str, *packages: str) -> None:
    """Check that packages of the extra `train` are installed.

    Raises:
        MissingExtraError: a package is missing.
    """
    missing = [name for name in packages if find_spec(name) is None]
    if missing:
        raise MissingExtraError(
            f"{purpose} needs {' and '.join(missing)}, not installed: pip install 'sunset-exemplar[train]'."
        )
