"""The interfaces of the ROS package `std_srvs`."""

from sunset.interfaces.std_srvs import srv

__all__ = ["srv"]
