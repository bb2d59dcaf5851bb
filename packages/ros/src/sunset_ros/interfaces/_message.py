"""The base classes of messages and services."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import ClassVar, Self

import numpy as np

_LONG = 8
"""Arrays with more elements are shown by their size."""


class Message:  # noqa: PLW1641  mutable values are not hashable
    """Base of all message classes.

    A message has value semantics: it equals another of its class with equal fields, and is not hashable.
    Assigning to a field checks nothing; `serialize` checks the fields.
    """

    __slots__ = ()

    __ros_name__: ClassVar[str]
    """The full name, such as `sensor_msgs/msg/Image`."""

    __ros_fields__: ClassVar[Mapping[str, str]]
    """Field name → its type as written in the .msg file, in the order of the definition."""

    @abstractmethod
    def copy(self) -> Self:
        """Return a structural copy: new messages and lists, the same arrays, now marked read-only."""
        raise NotImplementedError

    @abstractmethod
    def encode_into(self, out: bytearray) -> None:
        """Append the fields as CDR to a payload whose encapsulation header is written; see `serialize`."""
        raise NotImplementedError

    @classmethod
    @abstractmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        """Return the message that starts at a position, and the position behind it; see `deserialize`."""
        raise NotImplementedError

    def __eq__(self, other: object) -> bool:
        if other.__class__ is not self.__class__:
            return NotImplemented
        return all(_equal(getattr(self, name), getattr(other, name)) for name in self.__ros_fields__)

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}={_shown(getattr(self, name))}" for name in self.__ros_fields__)
        return f"{self.__class__.__name__}({fields})"


class Service:
    """Base of all service classes; `Request` and `Response` are its messages."""

    __slots__ = ()

    __ros_name__: ClassVar[str]
    """The full name, such as `std_srvs/srv/SetBool`."""

    Request: ClassVar[type[Message]]
    Response: ClassVar[type[Message]]


def _equal(left: object, right: object) -> bool:
    if isinstance(left, np.ndarray) or isinstance(right, np.ndarray):
        return np.array_equal(np.asarray(left), np.asarray(right))
    return left == right


def _shown(value: object) -> str:
    if isinstance(value, np.ndarray):
        if value.size > _LONG:
            return f"<{value.size} {value.dtype}>"
        return repr(value.tolist())
    return repr(value)
