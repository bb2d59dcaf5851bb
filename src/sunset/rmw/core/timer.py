"""Timers: when the next call is due, whatever the clock."""

from abc import abstractmethod
from collections.abc import Callable

from sunset.errors import MiddlewareError
from sunset.rmw.core.node import Entity, MiddlewareT_co, NodeHandle
from sunset.rmw.core.port import TimerHandle


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


class Timer(Entity[MiddlewareT_co], TimerHandle):
    """A timer by the clock of its process that never jumps; a middleware sets its alarm."""

    __slots__ = ("_canceled", "_due_ns", "_handler", "_period_ns")

    def __init__(
        self,
        process: MiddlewareT_co,
        node: NodeHandle,
        period_ns: int,
        handler: Callable[[], None],
        label: str,
    ) -> None:
        super().__init__(process, node, label)
        self.set_period_ns(period_ns)
        self._handler = handler
        self.reset()
        self.join()

    @abstractmethod
    def set_alarm(self, due_ns: int | None) -> None:
        """Expire at `due_ns` of the process's steady clock, and not before; never if it is None."""

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
        self._wait_until(self.process.steady_ns() + self._period_ns)

    def cancel(self) -> None:
        """Stop calling until `reset`."""
        self._canceled = True
        self.set_alarm(None)

    @property
    def canceled(self) -> bool:
        """Whether the timer is stopped."""
        return self._canceled

    @property
    def due_ns(self) -> int:
        """When the next call is due, by the system clock."""
        return self.process.now_ns() + self._due_ns - self.process.steady_ns()

    def run(self) -> None:
        """Call the handler, having set the next alarm."""
        self._wait_until(next_due_ns(self._due_ns, self._period_ns, self.process.steady_ns()))
        self._handler()

    def _wait_until(self, due_ns: int) -> None:
        self._due_ns = due_ns
        self.set_alarm(due_ns)

    def retire(self) -> None:
        """Stop for good."""
        self.cancel()
        super().retire()
