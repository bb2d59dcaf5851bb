"""The interfaces of the ROS package `rmw_dds_common`."""

from sunset.interfaces.rmw_dds_common import msg

__all__ = ["msg"]
