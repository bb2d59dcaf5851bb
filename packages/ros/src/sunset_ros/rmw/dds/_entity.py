"""Parts of nodes on DDS: readers, timers, posted calls."""

from abc import abstractmethod
from collections.abc import Callable
from typing import Generic, TypeVar

from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces import Message, Service
from sunset_ros.rmw.core.node import NodeHandle, Timer
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.dds import _library as dds
from sunset_ros.rmw.dds import _wheel as wheel
from sunset_ros.rmw.dds._host import DdsEndpoint, DdsEntity, DdsHost

TypeT = TypeVar("TypeT", Message, Service)


class ReadingEntity(DdsEndpoint, DdsEntity, Generic[TypeT]):
    """A part with a DDS reader; samples wait in the reader, which drops the oldest beyond its depth.

    Attributes:
        name: the name of its topic or service.
        place: that name in reports of malformed samples.
        handler: the handler of its user.
        reader: the DDS reader.
    """

    def __init__(
        self,
        process: DdsHost,
        node: NodeHandle,
        ros_type: type[TypeT],
        name: str,
        qos: QoSProfile,
        *,
        handler: Callable[..., None],
        label: str,
    ) -> None:
        super().__init__(process, node, label)
        self.name = self.place = name
        self.handler = handler
        self.open(ros_type, qos)

    @abstractmethod
    def open(self, ros_type: type[TypeT], qos: QoSProfile) -> None:
        """Make its DDS entities, and enter the graph by `listen_to`."""

    def listen_to(self, reader: int) -> None:
        """Take a turn whenever a reader has samples."""
        self.reader = reader
        self._condition = dds.data_condition(reader)
        self._number = self.process.number(self)
        self.join()
        self.process.link.waitset.watch(self._number, self._condition)

    def take_turn(self) -> bool:
        sample = wheel.take(self.reader)
        if sample is None:
            self.process.link.waitset.watch(self._number, self._condition)
            return False
        self.process.queue(self)  # other entities take their turn before its next sample
        payload, writer, _ = sample
        try:
            return self.handle(payload, writer)
        except InterfaceError as error:
            self.process.report(self.place, f"dropped a malformed message: {error}", self.node)
            return False

    @abstractmethod
    def handle(self, payload: bytes, writer: int) -> bool:
        """Handle the payload of a sample; return whether a callback ran."""

    def retire(self) -> None:
        self.process.link.waitset.forget(self._number)
        self.process.forget_number(self._number)
        super().retire()
        dds.delete(self.reader)


class DdsTimer(DdsEntity, Timer[DdsHost]):
    """A timer of the monotonic clock."""

    def set_alarm(self, due_ns: int | None) -> None:
        if due_ns is None:
            self.process.alarms.pop(self, None)
        else:
            self.process.alarms[self] = due_ns

    def take_turn(self) -> bool:
        if self.canceled or self in self.process.alarms:  # it was reset meanwhile
            return False
        self.process.call(self, self.run)
        return True


class DdsPosted(DdsEntity):
    """A posted call, from any thread."""

    def __init__(self, process: DdsHost, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        super().__init__(process, node, label)
        self._handler = handler

    def take_turn(self) -> bool:
        if not self.node.alive:
            return False
        self.process.call(self, self._handler)
        return True
