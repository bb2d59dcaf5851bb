"""The record of a run: every message but the pixels, as a rosbag2, and `run.json`.

A record is a folder with three files: `messages.mcap` and `metadata.yaml` are a rosbag2 that ROS 2 tools
open, `run.json` says what was run and what came out. It appears under its name when it is complete, and two
runs of the same specification leave the same bytes. A run that keeps its images has a fourth, `images.mcap`.
"""

from sunset.recording._bag import BAG_FILES
from sunset.recording.campaign import count_runs
from sunset.recording.images import IMAGES_FILE, StoredImage, image_digests, read_images
from sunset.recording.logs import LogLine, log_of
from sunset.recording.reader import check_extensions, read_messages, read_timeline, timeline_of
from sunset.recording.schema import (
    PLAN_FILE,
    PLAN_VERSION,
    RECORD_VERSION,
    RUN_FILE,
    SCORE_REFERENCES,
    TABLE_REFERENCES,
    CampaignPlan,
    RunRecord,
    StoredFault,
    StoredFlight,
    differences,
    read_plan,
    read_run,
    stored_figures,
)
from sunset.recording.stored import StoredRun, read_stored_run, told_topics
from sunset.recording.timelines import measured_topics, timeline
from sunset.recording.values import RecordedMessage
from sunset.recording.writer import RecordWriter

__all__ = [
    "BAG_FILES",
    "IMAGES_FILE",
    "PLAN_FILE",
    "PLAN_VERSION",
    "RECORD_VERSION",
    "RUN_FILE",
    "SCORE_REFERENCES",
    "TABLE_REFERENCES",
    "CampaignPlan",
    "LogLine",
    "RecordWriter",
    "RecordedMessage",
    "RunRecord",
    "StoredFault",
    "StoredFlight",
    "StoredImage",
    "StoredRun",
    "check_extensions",
    "count_runs",
    "differences",
    "image_digests",
    "log_of",
    "measured_topics",
    "read_images",
    "read_messages",
    "read_plan",
    "read_run",
    "read_stored_run",
    "read_timeline",
    "stored_figures",
    "timeline",
    "timeline_of",
    "told_topics",
]
