"""The interfaces of the ROS package `std_msgs`."""

from sunset.interfaces.std_msgs import msg

__all__ = ["msg"]
