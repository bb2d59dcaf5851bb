"""The interfaces of the ROS package `service_msgs`."""

from sunset.interfaces.service_msgs import msg

__all__ = ["msg"]
