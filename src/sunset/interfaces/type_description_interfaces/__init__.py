"""The interfaces of the ROS package `type_description_interfaces`."""

from sunset.interfaces.type_description_interfaces import msg, srv

__all__ = ["msg", "srv"]
