"""The live middleware: operating system processes on Cyclone DDS, compatible with ROS 2 nodes."""

from importlib.metadata import version
from typing import Final

from sunset_ros.rmw.dds._process import CycloneDDS, prepare
from sunset_ros.rmw.dds._tap import CycloneTap
from sunset_ros.rmw.dds.domains import free_domain_id, sole_system

__all__ = [
    "RMW_IMPLEMENTATION",
    "CycloneDDS",
    "CycloneTap",
    "free_domain_id",
    "join",
    "observe",
    "prepare",
    "sole_system",
    "versions",
]

RMW_IMPLEMENTATION: Final = "rmw_cyclonedds_cpp"
"""The RMW_IMPLEMENTATION of ROS 2 nodes that can communicate with ours."""

join: Final = CycloneDDS
observe: Final = CycloneTap


def versions() -> dict[str, str]:
    """Return the versions that a live record depends on, by distribution."""
    return {"cyclonedds": version("cyclonedds")}
