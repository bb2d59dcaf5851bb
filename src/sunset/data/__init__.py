"""Frames: the town renderer and flight bags (rosbag2) in and out."""

from sunset.data.frame import DEPTH_RANGE_M, FRAME_SIZE, Frame
from sunset.data.light import TIMES, WEATHERS
from sunset.data.views import HEIGHTS_M, PITCHES_DEG, TrainingView, render_views, training_views

__all__ = [
    "DEPTH_RANGE_M",
    "FRAME_SIZE",
    "HEIGHTS_M",
    "PITCHES_DEG",
    "TIMES",
    "WEATHERS",
    "Frame",
    "TrainingView",
    "render_views",
    "training_views",
]
