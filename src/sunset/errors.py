"""The exceptions of SUNSET.

Every error that a user can cause derives from `SunsetError`, and the command line turns it into one
sentence on stderr and exit code 2::

    SunsetError
    ├── InvalidInputError          what a user wrote or passed is not usable
    │   ├── ScenarioError          a scenario or suite: unknown, malformed, out of range
    │   ├── ParameterError         a ROS parameter: unknown, wrong type, out of range
    │   ├── DataError              a bag, a frame, a data set: missing, truncated, of another kind
    │   ├── ModelError             weights or a model card: missing, corrupt, of another shape
    │   ├── ExtensionError         a description of the managed system: not importable, contradicting itself, failing
    │   └── RecordError            a record or a results folder: missing, corrupt, of another version
    ├── ManagerError               a managing system that cannot be loaded, raises, or hangs
    ├── MiddlewareError            misuse or failure of the middleware
    │   └── InterfaceError         a message or service that does not fit its definition
    ├── OutputError                a folder that cannot be written, a disk that is full
    └── MissingExtraError          an optional dependency that is not installed
"""

from sunset_ros.errors import (
    MALFORMED_YAML,
    InterfaceError,
    InvalidInputError,
    MiddlewareError,
    MissingExtraError,
    ParameterError,
    SunsetError,
)

__all__ = [
    "MALFORMED_YAML",
    "DataError",
    "ExtensionError",
    "InterfaceError",
    "InvalidInputError",
    "ManagerError",
    "MiddlewareError",
    "MissingExtraError",
    "ModelError",
    "OutputError",
    "ParameterError",
    "RecordError",
    "ScenarioError",
    "SunsetError",
]


class ScenarioError(InvalidInputError):
    """A scenario or suite is unknown, malformed or out of range."""


class DataError(InvalidInputError):
    """A bag, a frame or a data set is missing, truncated or of another kind."""


class ModelError(InvalidInputError):
    """Weights or a model card are missing, corrupt or of another shape."""


class ExtensionError(InvalidInputError):
    """An extension of the managed system cannot be imported, contradicts itself or the system, or fails."""


class RecordError(InvalidInputError):
    """A record or a folder of results is missing, corrupt or of another version."""


class ManagerError(SunsetError):
    """A managing system cannot be loaded, raised an exception, or did not return."""


class OutputError(SunsetError):
    """A result cannot be written: no permission, no space, no such folder."""
