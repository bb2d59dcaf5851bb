"""The live middleware: operating system processes on DDS, which ROS 2 nodes take for theirs."""

from sunset.rmw.dds._process import CycloneDDS, prepare
from sunset.rmw.dds._tap import CycloneTap
from sunset.rmw.dds.domains import free_domain_id, sole_system

__all__ = ["CycloneDDS", "CycloneTap", "free_domain_id", "prepare", "sole_system"]
