"""Simulated timers, and work that a node posts to itself."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from sunset.errors import MiddlewareError
from sunset.rmw.core.port import TimerHandle
from sunset.rmw.sim._entity import Entity
from sunset.rmw.sim._scheduler import Priority

if TYPE_CHECKING:
    from sunset.rmw.sim._process import SimNode

__all__ = ["SimPosted", "SimTimer", "next_due_ns"]


def next_due_ns(due_ns: int, period_ns: int, now_ns: int) -> int:
    """Return when a timer is due after the call that was due at `due_ns` and starts at `now_ns`.

    It stays on the grid of whole periods and skips what has been missed.

    >>> next_due_ns(100, 100, 130), next_due_ns(100, 100, 430), next_due_ns(100, 100, 400)
    (200, 500, 400)
    """
    due_ns += period_ns
    if due_ns < now_ns:
        due_ns = now_ns if period_ns == 0 else due_ns + -(-(now_ns - due_ns) // period_ns) * period_ns
    return due_ns


class SimTimer(Entity, TimerHandle):
    """A timer of virtual time."""

    __slots__ = ("_canceled", "_due_ns", "_expired", "_generation", "_handler", "_period_ns")

    def __init__(self, node: "SimNode", period_ns: int, handler: Callable[[], None], label: str) -> None:
        super().__init__(node, label)
        self.set_period_ns(period_ns)
        self._handler = handler
        self._generation = 0
        self.reset()

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
        self._arm(self.node.network.scheduler.now + self._period_ns)

    def cancel(self) -> None:
        """Stop calling until `reset`."""
        self._canceled = True
        self._expired = False
        self._generation += 1

    @property
    def canceled(self) -> bool:
        """Whether the timer is stopped."""
        return self._canceled

    @property
    def due_ns(self) -> int:
        """When the next call is due."""
        return self._due_ns

    def _arm(self, due_ns: int) -> None:
        self._due_ns = due_ns
        self._expired = False
        self._generation += 1
        self.node.network.scheduler.add(due_ns, Priority.TIMER, self._expire, self._generation)

    def _expire(self, generation: int) -> None:
        if generation == self._generation:
            self._expired = True
            self.process.notify(self)

    def ready(self) -> bool:
        """Whether the timer has expired and was not called since."""
        return self._expired

    def run(self) -> None:
        """Call the handler, having set the next alarm."""
        self._arm(next_due_ns(self._due_ns, self._period_ns, self.node.network.scheduler.now))
        self._handler()

    def destroy(self) -> None:
        """Stop for good."""
        self.cancel()
        self.retire()


class SimPosted(Entity):
    """One call that a node asked for."""

    __slots__ = ("_handler",)

    def __init__(self, node: "SimNode", handler: Callable[[], None], label: str) -> None:
        super().__init__(node, label)
        self._handler = handler

    def ready(self) -> bool:
        """Whether it has not been called."""
        return self.alive

    def run(self) -> None:
        """Call it, once."""
        self.retire()
        self._handler()

    def destroy(self) -> None:
        """Do not call it."""
        self.retire()
