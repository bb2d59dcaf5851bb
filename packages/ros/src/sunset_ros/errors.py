"""The exceptions of the client library.

Every error that a user can cause derives from `SunsetError`, and its text is a sentence for the user::

    SunsetError
    ├── InvalidInputError          input that is not usable
    │   └── ParameterError         a ROS parameter: unknown, wrong type, out of range
    ├── MiddlewareError            misuse or failure of the middleware
    │   └── InterfaceError         a message or service that does not fit its definition
    └── MissingExtraError          an optional dependency that is not installed
"""

from sunset_ros.texts import sentence


class SunsetError(Exception):
    """Base of all errors that are raised on purpose; its text is a sentence for the user."""

    def __str__(self) -> str:
        """Return the sentence, printable and of limited length whatever it quotes."""
        return sentence(super().__str__())


class InvalidInputError(SunsetError):
    """Something that the user wrote or passed is not usable."""


class ParameterError(InvalidInputError):
    """A ROS parameter is unknown, of the wrong type or out of range."""


class MiddlewareError(SunsetError):
    """The middleware was misused or failed."""


class InterfaceError(MiddlewareError):
    """A message or service does not fit its definition."""


class MissingExtraError(SunsetError):
    """An optional dependency is needed and not installed."""


MALFORMED_YAML = (ArithmeticError, AttributeError, LookupError, RecursionError, ValueError)
"""What PyYAML raises besides its own errors, where a value does not fit its tag or is nested too deeply."""
