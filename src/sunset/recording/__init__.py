"""The record of a run: every message but the pixels, as a rosbag2, and `run.json`.

A record is a folder with three files: `messages.mcap` and `metadata.yaml` are a rosbag2 that ROS 2 tools
open, `run.json` says what was run and what came out. It appears under its name when it is complete, and two
runs of the same specification leave the same bytes.
"""

from sunset.recording.reader import read_messages, read_run, read_timeline
from sunset.recording.run_file import (
    check_entries,
    check_entry,
    check_number,
    differing_figures,
    stored_figures,
)
from sunset.recording.stored import LogLine, StoredRun, read_log, read_stored_run
from sunset.recording.timelines import timeline
from sunset.recording.values import RECORD_VERSION, RUN_FILE, RecordedMessage
from sunset.recording.writer import RecordWriter

__all__ = [
    "RECORD_VERSION",
    "RUN_FILE",
    "LogLine",
    "RecordWriter",
    "RecordedMessage",
    "StoredRun",
    "check_entries",
    "check_entry",
    "check_number",
    "differing_figures",
    "read_log",
    "read_messages",
    "read_run",
    "read_stored_run",
    "read_timeline",
    "stored_figures",
    "timeline",
]
