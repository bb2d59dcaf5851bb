"""Another participant of DDS, made of the `cyclonedds` wheel alone: what the network looks like to others.

It knows nothing of SUNSET's sources. Its types are one octet and whatever follows, so it sends and gets any bytes.
"""

import struct
import threading
from collections.abc import Callable
from typing import Any

from cyclonedds._clayer import ddspy_take, ddspy_write
from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsParticipant,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct
from cyclonedds.idl.types import uint8
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

FOREVER = 2**63 - 1
ANY = 127
RELIABLE = Qos(Policy.Reliability.Reliable(FOREVER), Policy.History.KeepLast(1000))
LATCHED = Qos(
    Policy.Reliability.Reliable(FOREVER), Policy.Durability.TransientLocal, Policy.History.KeepLast(1)
)


def payload(body: bytes) -> bytes:
    """Return a sample: little-endian CDR, padded to a multiple of 4 bytes."""
    return b"\x00\x01\x00\x00" + body + bytes(-len(body) % 4)


def text(value: str) -> bytes:
    """Return a string as CDR has it, at a multiple of 4 bytes: its length with the NUL, its bytes, the NUL."""
    data = value.encode() + b"\x00"
    return struct.pack("<I", len(data)) + data + bytes(-len(data) % 4)


def header(client: int, number: int) -> bytes:
    """Return what stands before the fields of a request or response."""
    return struct.pack("<Qq", client, number)


class Peer:
    """A participant in a domain that this process has set up."""

    def __init__(self, domain_id: int, user_data: bytes = b"") -> None:
        self.participant = DomainParticipant(domain_id, Qos(Policy.Userdata(user_data)))
        self._builtin = {
            topic: BuiltinDataReader(self.participant, topic)
            for topic in (
                BuiltinTopicDcpsParticipant,
                BuiltinTopicDcpsPublication,
                BuiltinTopicDcpsSubscription,
            )
        }
        self._kept: list[Any] = []

    def _topic(self, name: str, type_name: str) -> Any:
        octet = make_idl_struct("Octet", type_name.replace("::", "."), {"octet": uint8}, dataclassify=False)
        return Topic(self.participant, name, octet)

    def writer(self, topic: str, type_name: str, qos: Qos = RELIABLE, user_data: bytes = b"") -> Any:
        """Make a writer."""
        return self._made(DataWriter, topic, type_name, Qos(*qos, Policy.Userdata(user_data)))

    def reader(self, topic: str, type_name: str, qos: Qos = RELIABLE, user_data: bytes = b"") -> Any:
        """Make a reader."""
        return self._made(DataReader, topic, type_name, Qos(*qos, Policy.Userdata(user_data)))

    def _made(self, kind: Any, topic: str, type_name: str, qos: Qos) -> Any:
        made = kind(self.participant, self._topic(topic, type_name), qos)
        self._kept.append(made)  # else it would be deleted with its last reference
        return made

    @staticmethod
    def send(writer: Any, sample: bytes) -> None:
        """Send any bytes."""
        assert ddspy_write(writer._ref, sample) == 0

    @staticmethod
    def try_to_send(writer: Any, sample: bytes) -> bool:
        """Send any bytes, if DDS lets it; return whether it does."""
        return bool(ddspy_write(writer._ref, sample) == 0)

    @staticmethod
    def take(reader: Any) -> list[bytes]:
        """Return the samples that have come."""
        return [sample for sample, info in ddspy_take(reader._ref, ANY, 1000) if info.valid_data]

    def collect(self, reader: Any, count: int) -> list[bytes]:
        """Return so many samples that come, or what has come if it is too little for long."""
        samples: list[bytes] = []

        def enough() -> bool:
            samples.extend(self.take(reader))
            return len(samples) >= count

        self.wait(enough)
        return samples

    def other_participant(self) -> bytes:
        """Return the GUID of the one other participant."""
        (guid,) = self.participants().keys() - {self.participant.guid.bytes}
        return guid

    @staticmethod
    def policies(announced: Any) -> dict[str, Any]:
        """Return the quality of service in a description, by policy."""
        return {policy.__scope__.split("<")[0]: policy for policy in announced.qos}

    def participants(self) -> dict[bytes, Any]:
        """Return what is announced of each participant, by GUID."""
        samples = self._builtin[BuiltinTopicDcpsParticipant].read(1000)
        return {each.key.bytes: each for each in samples if each.sample_info.valid_data}

    def writers(self, topic: str) -> list[Any]:
        """Return what is announced of the writers on a topic."""
        return self._endpoints(BuiltinTopicDcpsPublication, topic)

    def readers(self, topic: str) -> list[Any]:
        """Return what is announced of the readers on a topic."""
        return self._endpoints(BuiltinTopicDcpsSubscription, topic)

    def every_reader(self) -> list[Any]:
        """Return what is announced of all readers."""
        return self._endpoints(BuiltinTopicDcpsSubscription, None)

    def _endpoints(self, builtin: Any, topic: str | None) -> list[Any]:
        samples = self._builtin[builtin].read(1000)
        return [
            each
            for each in samples
            if each.sample_info.valid_data
            and topic in {None, each.topic_name}
            and each.participant_key != self.participant.guid
        ]

    def wait(self, predicate: Callable[[], bool], seconds: float = 10.0) -> bool:
        """Wait until a predicate holds; return whether it does."""
        pause = threading.Event()
        for _ in range(round(seconds / 0.01)):
            if predicate():
                return True
            pause.wait(0.01)
        return predicate()

    def leave(self) -> None:
        """Leave the domain, with all that was made."""
        self.participant._delete(self.participant._ref)
