"""The interfaces of the ROS package `rcl_interfaces`."""

from sunset.interfaces.rcl_interfaces import msg, srv

__all__ = ["msg", "srv"]
