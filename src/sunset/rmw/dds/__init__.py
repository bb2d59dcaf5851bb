"""The live middleware: operating system processes on DDS, which ROS 2 nodes take for theirs."""

from importlib.metadata import version
from typing import Final

from sunset.rmw.dds._process import CycloneDDS, prepare
from sunset.rmw.dds._tap import CycloneTap
from sunset.rmw.dds.domains import free_domain_id, sole_system

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
"""What ROS 2 calls the middleware that its nodes must have to meet ours."""


join: Final = CycloneDDS
observe: Final = CycloneTap


def versions() -> dict[str, str]:
    """Return what a live record depends on: distribution → version."""
    return {"cyclonedds": version("cyclonedds")}
