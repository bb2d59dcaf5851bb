"""The record of a run: every message as a rosbag2, with digests in place of images, and `run.json`.

A record is a folder with three files: `messages.mcap` and `metadata.yaml` are a rosbag2, which ROS 2 tools open, and
`run.json` has the run's settings and figures. The folder gets its name when it is complete, and two runs of the same
specification have the same bytes. A run that keeps its images has a fourth file, `images.mcap`.
"""

from sunset.recording._bag import BAG_FILES as BAG_FILES
from sunset.recording._bag import RecordedMessage as RecordedMessage
from sunset.recording.images import IMAGES_FILE as IMAGES_FILE
from sunset.recording.images import StoredImage as StoredImage
from sunset.recording.images import image_digests as image_digests
from sunset.recording.images import read_images as read_images
from sunset.recording.reader import StoredRun as StoredRun
from sunset.recording.reader import check_extensions as check_extensions
from sunset.recording.reader import read_messages as read_messages
from sunset.recording.reader import read_stored_run as read_stored_run
from sunset.recording.reader import read_timeline as read_timeline
from sunset.recording.reader import story_topics as story_topics
from sunset.recording.requests import request_of as request_of
from sunset.recording.schema import PLAN_VERSION as PLAN_VERSION
from sunset.recording.schema import SCORE_REFERENCES as SCORE_REFERENCES
from sunset.recording.schema import SETTINGS as SETTINGS
from sunset.recording.schema import TABLE_REFERENCES as TABLE_REFERENCES
from sunset.recording.schema import CampaignPlan as CampaignPlan
from sunset.recording.schema import RunRecord as RunRecord
from sunset.recording.schema import StoredFault as StoredFault
from sunset.recording.schema import StoredFlight as StoredFlight
from sunset.recording.schema import count_runs as count_runs
from sunset.recording.schema import differences as differences
from sunset.recording.schema import read_plan as read_plan
from sunset.recording.schema import read_run as read_run
from sunset.recording.schema import stored_figures as stored_figures
from sunset.recording.timelines import LogLine as LogLine
from sunset.recording.timelines import log_of as log_of
from sunset.recording.timelines import measured_topics as measured_topics
from sunset.recording.timelines import timeline_of as timeline_of
from sunset.recording.writer import RecordWriter as RecordWriter
