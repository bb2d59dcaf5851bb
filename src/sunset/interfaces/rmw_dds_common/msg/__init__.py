"""The messages of `rmw_dds_common`, generated from their definitions."""

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

__all__ = [
    "Gid",
    "NodeEntitiesInfo",
    "ParticipantEntitiesInfo",
]


class Gid(Message):
    """rmw_dds_common/msg/Gid."""

    __slots__ = ('data',)
    __ros_name__ = "rmw_dds_common/msg/Gid"
    __ros_fields__ = MappingProxyType({
        "data": "uint8[16]",
    })

    data: npt.NDArray[np.uint8]

    def __init__(
        self,
        *,
        data: npt.ArrayLike | None = None,
    ) -> None:
        self.data = zeros(UINT8, 16) if data is None else array_of(data, UINT8)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.data = frozen(self.data, UINT8)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        write_numbers(out, exactly(self.data, 16), UINT8)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.data, position = read_numbers(raw, position, UINT8, 16)
        return new, position


class NodeEntitiesInfo(Message):
    """rmw_dds_common/msg/NodeEntitiesInfo."""

    __slots__ = ('node_namespace', 'node_name', 'reader_gid_seq', 'writer_gid_seq')
    __ros_name__ = "rmw_dds_common/msg/NodeEntitiesInfo"
    __ros_fields__ = MappingProxyType({
        "node_namespace": "string<=256",
        "node_name": "string<=256",
        "reader_gid_seq": "rmw_dds_common/Gid[]",
        "writer_gid_seq": "rmw_dds_common/Gid[]",
    })

    node_namespace: str
    node_name: str
    reader_gid_seq: list[Gid]
    writer_gid_seq: list[Gid]

    def __init__(
        self,
        *,
        node_namespace: str = "",
        node_name: str = "",
        reader_gid_seq: list[Gid] | None = None,
        writer_gid_seq: list[Gid] | None = None,
    ) -> None:
        self.node_namespace = node_namespace
        self.node_name = node_name
        self.reader_gid_seq = [] if reader_gid_seq is None else reader_gid_seq
        self.writer_gid_seq = [] if writer_gid_seq is None else writer_gid_seq

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.node_namespace = self.node_namespace
            new.node_name = self.node_name
            new.reader_gid_seq = [Gid.copy(item) for item in self.reader_gid_seq]
            new.writer_gid_seq = [Gid.copy(item) for item in self.writer_gid_seq]
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        write_string(out, self.node_namespace, 256)
        write_string(out, self.node_name, 256)
        if len(self.reader_gid_seq) or len(self.writer_gid_seq):
            write_size(out, len(self.reader_gid_seq))
            write_messages(out, self.reader_gid_seq, Gid)
            write_size(out, len(self.writer_gid_seq))
            write_messages(out, self.writer_gid_seq, Gid)
        else:
            out += PAD4[len(out) & 3] + b"\0" * 8

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.node_namespace, position = read_string(raw, position)
        new.node_name, position = read_string(raw, position)
        position = (position + 3) & -4
        if raw.startswith(b"\0" * 8, position):
            new.reader_gid_seq = []
            new.writer_gid_seq = []
            position += 8
        else:
            size, position = read_size(raw, position)
            new.reader_gid_seq, position = read_messages(raw, position, size, Gid)
            size, position = read_size(raw, position)
            new.writer_gid_seq, position = read_messages(raw, position, size, Gid)
        return new, position


class ParticipantEntitiesInfo(Message):
    """rmw_dds_common/msg/ParticipantEntitiesInfo."""

    __slots__ = ('gid', 'node_entities_info_seq')
    __ros_name__ = "rmw_dds_common/msg/ParticipantEntitiesInfo"
    __ros_fields__ = MappingProxyType({
        "gid": "rmw_dds_common/Gid",
        "node_entities_info_seq": "rmw_dds_common/NodeEntitiesInfo[]",
    })

    gid: Gid
    node_entities_info_seq: list[NodeEntitiesInfo]

    def __init__(
        self,
        *,
        gid: Gid | None = None,
        node_entities_info_seq: list[NodeEntitiesInfo] | None = None,
    ) -> None:
        self.gid = Gid() if gid is None else gid
        self.node_entities_info_seq = [] if node_entities_info_seq is None else node_entities_info_seq

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.gid = Gid.copy(self.gid)
            new.node_entities_info_seq = [NodeEntitiesInfo.copy(item) for item in self.node_entities_info_seq]
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Gid.encode_into(self.gid, out)
        write_size(out, len(self.node_entities_info_seq))
        write_messages(out, self.node_entities_info_seq, NodeEntitiesInfo)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.gid, position = Gid.decode_from(raw, position)
        size, position = read_size(raw, position)
        new.node_entities_info_seq, position = read_messages(raw, position, size, NodeEntitiesInfo)
        return new, position
