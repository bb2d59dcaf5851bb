"""The interfaces of the ROS package `system_interfaces`."""

from sunset.system_interfaces import msg, srv

__all__ = ["msg", "srv"]
