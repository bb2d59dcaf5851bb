"""The private functions of the wheel `cyclonedds` that this library needs.

Topics of a type, samples as raw CDR, and endpoints from built-in topics exist only as private functions, in the version
that `_library` accepts.
"""

import ctypes
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, Final, NamedTuple, TypeVar

from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.dds._library import checked, delete, read_qos, sertype_of

from cyclonedds import _clayer  # isort: skip  after the version was checked
from cyclonedds.idl import make_idl_struct  # isort: skip
from cyclonedds.idl.types import uint8  # isort: skip

T = TypeVar("T")

MAKING_TOPIC: Final = threading.Lock()
"""Held while a topic is made: its participant must not be deleted meanwhile."""

_ANY: Final = 127  # samples in every state
_ALIVE: Final = 16  # the state of existing instances
_BATCH: Final = 1000
_OPERATIONS: Final = 14
_TYPE_INFORMATION: Final = (8, 9, 10)  # type_id, type_map, type_info of struct ddsi_sertype_ops


@contextmanager
def topic_of(participant: int, name: str, type_name: str) -> Iterator[int]:
    """Make a topic, from its name and its type's name in DDS, for writers and readers made within the context.

    As in ROS 2, they announce no type information, so DDS compares only the names of types. The wheel's own type
    information would prevent connections to processes that define the type differently. DDS does not check samples;
    they are checked when they are decoded.
    """
    with MAKING_TOPIC:  # topics of a type share the table that is changed here
        topic: int = _clayer.ddspy_topic_create(participant, name, octet_type(type_name), None, None)
        checked(topic, f"make topic {name}")
        operations = ctypes.c_void_p.from_address(sertype_of(topic))  # the first member of a sertype
        original = operations.value
        operations.value = ctypes.addressof(_without_type_information(original))
        try:
            yield topic
        finally:
            operations.value = original  # deleting the type needs them
            delete(topic)


@cache
def octet_type(type_name: str) -> object:
    """Return a type of the wheel for topics, which has a single octet."""
    kind = make_idl_struct("Octet", type_name.replace("::", "."), {"octet": uint8}, dataclassify=False)
    kind.__idl__.populate()
    kind.__idl__.fill_type_data()
    return kind


@cache
def _without_type_information(operations: int) -> ctypes.Array[ctypes.c_void_p]:
    """Return a copy of a type's table of functions without those for XTypes information."""
    table = (ctypes.c_void_p * _OPERATIONS).from_address(operations)
    return (ctypes.c_void_p * _OPERATIONS)(
        *(None if index in _TYPE_INFORMATION else function for index, function in enumerate(table))
    )


# Samples


def write(writer: int, payload: bytes, name: str) -> None:
    """Send a payload of CDR, padded to a multiple of 4 bytes; `name` is for errors."""
    result = _clayer.ddspy_write(writer, payload)
    if result < 0:
        checked(result, f"send a sample on {name}")


def take(reader: int) -> tuple[bytes, int, int] | None:
    """Return the oldest sample, the handle of its writer and its time of sending in ns; None without samples."""
    while True:
        taken: list[tuple[bytes, Any]] | int = _clayer.ddspy_take(reader, _ANY, 1)
        if not taken or isinstance(taken, int):
            return None
        ((payload, info),) = taken
        if info.valid_data:
            return payload, info.publication_handle, info.source_timestamp


class Endpoint(NamedTuple):
    """A writer or reader on the network, with the name of its DDS type, and the QoS and user data that it announces.

    Attributes:
        guid: 16 bytes that identify it.
        alive: whether it exists; if not, only the GUID and the handle are certain.
        handle: its number in this process; 0 in the result of a search by handle.
    """

    guid: bytes
    alive: bool
    topic: str
    type_name: str
    qos: QoSProfile
    user_data: bytes
    handle: int


def _endpoint(*described: Any) -> Endpoint:
    guid, _, _, topic, type_name, announced, info, _ = described
    handle = 0 if info is None else info.instance_handle
    if announced is None:
        return Endpoint(guid, False, "", "", QoSProfile(), b"", handle)
    qos, user_data = announced
    alive = info is None or info.instance_state == _ALIVE
    return Endpoint(guid, alive, topic, type_name, qos, user_data, handle)


def take_endpoints(reader: int) -> list[Endpoint]:
    """Return news of endpoints from a reader of a built-in topic."""
    return _take_all(lambda: _clayer.ddspy_take_endpoint(reader, _BATCH, _endpoint, read_qos))


def take_participants(reader: int) -> list[tuple[bytes, bool]]:
    """Return news of participants: (GUID, whether it exists)."""
    return _take_all(lambda: _clayer.ddspy_take_participant(reader, _BATCH, _participant, lambda _: None))


def _participant(guid: bytes, _: None, info: Any) -> tuple[bytes, bool]:
    return guid, info.instance_state == _ALIVE


def _take_all(take: Callable[[], list[T] | int]) -> list[T]:
    """Take batches until there are none, or an error."""
    items: list[T] = []
    while (batch := take()) and not isinstance(batch, int):
        items += batch
    return items


def matched_subscription(writer: int, handle: int) -> Endpoint | None:
    """Describe a reader by its handle; None if it is not connected to the writer."""
    described: Endpoint | None = _clayer.ddspy_get_matched_subscription_data(
        writer, handle, _endpoint, read_qos
    )
    return described


def matched_publication(reader: int, handle: int) -> Endpoint | None:
    """Describe a writer by its handle; None if it is not connected to the reader."""
    described: Endpoint | None = _clayer.ddspy_get_matched_publication_data(
        reader, handle, _endpoint, read_qos
    )
    return described
