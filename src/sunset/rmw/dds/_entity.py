"""What the nodes of a process on DDS consist of: parts that read, timers, posted calls."""

from abc import abstractmethod
from collections.abc import Callable
from typing import Generic, TypeVar

from sunset.common.errors import InterfaceError
from sunset.interfaces import Message, Service
from sunset.rmw.core.node import NodeHandle, Timer
from sunset.rmw.core.qos import QoSProfile
from sunset.rmw.dds import _library as dds
from sunset.rmw.dds import _wheel as wheel
from sunset.rmw.dds._host import DdsEndpoint, DdsEntity, DdsHost

TypeT = TypeVar("TypeT", Message, Service)


class ReadingEntity(DdsEndpoint, DdsEntity, Generic[TypeT]):
    """A part with a DDS reader; samples wait in the reader, which drops the oldest beyond its depth.

    Attributes:
        name: of its topic or service.
        place: what reports of samples that cannot be used call that.
        handler: its user's.
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
        """Make what it consists of in DDS, and enter the graph by `listen_to`."""

    def listen_to(self, reader: int) -> None:
        """Get a turn whenever a reader has samples."""
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
        self.process.queue(self)  # there may be more, but it is others' turn
        payload, writer, _ = sample
        try:
            return self.handle(payload, writer)
        except InterfaceError as error:
            self.process.report(self.place, f"dropped a malformed message: {error}", self.node)
            return False

    @abstractmethod
    def handle(self, payload: bytes, writer: int) -> bool:
        """Handle a sample, which is CDR with its encapsulation header; return whether a callback ran.

        Raises:
            InterfaceError: it is malformed.
        """

    def retire(self) -> None:
        self.process.link.waitset.forget(self._number)
        self.process.forget_number(self._number)
        super().retire()
        dds.delete(self.reader)


class DdsTimer(DdsEntity, Timer[DdsHost]):
    """A timer of the system's clock that no jump of that clock disturbs."""

    def set_alarm(self, due_ns: int | None) -> None:
        if due_ns is None:
            self.process.alarms.pop(self, None)
        else:
            self.process.alarms[self] = due_ns

    def take_turn(self) -> bool:
        if self.canceled or self in self.process.alarms:  # it was set anew meanwhile
            return False
        self.process.call(self, self.run)
        return True


class DdsPosted(DdsEntity):
    """One call that a node asked for, on any thread."""

    def __init__(self, process: DdsHost, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        super().__init__(process, node, label)
        self._handler = handler

    def take_turn(self) -> bool:
        if not self.node.alive:
            return False
        self.process.call(self, self._handler)
        return True
