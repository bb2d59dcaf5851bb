"""Full and short names of the managed system's nodes and topics, and names of scenarios."""

import re
from collections.abc import Sequence
from typing import Final

NAMESPACE: Final = "/managed_subsystem"
"""The namespace of the managed system."""

FAULT_ACCESS: Final = "fault_access"
"""The parameter of managed nodes that lets the experiment change and end faults."""

TOPIC_PATTERN: Final = r"^/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*\Z"


def is_topic_name(name: str) -> bool:
    """Return whether a text is the name of a topic, full or relative, without substitutions.

    >>> is_topic_name("rgb_camera"), is_topic_name("/a/b_1"), is_topic_name("~/rgb"), is_topic_name("a b")
    (True, True, False, False)
    """
    return re.search(TOPIC_PATTERN, name) is not None


def full_name(name: str) -> str:
    """Return the full name of a node or topic; a relative name is in the managed system's namespace.

    >>> full_name("camera"), full_name("/rgb_raw")
    ('/managed_subsystem/camera', '/rgb_raw')
    """
    return name if name.startswith("/") else f"{NAMESPACE}/{name}"


def short_name(name: str) -> str:
    """Return a name without the managed system's namespace.

    >>> short_name("/managed_subsystem/camera"), short_name("camera"), short_name("/elsewhere/camera")
    ('camera', 'camera', '/elsewhere/camera')
    """
    return name.removeprefix(f"{NAMESPACE}/")


def scenario_name(suite: str, faults: Sequence[str]) -> str:
    """Return the name of a suite's scenario; a scenario without faults has the suite's name.

    >>> scenario_name("degraded", ("image_shift", "autofocus_needed")), scenario_name("nofault", ())
    ('degraded/image_shift+autofocus_needed', 'nofault')
    """
    return f"{suite}/{'+'.join(faults)}" if faults else suite


def frequency_entry(topic: str) -> str:
    """Return the blackboard's entry with the frequency of a topic.

    >>> frequency_entry("rgb_camera"), frequency_entry("/rgb_raw")
    ('managed_subsystem_rgb_camera_freq', 'rgb_raw_freq')
    """
    return f"{full_name(topic).strip('/').replace('/', '_')}_freq"


def age_entry(topic: str) -> str:
    """Return the blackboard's entry with the age of the last message on a topic.

    >>> age_entry("rgb_camera"), age_entry("/rgb_raw")
    ('managed_subsystem_rgb_camera_age', 'rgb_raw_age')
    """
    return f"{frequency_entry(topic).removesuffix('_freq')}_age"


def state_entry(node: str) -> str:
    """Return the blackboard's entry with the lifecycle state of a node, such as `camera_lc_state` for `camera`."""
    return f"{node}_lc_state"


def heartbeat_entry(node: str) -> str:
    """Return the blackboard's entry with the frequency of heartbeats, such as `camera_heartbeat_freq`."""
    return f"{node}_heartbeat_freq"
