"""Whether the metadata beside a record's bag, which ROS 2 tools open it by, is of this bag."""

from collections import Counter
from pathlib import Path
from typing import Final

import yaml

from sunset.errors import MALFORMED_YAML
from sunset.input_files import read_text
from sunset.interfaces import get_message, type_hash
from sunset.recording._bag import BAG_FILES, read_bag, stored_topic

_KEYS: Final = frozenset(
    {
        "version",
        "storage_identifier",
        "relative_file_paths",
        "duration",
        "starting_time",
        "message_count",
        "topics_with_message_count",
        "compression_format",
        "compression_mode",
        "files",
        "custom_data",
        "ros_distro",
    }
)
_LONGEST: Final = 2**18
"""Characters that the metadata never has; YAML is slow to read."""


def describes_bag(folder: Path) -> bool:
    """Return whether the metadata of a record's bag names its file, its topics, its times and how many messages it has.

    Raises:
        RecordError: the bag is missing, truncated or damaged.
    """
    file, metadata = BAG_FILES
    payloads = list(read_bag(folder))
    counts = Counter((payload.topic, payload.type) for payload in payloads)
    start_ns = min((payload.time_ns for payload in payloads), default=None)
    end_ns = max((payload.time_ns for payload in payloads), default=None)
    try:
        text = read_text(folder / metadata)
        if len(text) > _LONGEST:
            return False
        told = yaml.safe_load(text)["rosbag2_bagfile_information"]
        topics = [(one["topic_metadata"], one["message_count"]) for one in told["topics_with_message_count"]]
        (part,) = told["files"]
        start = {"nanoseconds_since_epoch": start_ns}
        length = {"nanoseconds": None if start_ns is None or end_ns is None else end_ns - start_ns}
        return bool(
            told.keys() == _KEYS
            and (told["storage_identifier"], told["relative_file_paths"]) == ("mcap", [file])
            and (told["message_count"], told["custom_data"]) == (len(payloads), None)
            and part.keys() == {"path", "starting_time", "duration", "message_count"}
            and (part["path"], part["message_count"]) == (file, len(payloads))
            and (not payloads or start == told["starting_time"] == part["starting_time"])
            and (not payloads or length == told["duration"] == part["duration"])
            and sorted((topic["name"], topic["type"], count) for topic, count in topics)
            == sorted((stored_topic(*key), key[1], count) for key, count in counts.items())
            and all(
                topic["type_description_hash"] == type_hash(get_message(topic["type"])) for topic, _ in topics
            )
        )
    except (OSError, yaml.YAMLError, *MALFORMED_YAML, TypeError):
        return False
