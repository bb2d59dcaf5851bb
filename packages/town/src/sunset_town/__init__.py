"""The town: conditions and poses in, rendered frames with depth and labels out."""

from sunset_town.errors import MissingEmbreeError as MissingEmbreeError
from sunset_town.errors import TownError as TownError
from sunset_town.flight import HEIGHTS_M as HEIGHTS_M
from sunset_town.flight import LENGTH_M as LENGTH_M
from sunset_town.flight import PITCHES_DEG as PITCHES_DEG
from sunset_town.flight import Flight as Flight
from sunset_town.flight import render_frames as render_frames
from sunset_town.flight import render_views as render_views
from sunset_town.flight import training_views as training_views
from sunset_town.frame import CARLA_IDS as CARLA_IDS
from sunset_town.frame import DEPTH_RANGE_M as DEPTH_RANGE_M
from sunset_town.frame import FRAME_SIZE as FRAME_SIZE
from sunset_town.frame import Frame as Frame
from sunset_town.layout import TOWNS as TOWNS
from sunset_town.light import TIMES as TIMES
from sunset_town.light import WEATHERS as WEATHERS
from sunset_town.renderer import RENDER_VERSION as RENDER_VERSION
from sunset_town.renderer import Pose as Pose
from sunset_town.renderer import View as View
from sunset_town.renderer import render as render
from sunset_town.town import Town as Town
from sunset_town.town import build_town as build_town
