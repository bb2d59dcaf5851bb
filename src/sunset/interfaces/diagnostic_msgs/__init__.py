"""The interfaces of the ROS package `diagnostic_msgs`."""

from sunset.interfaces.diagnostic_msgs import msg

__all__ = ["msg"]
