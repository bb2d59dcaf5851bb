"""How well a managing system did, measured from outside: pure functions from a timeline to figures."""

from sunset.metrics.timeline import (
    CAMERA_TOPIC,
    FUSION_TOPIC,
    NUMBER_OF_CLASSES,
    SEGMENTATION_TOPIC,
    Command,
    Frames,
    Injection,
    Samples,
    Timeline,
)

__all__ = [
    "CAMERA_TOPIC",
    "FUSION_TOPIC",
    "NUMBER_OF_CLASSES",
    "SEGMENTATION_TOPIC",
    "Command",
    "Frames",
    "Injection",
    "Samples",
    "Timeline",
]
