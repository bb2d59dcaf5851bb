"""What the nodes of a process on DDS consist of: parts that read, timers, posted calls."""

from abc import abstractmethod
from collections.abc import Callable
from typing import TypeVar

from sunset.errors import InterfaceError
from sunset.interfaces import Message, deserialize
from sunset.rmw.core.node import NodeHandle
from sunset.rmw.core.timer import Timer
from sunset.rmw.dds import _library as dds
from sunset.rmw.dds import _wheel as wheel
from sunset.rmw.dds._host import DdsEndpoint, DdsEntity, DdsHost

MessageT = TypeVar("MessageT", bound=Message)


class ReadingEntity(DdsEndpoint):
    """A part with a DDS reader; samples wait in the reader, which drops the oldest beyond its depth."""

    __slots__ = ("_condition", "_number", "_reader")

    def listen_to(self, reader: int) -> None:
        """Get a turn whenever a reader has samples."""
        self._reader = reader
        self._condition = dds.data_condition(reader)
        self._number = self.process.number(self)
        self.join()
        self.process.link.watch(self._number, self._condition)

    def take_turn(self) -> bool:
        """Handle the oldest sample."""
        sample = wheel.take(self._reader)
        if sample is None:
            self.process.link.watch(self._number, self._condition)
            return False
        self.process.queue(self)  # there may be more, but it is others' turn
        payload, writer, _ = sample
        return self.handle(payload, writer)

    @abstractmethod
    def handle(self, payload: bytes, writer: int) -> bool:
        """Handle a sample.

        Args:
            payload: its CDR with the encapsulation header.
            writer: the handle of its writer.

        Returns:
            Whether a callback ran.
        """

    def decoded(self, payload: bytes, kind: type[MessageT], name: str) -> MessageT | None:
        """Return the message in a payload, or None, and report it, if it is malformed."""
        try:
            return deserialize(payload, kind)
        except InterfaceError as error:
            self.process.report(name, f"dropped a malformed message: {error}", self.node)
            return None

    def retire(self) -> None:
        """Take no more turns."""
        self.process.link.forget(self._number)
        self.process.forget_number(self._number)
        super().retire()


class DdsTimer(DdsEntity, Timer[DdsHost]):
    """A timer of the system's clock that no jump of that clock disturbs."""

    __slots__ = ()

    def set_alarm(self, due_ns: int | None) -> None:
        """Expire at `due_ns`, and not before; never if it is None."""
        if due_ns is None:
            self.process.alarms.pop(self, None)
        else:
            self.process.alarms[self] = due_ns

    def take_turn(self) -> bool:
        """Call the handler, unless it was called off or set anew meanwhile."""
        if self.canceled or self in self.process.alarms:
            return False
        self.process.call(self, self.run)
        return True


class DdsPosted(DdsEntity):
    """One call that a node asked for, on any thread."""

    __slots__ = ("_handler",)

    def __init__(self, process: DdsHost, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        super().__init__(process, node, label)
        self._handler = handler

    def take_turn(self) -> bool:
        """Call it, unless the node is gone."""
        if not self.node.alive:
            return False
        self.process.call(self, self._handler)
        return True
