"""What the nodes of a process on DDS consist of: parts with callbacks, timers, posted calls."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from sunset.errors import InterfaceError, MiddlewareError
from sunset.interfaces import Message, deserialize
from sunset.rmw.core.port import TimerHandle
from sunset.rmw.dds import _library as dds
from sunset.rmw.dds import _wheel as wheel
from sunset.rmw.sim._timer import next_due_ns

if TYPE_CHECKING:
    from sunset.rmw.dds._node import DdsNode

__all__ = ["DdsPosted", "DdsTimer", "Entity", "MessageT", "ReadingEntity"]

MessageT = TypeVar("MessageT", bound=Message)


class Entity(ABC):
    """A part of a node.

    Attributes:
        node: its node.
        process: its node's process.
        label: names its callback in errors.
        alive: False once destroyed.
        readers: GUIDs of its DDS readers.
        writers: GUIDs of its DDS writers.
    """

    __slots__ = ("alive", "label", "node", "process", "readers", "writers")

    def __init__(self, node: "DdsNode", label: str) -> None:
        node.check_alive()
        self.node = node
        self.process = node.process
        self.label = label
        self.alive = True
        self.readers: tuple[bytes, ...] = ()
        self.writers: tuple[bytes, ...] = ()

    def join(self) -> None:
        """Become part of the node, now that everything is made."""
        self.node.entities[self] = None
        if self.readers or self.writers:
            self.process.announce()

    @abstractmethod
    def take_turn(self) -> bool:
        """Do one piece of what there is to do; return whether a callback ran."""

    def retire(self) -> None:
        """Take no more turns."""
        self.alive = False
        self.node.entities.pop(self, None)

    def destroy(self) -> None:
        """Leave the graph."""
        if self.alive:
            self.retire()
            if self.readers or self.writers:
                self.process.announce()

    def reliable_writers(self) -> tuple[int, ...]:
        """Return the DDS writers whose samples are to arrive before the process leaves."""
        return ()

    def settle(self) -> bool:
        """Send what waits for its receiver, if that is there by now; return whether nothing waits any more."""
        return True

    def check_alive(self, action: str) -> None:
        """Refuse to do something with what is destroyed.

        Raises:
            MiddlewareError: it is destroyed, or its process has ended.
        """
        if not self.alive:
            raise MiddlewareError(
                f"Node {self.node.fully_qualified_name} cannot {action}: it was destroyed, or its process has ended."
            )


class ReadingEntity(Entity):
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


class DdsTimer(Entity, TimerHandle):
    """A timer of the system's clock that no jump of that clock disturbs.

    Attributes:
        alarm_ns: when it expires, by the clock that never jumps; None once it has, or while it is canceled.
    """

    __slots__ = ("_canceled", "_due_ns", "_handler", "_period_ns", "alarm_ns")

    alarm_ns: int | None

    def __init__(self, node: "DdsNode", period_ns: int, handler: Callable[[], None], label: str) -> None:
        super().__init__(node, label)
        self.set_period_ns(period_ns)
        self._handler = handler
        self.reset()
        self.join()
        self.process.timers[self] = None

    def set_period_ns(self, period_ns: int) -> None:
        """Change the period from the next call on.

        Raises:
            MiddlewareError: it is negative.
        """
        if period_ns < 0:
            raise MiddlewareError(f"A timer's period must be at least 0 ns, got {period_ns}.")
        self._period_ns = period_ns

    def reset(self) -> None:
        """Start again: the next call is due one period from now."""
        self.check_alive("reset a timer")
        self._canceled = False
        self._due_ns = self.alarm_ns = self.process.steady_ns() + self._period_ns

    def cancel(self) -> None:
        """Stop calling until `reset`."""
        self._canceled = True
        self.alarm_ns = None

    @property
    def canceled(self) -> bool:
        """Whether the timer is stopped."""
        return self._canceled

    @property
    def due_ns(self) -> int:
        """When the next call is due, by the system clock."""
        return self.process.now_ns() + self._due_ns - self.process.steady_ns()

    def take_turn(self) -> bool:
        """Call the handler, having set the next alarm, unless it was called off or set anew meanwhile."""
        if self._canceled or self.alarm_ns is not None:
            return False
        self._due_ns = next_due_ns(self._due_ns, self._period_ns, self.process.steady_ns())
        self.alarm_ns = self._due_ns
        self.process.call(self, self._handler)
        return True

    def retire(self) -> None:
        """Stop for good."""
        self.cancel()
        self.process.timers.pop(self, None)
        super().retire()


class DdsPosted(Entity):
    """One call that a node asked for, on any thread."""

    __slots__ = ("_handler",)

    def __init__(self, node: "DdsNode", handler: Callable[[], None], label: str) -> None:
        super().__init__(node, label)
        self._handler = handler

    def take_turn(self) -> bool:
        """Call it, unless the node is gone."""
        if not self.process.has(self.node):
            return False
        self.process.call(self, self._handler)
        return True
