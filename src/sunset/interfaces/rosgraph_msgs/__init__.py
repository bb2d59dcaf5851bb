"""The interfaces of the ROS package `rosgraph_msgs`."""

from sunset.interfaces.rosgraph_msgs import msg

__all__ = ["msg"]
