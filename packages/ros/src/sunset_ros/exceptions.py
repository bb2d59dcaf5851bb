"""The errors of the client library, in rclpy's names."""

from sunset_ros.errors import MiddlewareError, ParameterError

# ruff: noqa: N818  the names are rclpy's


class NotInitializedException(MiddlewareError):
    """The context is not initialised, or was shut down."""


class ROSInterruptException(MiddlewareError):
    """An operation was cut short by the shutdown of its context."""


class UnknownROSArgsError(MiddlewareError, ValueError):
    """An argument after `--ros-args` is unknown or malformed."""


class NameValidationException(MiddlewareError, ValueError):
    """A name of a type, such as "topic name", breaks the rule that `error_msg` says, at `invalid_index`."""

    def __init__(self, name_type: str, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__(
            f"Invalid {name_type} {name!r}: {error_msg} (at character {invalid_index + 1} of {len(name)})."
        )
        self.name_type = name_type
        self.name = name
        self.error_msg = error_msg
        self.invalid_index = invalid_index


class InvalidNamespaceException(NameValidationException):
    """A namespace breaks the rules."""


class InvalidNodeNameException(NameValidationException):
    """A node name breaks the rules."""


class InvalidTopicNameException(NameValidationException):
    """A topic name breaks the rules."""


class InvalidServiceNameException(NameValidationException):
    """A service name breaks the rules."""


class NodeNameNonExistentError(MiddlewareError):
    """A node is asked about that is not there."""


class ParameterException(ParameterError):
    """Base of the errors about parameters."""


class ParameterNotDeclaredException(ParameterException):
    """A parameter is used that was not declared."""


class ParameterAlreadyDeclaredException(ParameterException):
    """A parameter is declared twice."""


class InvalidParameterException(ParameterException):
    """A parameter's name or declaration is invalid."""


class InvalidParameterTypeException(ParameterException):
    """A parameter's value is of a wrong type."""


class InvalidParameterValueException(ParameterException):
    """A parameter's value is refused."""


class ParameterImmutableException(ParameterException):
    """A read-only parameter is changed."""


class ParameterUninitializedException(ParameterException):
    """A parameter is read that was declared with a type and never given a value."""
