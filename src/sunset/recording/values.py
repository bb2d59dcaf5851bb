"""Recorded messages, decoded and as stored."""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass

from msgspec import Struct

from sunset.errors import InterfaceError, RecordError
from sunset_ros.interfaces import Message, deserialize, get_message


@dataclass(frozen=True, slots=True)
class RecordedMessage:
    """A message in a record.

    Attributes:
        topic: the full name of the topic.
        time_ns: when the message left its publisher, in nanoseconds on the experiment's clock.
        message: the content; in place of an image, a `system_interfaces/msg/ImageDigest`.
    """

    topic: str
    time_ns: int
    message: Message


class Payload(Struct, frozen=True, array_like=True, gc=False):
    """A message as a record stores it: with the name of its type, and its CDR."""

    topic: str
    type: str
    time_ns: int
    cdr: bytes

    def decoded(self) -> RecordedMessage:
        """Return the message.

        Raises:
            RecordError: the type is unknown, or the bytes do not fit it.
        """
        try:
            return RecordedMessage(self.topic, self.time_ns, deserialize(self.cdr, get_message(self.type)))
        except InterfaceError as error:
            raise RecordError(
                f"The message on {self.topic} at {self.time_ns} ns is damaged: {error}"
            ) from error


def digest_of(payloads: Iterable[Payload]) -> str:
    """Return the SHA-256 over topic, type, time and bytes of all messages in order, in hexadecimal."""
    digest = hashlib.sha256()
    for payload in payloads:
        head = f"{payload.topic} {payload.type} {payload.time_ns} {len(payload.cdr)}\n"
        digest.update(head.encode() + payload.cdr)
    return digest.hexdigest()
