"""Simulated timers and posted calls."""

from collections.abc import Callable

from sunset_ros.rmw.core.node import NodeHandle, Timer
from sunset_ros.rmw.sim._entity import SimEntity, SimHost
from sunset_ros.rmw.sim._scheduler import Priority


class SimTimer(Timer[SimHost], SimEntity):
    """A timer of virtual time."""

    _alarms = 0
    _expired = False

    def set_alarm(self, due_ns: int | None) -> None:
        self._expired = False
        self._alarms += 1
        if due_ns is not None:
            self.process.network.scheduler.add(due_ns, Priority.TIMER, self._expire, self._alarms)

    def _expire(self, alarm: int) -> None:
        if alarm == self._alarms:
            self._expired = True
            self.process.notify(self)

    def ready(self) -> bool:
        return self._expired


class SimPosted(SimEntity):
    """A posted call."""

    def __init__(self, process: SimHost, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        super().__init__(process, node, label)
        self._handler = handler
        self.join()

    def ready(self) -> bool:
        return self.alive

    def run(self) -> None:
        self.retire()
        self._handler()
