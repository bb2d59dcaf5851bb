"""The town: conditions and poses in, rendered frames with depth and labels out."""

from sunset_town.errors import MissingEmbreeError, TownError
from sunset_town.flight import (
    HEIGHTS_M,
    LENGTH_M,
    PITCHES_DEG,
    Flight,
    render_frames,
    render_views,
    training_views,
)
from sunset_town.frame import CARLA_IDS, DEPTH_RANGE_M, FRAME_SIZE, Frame
from sunset_town.layout import TOWNS
from sunset_town.light import TIMES, WEATHERS
from sunset_town.renderer import RENDER_VERSION, Pose, View, render
from sunset_town.town import Town, build_town

__all__ = [
    "CARLA_IDS",
    "DEPTH_RANGE_M",
    "FRAME_SIZE",
    "HEIGHTS_M",
    "LENGTH_M",
    "PITCHES_DEG",
    "RENDER_VERSION",
    "TIMES",
    "TOWNS",
    "WEATHERS",
    "Flight",
    "Frame",
    "MissingEmbreeError",
    "Pose",
    "Town",
    "TownError",
    "View",
    "build_town",
    "render",
    "render_frames",
    "render_views",
    "training_views",
]
