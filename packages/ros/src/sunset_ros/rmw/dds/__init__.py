"""The live middleware: operating system processes on Cyclone DDS, compatible with ROS 2 nodes."""

from importlib.metadata import version
from typing import Final

from sunset_ros.interfaces import Message, type_hash, type_name
from sunset_ros.rmw.dds import _wheel as wheel
from sunset_ros.rmw.dds._endpoints import CycloneDDS as CycloneDDS
from sunset_ros.rmw.dds._graph import dds_type_name
from sunset_ros.rmw.dds._tap import CycloneTap as CycloneTap
from sunset_ros.rmw.dds.domains import free_domain_id as free_domain_id
from sunset_ros.rmw.dds.domains import sole_system as sole_system

RMW_IMPLEMENTATION: Final = "rmw_cyclonedds_cpp"
"""The RMW_IMPLEMENTATION of ROS 2 nodes that can communicate with ours."""

join: Final = CycloneDDS
observe: Final = CycloneTap


def versions() -> dict[str, str]:
    """Return the versions that a live record depends on, by distribution."""
    return {"cyclonedds": version("cyclonedds")}


def prepare() -> None:
    """Do the work for all imported messages that forks of this process share; join no network, start no thread."""
    for kind in Message.__subclasses__():
        wheel.octet_type(dds_type_name(type_name(kind)))
        type_hash(kind)
