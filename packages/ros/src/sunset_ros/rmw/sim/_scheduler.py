"""A queue of events with a total order: time, then priority, then the order in which they were added."""

from collections.abc import Callable
from enum import IntEnum
from heapq import heappop, heappush
from itertools import count


class Priority(IntEnum):
    """Which of several events at the same time comes first."""

    PLAYBACK = -1  # a recorded request is served at its recorded time
    COMPLETION = 0  # a callback that ends sends its messages, and frees its process
    DELIVERY = 1
    TIMER = 2
    CALL = 3  # the experiment acts after all other events


class Scheduler:
    """Ordered events, and the time of the current event.

    Attributes:
        now: nanoseconds, starting at 0.
    """

    def __init__(self) -> None:
        self._events: list[tuple[int, int, int, Callable[..., object], object]] = []
        self._numbers = count()
        self.now = 0

    def add(self, time_ns: int, priority: int, action: Callable[..., object], argument: object) -> None:
        """Let `action(argument)` happen at `time_ns`, which is not in the past."""
        heappush(self._events, (time_ns, priority, next(self._numbers), action, argument))

    def run_until(self, time_ns: int) -> None:
        """Let all events until `time_ns` happen, and set the clock to it."""
        events = self._events
        while events and events[0][0] <= time_ns:
            self.now, _, _, action, argument = heappop(events)
            action(argument)
        self.now = max(self.now, time_ns)

    def run_while(self, predicate: Callable[[], bool], limit_ns: int | None) -> bool:
        """Let events happen while a predicate holds; it is evaluated before each event.

        Returns:
            Whether the predicate stopped holding. If not, the clock has reached the limit, or no events are left.
        """
        events = self._events
        while predicate():
            if not events or (limit_ns is not None and events[0][0] > limit_ns):
                if limit_ns is not None:
                    self.now = max(self.now, limit_ns)
                return not predicate()
            self.now, _, _, action, argument = heappop(events)
            action(argument)
        return True
