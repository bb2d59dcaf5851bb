"""Names of nodes on the ROS graph and of the files of records, and values as ROS and YAML write them."""

from typing import Final

RUN_FILE: Final = "run.json"
"""The file of a run's folder that appears when the run is complete."""
PLAN_FILE: Final = "bench.json"
"""The file of a campaign's folder with its plan."""


def base_name(name: str) -> str:
    """Return a name without its namespace.

    >>> base_name("/managed_subsystem/camera"), base_name("camera")
    ('camera', 'camera')
    """
    return name.rpartition("/")[2]


def ros_text(value: object) -> str:
    """Return a value as ROS and YAML write it, with truth values in lower case.

    >>> ros_text(True), ros_text(0.5), ros_text("rgb_camera")
    ('true', '0.5', 'rgb_camera')
    """
    return str(value).lower() if isinstance(value, bool) else str(value)
