"""Messages to payloads and back."""

from struct import error as StructError  # noqa: N812  it is a class
from typing import TypeVar

from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces._check import misfit
from sunset_ros.interfaces._codec import PAD4
from sunset_ros.interfaces._message import Message

_ENCAPSULATION = b"\x00\x01\x00\x00"
"""Plain CDR, little endian, no options."""

_M = TypeVar("_M", bound=Message)


def serialize(message: Message) -> bytes:
    """Return a message as a CDR payload: encapsulation header, fields, padded to a multiple of 4 bytes.

    Raises:
        InterfaceError: a field's value does not fit the definition.

    >>> from sunset_ros.interfaces.std_msgs.msg import Bool
    >>> serialize(Bool(data=True)).hex()
    '0001000001000000'
    """
    out = bytearray(_ENCAPSULATION)
    try:
        message.encode_into(out)
    except (
        AttributeError,
        TypeError,
        ValueError,
        KeyError,
        OverflowError,
        StructError,
        InterfaceError,
    ) as error:
        if not isinstance(message, Message):
            raise InterfaceError(f"Only a message can be serialized, got {message!r}.") from error
        raise misfit(message, error) from error
    out += PAD4[len(out) & 3]
    return bytes(out)


def deserialize(raw: bytes | bytearray | memoryview, kind: type[_M]) -> _M:
    """Return the message of class `kind` in a CDR payload.

    Arrays of numbers look at the payload's own bytes, read-only: nothing is copied.

    Args:
        raw: the payload with its encapsulation header; up to 3 bytes may follow the message.
        kind: the message class.

    Raises:
        InterfaceError: the payload is not little-endian CDR, or not a message of this class.
    """
    payload = bytes(raw)
    if payload[:2] != _ENCAPSULATION[:2]:
        raise InterfaceError(
            f"A payload of little-endian CDR starts with 0001, got {payload[:4].hex() or 'nothing'}."
        )
    try:
        message, end = kind.decode_from(payload, len(_ENCAPSULATION))
    except (ValueError, IndexError, OverflowError, StructError, InterfaceError) as error:
        raise InterfaceError(
            f"A payload of {len(payload)} bytes is not a {kind.__ros_name__}: {str(error).rstrip('.')}."
        ) from error
    if not end <= len(payload) < end + 4:
        raise InterfaceError(
            f"A payload of {len(payload)} bytes is not a {kind.__ros_name__}, which ends at byte {end}."
        )
    return message
