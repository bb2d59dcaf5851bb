"""Full and short names of the managed system's nodes and topics."""

from typing import Final

NAMESPACE: Final = "/managed_subsystem"
"""The namespace of the managed system."""


def full_name(name: str) -> str:
    """Return the full name of a node or topic; a relative one is in the managed system's namespace.

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


def frequency_entry(topic: str) -> str:
    """Return the blackboard's entry with the frequency of a topic.

    >>> frequency_entry("rgb_camera"), frequency_entry("/rgb_raw")
    ('managed_subsystem_rgb_camera_freq', 'rgb_raw_freq')
    """
    return f"{full_name(topic).strip('/').replace('/', '_')}_freq"
