"""`sunset ros`: the commands of the library `sunset_ros`."""

from sunset_ros.commands import add_arguments

__all__ = ["add_arguments"]
