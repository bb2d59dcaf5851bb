"""The interfaces of the ROS package `lifecycle_msgs`."""

from sunset.interfaces.lifecycle_msgs import msg, srv

__all__ = ["msg", "srv"]
