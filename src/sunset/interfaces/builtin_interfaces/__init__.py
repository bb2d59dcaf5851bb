"""The interfaces of the ROS package `builtin_interfaces`."""

from sunset.interfaces.builtin_interfaces import msg

__all__ = ["msg"]
