"""Timers, as in `rclpy.timer`."""

from collections.abc import Callable

from sunset_ros.clock import Clock, ROSClock
from sunset_ros.rmw.core.node import NodeHandle
from sunset_ros.task import driven


class Timer:
    """Calls its callback periodically; made by `Node.create_timer`.

    Timers of a clock that follows `/clock` expire when a message on it says so, all others by the system's clock. The
    former begin to count when the time is known, that is with the first message on `/clock` that is not 0. Where it
    jumps, they act as in rcl: due after a jump forward, they call once and keep to their whole periods; after a
    jump to before their present period, or a switch of their clock, they begin a new period.
    """

    def __init__(
        self, node: NodeHandle, clock: Clock, callback: Callable[[], object], period_ns: int, label: str
    ) -> None:
        self.clock = clock
        self.callback = callback
        self._driven = driven(callback)
        self._node = node
        self._label = label
        self._period_ns = period_ns
        self._canceled = False
        self._posted = False
        self._follows = False  # /clock, which then rules in place of the middleware's timer
        self._began_ns = 0  # by /clock; 0 until the time is known
        self._due_ns = 0
        self._handle = node.create_timer(period_ns, self._driven, label)
        if isinstance(clock, ROSClock):
            clock.add_listener(self._on_time_set)
            self._on_time_set()

    def __repr__(self) -> str:
        return f"<Timer {self._label} every {self._period_ns} ns>"

    @property
    def timer_period_ns(self) -> int:
        """The period in nanoseconds; a new period holds from the next call on."""
        return self._period_ns

    @timer_period_ns.setter
    def timer_period_ns(self, value: int) -> None:
        self._period_ns = int(value)
        self._handle.set_period_ns(self._period_ns)

    def cancel(self) -> None:
        """Stop calling until `reset`."""
        self._canceled = True
        self._handle.cancel()

    def reset(self) -> None:
        """Start again: the next call is due after a period."""
        self._canceled = False
        if self._follows:
            self._begin()
            self._post_if_due()
        else:
            self._handle.reset()

    def is_canceled(self) -> bool:
        """Return whether it is stopped."""
        return self._canceled

    def is_ready(self) -> bool:
        """Return whether a call is due."""
        remaining = self.time_until_next_call()
        return remaining is not None and remaining <= 0

    def time_until_next_call(self) -> int | None:
        """Return the nanoseconds until the next call is due, negative if it is late; None if stopped."""
        if self._canceled:
            return None
        return (self._due_ns if self._follows else self._handle.due_ns) - self.clock.now_ns()

    def destroy(self) -> None:
        """Stop for good; prefer `Node.destroy_timer`."""
        self.cancel()
        if isinstance(self.clock, ROSClock):
            self.clock.remove_listener(self._on_time_set)
        self._handle.destroy()

    def _begin(self) -> None:
        """Begin a period by /clock; where it shows 0, the time is not known and the period begins once it is."""
        self._began_ns = self.clock.now_ns()
        self._due_ns = self._began_ns + self._period_ns

    def _on_time_set(self) -> None:
        follows = isinstance(self.clock, ROSClock) and self.clock.ros_time_is_active
        if follows is not self._follows:
            self._follows = follows
            self._handle.cancel()
            if not self._canceled:
                self.reset()
        elif follows and not 0 < self._began_ns <= self.clock.now_ns():
            self._begin()
        self._post_if_due()

    def _post_if_due(self) -> None:
        if self._is_due() and not self._posted:
            self._posted = True
            self._node.post(self._call_by_ros_time, self._label)

    def _is_due(self) -> bool:
        return self._follows and not self._canceled and self.clock.now_ns() >= self._due_ns

    def _call_by_ros_time(self) -> None:
        self._posted = False
        if not self._is_due():  # it may have been reset meanwhile
            return
        now = self.clock.now_ns()
        periods = (now - self._due_ns) // self._period_ns if self._period_ns else 0
        self._began_ns = now
        self._due_ns += (periods + 1) * self._period_ns
        self._driven()
