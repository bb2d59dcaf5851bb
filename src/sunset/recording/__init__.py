"""The record of a run: every message as a rosbag2, with digests in place of images, and `run.json`.

A record is a folder with three files: `messages.mcap` and `metadata.yaml` are a rosbag2, which ROS 2 tools open, and
`run.json` has the run's settings and figures. The folder gets its name when it is complete, and two runs of the same
specification have the same bytes. A run that keeps its images has a fourth file, `images.mcap`.
"""

from sunset.recording._bag import BAG_FILES, RecordedMessage
from sunset.recording.images import IMAGES_FILE, StoredImage, image_digests, read_images
from sunset.recording.reader import (
    StoredRun,
    check_extensions,
    read_messages,
    read_stored_run,
    read_timeline,
    story_topics,
)
from sunset.recording.schema import (
    PLAN_VERSION,
    SCORE_REFERENCES,
    TABLE_REFERENCES,
    CampaignPlan,
    RunRecord,
    StoredFault,
    StoredFlight,
    count_runs,
    differences,
    read_plan,
    read_run,
    stored_figures,
)
from sunset.recording.timelines import LogLine, log_of, measured_topics, timeline_of
from sunset.recording.writer import RecordWriter

__all__ = [
    "BAG_FILES",
    "IMAGES_FILE",
    "PLAN_VERSION",
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
    "story_topics",
    "timeline_of",
]
