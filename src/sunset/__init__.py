"""SUNSET: a ROS 2 exemplar for self-adaptation under concurrent, ambiguous faults."""

__all__ = ["__version__"]

__version__ = "0.1.0"
