"""The interfaces of the ROS package `system_interfaces`."""

from sunset.interfaces.system_interfaces import msg, srv

__all__ = ["msg", "srv"]
