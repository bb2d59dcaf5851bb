"""The interfaces of the ROS package `geometry_msgs`."""

from sunset.interfaces.geometry_msgs import msg

__all__ = ["msg"]
