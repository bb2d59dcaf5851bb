"""Simulated timers, and work that a node posts to itself."""

from collections.abc import Callable

from sunset.rmw.core.node import NodeHandle
from sunset.rmw.core.timer import Timer
from sunset.rmw.sim._entity import SimEntity, SimHost
from sunset.rmw.sim._scheduler import Priority


class SimTimer(Timer[SimHost], SimEntity):
    """A timer of virtual time."""

    __slots__ = ("_alarms", "_expired")

    def __init__(
        self, process: SimHost, node: NodeHandle, period_ns: int, handler: Callable[[], None], label: str
    ) -> None:
        self._alarms = 0
        super().__init__(process, node, period_ns, handler, label)

    def set_alarm(self, due_ns: int | None) -> None:
        """Expire at `due_ns`, and not before; never if it is None."""
        self._expired = False
        self._alarms += 1
        if due_ns is not None:
            self.process.network.scheduler.add(due_ns, Priority.TIMER, self._expire, self._alarms)

    def _expire(self, alarm: int) -> None:
        if alarm == self._alarms:
            self._expired = True
            self.process.notify(self)

    def ready(self) -> bool:
        """Whether the timer has expired and was not called since."""
        return self._expired


class SimPosted(SimEntity):
    """One call that a node asked for."""

    __slots__ = ("_handler",)

    def __init__(self, process: SimHost, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        super().__init__(process, node, label)
        self._handler = handler
        self.join()

    def ready(self) -> bool:
        """Whether it has not been called."""
        return self.alive

    def run(self) -> None:
        """Call it, once."""
        self.retire()
        self._handler()
