"""The interfaces of the ROS package `sensor_msgs`."""

from sunset.interfaces.sensor_msgs import msg

__all__ = ["msg"]
