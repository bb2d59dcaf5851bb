"""Flights: rendered frames, bags (rosbag2) in and out, and the import of recordings."""

from sunset.data.bag import TOPICS, BagReader, read_bag, write_bag
from sunset.data.bag_statistics import BagStatistics, bag_statistics
from sunset.data.conventions import DEPTH_UNITS, IDS, SYNDRONE, Reading
from sunset.data.flight import (
    DEFAULT_FLIGHT,
    RENDERING,
    FlightPlan,
    bag_checksum,
    cache_folder,
    default_flight,
    flight_bag,
    flight_bags,
    flight_place,
    flights_folder,
    frames_for,
    kept_bag,
    render_frames,
    render_views,
)
from sunset.data.picture_folder import PictureFolder, find_pictures
from sunset.data.syndrone import find_syndrone, is_syndrone, survey_syndrone
from sunset.flights import TIMES, WEATHERS
from sunset_town import DEPTH_RANGE_M, FRAME_SIZE, HEIGHTS_M, PITCHES_DEG, RENDER_VERSION, Frame

__all__ = [
    "DEFAULT_FLIGHT",
    "DEPTH_RANGE_M",
    "DEPTH_UNITS",
    "FRAME_SIZE",
    "HEIGHTS_M",
    "IDS",
    "PITCHES_DEG",
    "RENDERING",
    "RENDER_VERSION",
    "SYNDRONE",
    "TIMES",
    "TOPICS",
    "WEATHERS",
    "BagReader",
    "BagStatistics",
    "FlightPlan",
    "Frame",
    "PictureFolder",
    "Reading",
    "bag_checksum",
    "bag_statistics",
    "cache_folder",
    "default_flight",
    "find_pictures",
    "find_syndrone",
    "flight_bag",
    "flight_bags",
    "flight_place",
    "flights_folder",
    "frames_for",
    "is_syndrone",
    "kept_bag",
    "read_bag",
    "render_frames",
    "render_views",
    "survey_syndrone",
    "write_bag",
]
