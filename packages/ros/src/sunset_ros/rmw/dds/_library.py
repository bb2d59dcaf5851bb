"""The public C functions of Cyclone DDS: entities are its numbers, errors are exceptions.

The library is part of the wheel `cyclonedds`. `_wheel` calls private functions of the wheel, so its version is pinned,
and checked here before the wheel is imported.
"""

import ctypes
from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError, version
from itertools import count
from typing import Final

from sunset_ros.errors import MiddlewareError, MissingExtraError
from sunset_ros.rmw.core.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

VERSION: Final = "11.0.1"


def check_version() -> None:
    """Raise a `MissingExtraError` if the wheel is not installed, or has another version."""
    try:
        installed = version("cyclonedds")
    except PackageNotFoundError:
        installed = "none"
    if installed != VERSION:
        raise MissingExtraError(
            f"The live middleware needs cyclonedds {VERSION}, found {installed}: "
            "pip install 'sunset-exemplar[live]', or 'sunset-ros[live]' for the client library alone."
        )


check_version()

from cyclonedds.internal import DDS  # noqa: E402  after the check

BUILTIN_TOPICS: Final = (0x7FFF0001, 0x7FFF0003, 0x7FFF0004)
"""The topics on which DDS announces participants, writers and readers."""

_FOREVER: Final = 2**63 - 1
_ANY: Final = 127  # samples in every state
_XCDR1: Final = ctypes.c_int16(0)
_IGNORE_PARTICIPANT: Final = 1
_MOST_PROCESSES: Final = 23
_FATAL, _ERROR, _WARNING = 1, 2, 4

_Entity, _Pointer, _Size, _Time = ctypes.c_int32, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int64
_Kind, _Number, _Handle = ctypes.c_int, ctypes.c_int32, ctypes.c_uint64

_SIGNATURES: Final[dict[str, tuple[object, ...]]] = {  # argument types, and the type of the result
    "dds_set_log_mask": (ctypes.c_uint32, None),
    "dds_create_domain": (ctypes.c_uint32, ctypes.c_char_p, _Entity),
    "dds_create_participant": (ctypes.c_uint32, _Pointer, _Pointer, _Entity),
    "dds_create_writer": (_Entity, _Entity, _Pointer, _Pointer, _Entity),
    "dds_create_reader": (_Entity, _Entity, _Pointer, _Pointer, _Entity),
    "dds_create_readcondition": (_Entity, ctypes.c_uint32, _Entity),
    "dds_create_guardcondition": (_Entity, _Entity),
    "dds_set_guardcondition": (_Entity, ctypes.c_bool, _Number),
    "dds_create_waitset": (_Entity, _Entity),
    "dds_waitset_attach": (_Entity, _Entity, ctypes.c_ssize_t, _Number),
    "dds_waitset_detach": (_Entity, _Entity, _Number),
    "dds_waitset_wait": (_Entity, _Pointer, _Size, _Time, _Number),
    "dds_delete": (_Entity, _Number),
    "dds_get_guid": (_Entity, _Pointer, _Number),
    "dds_get_instance_handle": (_Entity, _Pointer, _Number),
    "dds_get_entity_sertype": (_Entity, _Pointer, _Number),
    "dds_get_matched_publications": (_Entity, _Pointer, _Size, _Number),
    "dds_get_matched_subscriptions": (_Entity, _Pointer, _Size, _Number),
    "dds_wait_for_acks": (_Entity, _Time, _Number),
    "dds_strretcode": (_Number, ctypes.c_char_p),
    "dds_create_qos": (_Pointer,),
    "dds_delete_qos": (_Pointer, None),
    "dds_free": (_Pointer, None),
    "dds_qset_reliability": (_Pointer, _Kind, _Time, None),
    "dds_qset_durability": (_Pointer, _Kind, None),
    "dds_qset_history": (_Pointer, _Kind, _Number, None),
    "dds_qset_lifespan": (_Pointer, _Time, None),
    "dds_qset_writer_data_lifecycle": (_Pointer, ctypes.c_bool, None),
    "dds_qset_durability_service": (_Pointer, _Time, _Kind, _Number, _Number, _Number, _Number, None),
    "dds_qset_data_representation": (_Pointer, ctypes.c_uint32, _Pointer, None),
    "dds_qset_ignorelocal": (_Pointer, _Kind, None),
    "dds_qset_userdata": (_Pointer, ctypes.c_char_p, _Size, None),
    "dds_qget_reliability": (_Pointer, _Pointer, _Pointer, ctypes.c_bool),
    "dds_qget_durability": (_Pointer, _Pointer, ctypes.c_bool),
    "dds_qget_history": (_Pointer, _Pointer, _Pointer, ctypes.c_bool),
    "dds_qget_lifespan": (_Pointer, _Pointer, ctypes.c_bool),
    "dds_qget_userdata": (_Pointer, _Pointer, _Pointer, ctypes.c_bool),
}

_C = ctypes.CDLL(DDS._dll_handle._name)  # noqa: SLF001  a separate handle, for its own argument types
for _name, _types in _SIGNATURES.items():
    _function = getattr(_C, _name)
    _function.argtypes, _function.restype = list(_types[:-1]), _types[-1]


def checked(result: int, action: str) -> int:
    """Return a result of the library; raise a `MiddlewareError` if it is an error code."""
    if result < 0:
        reason = _C.dds_strretcode(result)
        raise MiddlewareError(f"DDS could not {action}: {reason.decode() if reason else result}.")
    return result


# Entities


def create_domain(domain_id: int, configuration: str) -> int:
    """Set up a domain, which must not exist in this process."""
    _C.dds_set_log_mask(_FATAL | _ERROR | _WARNING)
    domain: int = _C.dds_create_domain(domain_id, configuration.encode())
    _C.dds_set_log_mask(_FATAL | _ERROR)  # there is a warning for each malformed packet
    if domain < 0:
        raise MiddlewareError(
            f"DDS could not set up domain {domain_id}: either CYCLONEDDS_URI is wrong, or {_MOST_PROCESSES} "
            "processes of this library are in the domain on this computer already; stderr has the cause."
        )
    return domain


def create_participant(domain_id: int, user_data: bytes) -> int:
    """Enter a domain."""
    qos = _C.dds_create_qos()
    _C.dds_qset_userdata(qos, user_data, len(user_data))
    participant = _C.dds_create_participant(domain_id, qos, None)
    _C.dds_delete_qos(qos)
    return checked(participant, f"enter domain {domain_id}")


def create_writer(participant: int, topic: int, qos: QoSProfile, user_data: bytes = b"") -> int:
    """Make a writer with the announcements of a ROS 2 node."""
    settings = _announced(qos, user_data)
    _C.dds_qset_writer_data_lifecycle(settings, False)
    writer = _C.dds_create_writer(participant, topic, settings, None)
    _C.dds_delete_qos(settings)
    return checked(writer, "make a writer")


def create_reader(
    participant: int, topic: int, qos: QoSProfile | None, user_data: bytes = b"", *, ignore_own: bool = False
) -> int:
    """Make a reader with the announcements of a ROS 2 node; for a built-in topic, without QoS."""
    settings = None if qos is None else _announced(qos, user_data)
    if ignore_own:
        _C.dds_qset_ignorelocal(settings, _IGNORE_PARTICIPANT)
    reader = _C.dds_create_reader(participant, topic, settings, None)
    if settings is not None:
        _C.dds_delete_qos(settings)
    return checked(reader, "make a reader")


def delete(entity: int) -> None:
    """Delete an entity and its children, if it still exists."""
    _C.dds_delete(entity)


def guid_of(entity: int) -> bytes:
    """Return the 16 bytes that identify a participant, writer or reader on the network."""
    guid = ctypes.create_string_buffer(16)
    checked(_C.dds_get_guid(entity, guid), "read a GUID")
    return guid.raw


def instance_handle_of(entity: int) -> int:
    """Return the 64-bit number by which this process knows an entity."""
    handle = _Handle()
    checked(_C.dds_get_instance_handle(entity, ctypes.byref(handle)), "read an instance handle")
    return handle.value


def sertype_of(topic: int) -> int:
    """Return the address of the C structure of a topic's type."""
    address = _Pointer()
    checked(_C.dds_get_entity_sertype(topic, ctypes.byref(address)), "look at a topic's type")
    return address.value or 0


# Quality of service


def _announced(qos: QoSProfile, user_data: bytes) -> object:
    settings = _C.dds_create_qos()
    keep_all = qos.history is HistoryPolicy.KEEP_ALL
    depth = -1 if keep_all else qos.depth
    _C.dds_qset_reliability(settings, qos.reliability is ReliabilityPolicy.RELIABLE, _FOREVER)
    _C.dds_qset_history(settings, keep_all, depth)
    if qos.durability is DurabilityPolicy.TRANSIENT_LOCAL:
        _C.dds_qset_durability(settings, 1)
        _C.dds_qset_durability_service(settings, 0, keep_all, depth, -1, -1, -1)
    if qos.lifespan_ns is not None:
        _C.dds_qset_lifespan(settings, qos.lifespan_ns)
    _C.dds_qset_data_representation(settings, 1, ctypes.byref(_XCDR1))
    _C.dds_qset_userdata(settings, user_data, len(user_data))
    return settings


def read_qos(settings: int) -> tuple[QoSProfile, bytes]:
    """Return the QoS that an endpoint announces, and its user data."""
    kind, depth, duration, size = _Kind(), _Number(), _Time(_FOREVER), _Size()
    data = _Pointer()
    _C.dds_qget_reliability(settings, ctypes.byref(kind), None)
    reliable = kind.value
    kind.value = 0
    _C.dds_qget_durability(settings, ctypes.byref(kind))
    durable = kind.value
    kind.value = 0
    _C.dds_qget_history(settings, ctypes.byref(kind), ctypes.byref(depth))
    _C.dds_qget_lifespan(settings, ctypes.byref(duration))
    user_data = b""
    if _C.dds_qget_userdata(settings, ctypes.byref(data), ctypes.byref(size)) and data.value:
        user_data = ctypes.string_at(data.value, size.value)
        _C.dds_free(data)
    return QoSProfile(
        depth=max(1, depth.value),
        history=HistoryPolicy.KEEP_ALL if kind.value else HistoryPolicy.KEEP_LAST,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if durable else DurabilityPolicy.VOLATILE,
        lifespan_ns=None if duration.value == _FOREVER else duration.value,
    ), user_data


# Connections


def matched_subscriptions(writer: int) -> Sequence[int]:
    """Return the handles of the readers that are connected to a writer."""
    return _handles(_C.dds_get_matched_subscriptions, writer)


def matched_publications(reader: int) -> Sequence[int]:
    """Return the handles of the writers that are connected to a reader."""
    return _handles(_C.dds_get_matched_publications, reader)


def _handles(function: Callable[..., int], entity: int) -> Sequence[int]:
    room = function(entity, None, 0)
    if room <= 0:
        return ()
    handles = (_Handle * room)()
    return handles[: max(0, min(room, function(entity, handles, room)))]


def wait_for_acks(writer: int, timeout_ns: int) -> None:
    """Wait until all connected readers have confirmed the samples of a reliable writer, or time is over."""
    _C.dds_wait_for_acks(writer, timeout_ns)


class WaitSet:
    """Waits until a reader has samples, whose number it returns; a reader is watched once."""

    def __init__(self, participant: int) -> None:
        self._set = checked(_C.dds_create_waitset(participant), "make a waitset")
        self._guard = checked(_C.dds_create_guardcondition(participant), "make a condition")
        self._room = (ctypes.c_ssize_t * 64)()
        self._numbers = count(1)
        self._conditions = {0: self._guard}
        self.watch(0)

    def add(self, reader: int) -> int:
        """Return a new number for a reader, which is not watched yet."""
        number = next(self._numbers)
        self._conditions[number] = checked(_C.dds_create_readcondition(reader, _ANY), "make a condition")
        return number

    def watch(self, number: int) -> None:
        """Watch a reader until it has samples."""
        checked(_C.dds_waitset_attach(self._set, self._conditions[number], number), "watch a condition")

    def forget(self, number: int) -> None:
        """Stop watching a reader for good."""
        _C.dds_waitset_detach(self._set, self._conditions.pop(number))

    def wait(self) -> list[int]:
        """Return the numbers of readers that have samples; none after `close`."""
        numbers: list[int] = []
        while not numbers:
            found = _C.dds_waitset_wait(self._set, self._room, len(self._room), _FOREVER)
            numbers = self._room[: min(checked(found, "wait for samples"), len(self._room))]
        if 0 in numbers:
            return []
        for number in numbers:
            _C.dds_waitset_detach(self._set, self._conditions.get(number, 0))
        return numbers

    def close(self) -> None:
        """Make `wait` return no numbers from now on."""
        _C.dds_set_guardcondition(self._guard, True)
