"""Timers, as in `rclpy.timer`."""

from collections.abc import Callable
from typing import Any

from sunset.rmw.port import NodeHandle, TimerHandle
from sunset.ros._callbacks import driven
from sunset.ros.clock import Clock, ROSClock

__all__ = ["Timer"]


class Timer:
    """Calls its callback periodically; made by `Node.create_timer`.

    Timers of a clock that follows `/clock` expire when a message on it says so, all others by the system's clock.
    """

    def __init__(
        self, node: NodeHandle, clock: Clock, callback: Callable[[], Any], period_ns: int, label: str
    ) -> None:
        self.clock = clock
        self.callback = callback
        self._driven = driven(callback)
        self._node = node
        self._label = label
        self._period_ns = period_ns
        self._canceled = False
        self._posted = False
        self._due_ns: int | None = None  # by /clock; None while the system's clock rules
        self._handle: TimerHandle = node.create_timer(period_ns, self._driven, label)
        if isinstance(clock, ROSClock):
            clock.add_listener(self._on_time_set)
            self._on_time_set()

    def __repr__(self) -> str:
        return f"<Timer {self._label} every {self._period_ns} ns>"

    @property
    def timer_period_ns(self) -> int:
        """The period in nanoseconds; a new one holds from the next call on."""
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
        """Start again: the next call is due one period from now."""
        self._canceled = False
        if self._due_ns is None:
            self._handle.reset()
        else:
            self._due_ns = self.clock.now_ns() + self._period_ns
            self._post_if_due()

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
        return (self._handle.due_ns if self._due_ns is None else self._due_ns) - self.clock.now_ns()

    def destroy(self) -> None:
        """Stop for good; prefer `Node.destroy_timer`."""
        self.cancel()
        if isinstance(self.clock, ROSClock):
            self.clock.remove_listener(self._on_time_set)
        self._handle.destroy()

    def _on_time_set(self) -> None:
        if not (isinstance(self.clock, ROSClock) and self.clock.ros_time_is_active):
            if self._due_ns is not None:
                self._due_ns = None
                if not self._canceled:
                    self._handle.reset()
            return
        now = self.clock.now_ns()
        if self._due_ns is None or self._due_ns - now > self._period_ns:  # new to /clock, or it went back
            self._handle.cancel()
            self._due_ns = now + self._period_ns
        self._post_if_due()

    def _post_if_due(self) -> None:
        due = self._due_ns is not None and self.clock.now_ns() >= self._due_ns
        if due and not self._canceled and not self._posted:
            self._posted = True
            self._node.post(self._call_by_ros_time, self._label)

    def _call_by_ros_time(self) -> None:
        self._posted = False
        late = -1 if self._due_ns is None else self.clock.now_ns() - self._due_ns
        if self._canceled or self._due_ns is None or late < 0:  # it may have been reset meanwhile
            return
        periods = late // self._period_ns if self._period_ns else 0
        self._due_ns += (periods + 1) * self._period_ns
        self._driven()
