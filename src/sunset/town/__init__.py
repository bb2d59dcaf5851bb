"""The town: conditions and poses in, rendered frames with depth and labels out."""

from sunset.town.camera import Pose
from sunset.town.errors import MissingEmbreeError, TownError
from sunset.town.flight import LENGTH_M, Flight, render_frames
from sunset.town.frame import CARLA_IDS, DEPTH_RANGE_M, FRAME_SIZE, Frame
from sunset.town.layout import TOWNS
from sunset.town.light import TIMES, WEATHERS
from sunset.town.renderer import RENDER_VERSION, View, render
from sunset.town.town import Town, build_town
from sunset.town.views import HEIGHTS_M, PITCHES_DEG, render_views, training_views

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
