"""The interfaces of the ROS package `tf2_msgs`."""

from sunset.interfaces.tf2_msgs import msg

__all__ = ["msg"]
