"""The messages of `service_msgs`, generated from their definitions."""

from struct import Struct
from types import MappingProxyType
from typing import Self

import numpy as np
import numpy.typing as npt

from sunset.common.errors import InterfaceError
from sunset.interfaces._check import *
from sunset.interfaces._codec import *
from sunset.interfaces._message import *
from sunset.interfaces._values import *
from sunset.interfaces.builtin_interfaces.msg import Time

__all__ = [
    "ServiceEventInfo",
]

_STRUCT_0 = Struct("<B")
_STRUCT_1 = Struct("<q")


class ServiceEventInfo(Message):
    """service_msgs/msg/ServiceEventInfo."""

    __slots__ = ('event_type', 'stamp', 'client_gid', 'sequence_number')
    __ros_name__ = "service_msgs/msg/ServiceEventInfo"
    __ros_fields__ = MappingProxyType({
        "event_type": "uint8",
        "stamp": "builtin_interfaces/Time",
        "client_gid": "uint8[16]",
        "sequence_number": "int64",
    })

    REQUEST_SENT = 0
    REQUEST_RECEIVED = 1
    RESPONSE_SENT = 2
    RESPONSE_RECEIVED = 3

    event_type: int
    stamp: Time
    client_gid: npt.NDArray[np.uint8]
    sequence_number: int

    def __init__(
        self,
        *,
        event_type: int = 0,
        stamp: Time | None = None,
        client_gid: npt.ArrayLike | None = None,
        sequence_number: int = 0,
    ) -> None:
        self.event_type = event_type
        self.stamp = Time() if stamp is None else stamp
        self.client_gid = zeros(UINT8, 16) if client_gid is None else array_of(client_gid, UINT8)
        self.sequence_number = sequence_number

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.event_type = self.event_type
            new.stamp = Time.copy(self.stamp)
            new.client_gid = frozen(self.client_gid, UINT8)
            new.sequence_number = self.sequence_number
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        out += _STRUCT_0.pack(
            self.event_type,
        )
        Time.encode_into(self.stamp, out)
        write_numbers(out, exactly(self.client_gid, 16), UINT8)
        out += PAD8[len(out) & 7]
        out += _STRUCT_1.pack(
            self.sequence_number,
        )

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (
            new.event_type,
        ) = _STRUCT_0.unpack_from(raw, position)
        position += 1
        new.stamp, position = Time.decode_from(raw, position)
        new.client_gid, position = read_numbers(raw, position, UINT8, 16)
        position = ((position + 3) & -8) + 4
        (
            new.sequence_number,
        ) = _STRUCT_1.unpack_from(raw, position)
        position += 8
        return new, position
