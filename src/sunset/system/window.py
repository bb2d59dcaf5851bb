"""Times: how long an experiment is, over which samples signals are averaged, when a topic has stopped."""

from collections import deque
from dataclasses import dataclass
from typing import Final

DURATION_S: Final = 20.0
"""How long the paper measures [s]."""

PERIOD_S: Final = 0.1
"""Time between two frames of a flight [s]."""

SILENCE_S: Final = 1.0
"""A topic without a message for so long has stopped [s]."""


@dataclass(frozen=True, slots=True)
class Window:
    """Over which samples a signal is averaged.

    Attributes:
        samples: how many; the last ones.
        gap_s: samples before a gap longer than this say nothing about those after it [s].
    """

    samples: int = 5
    gap_s: float = 1.0


_SECOND_NS: Final = 10**9
_MOST: Final = 1000
"""Events of a second that are counted."""

WINDOW: Final = Window()
"""The window of every signal."""


class Rate:
    """Counts the events of the last second, up to 1000."""

    def __init__(self) -> None:
        self._times: deque[int] = deque(maxlen=_MOST)
        self._last_ns = 0

    def note(self, now_ns: int) -> None:
        """Count an event."""
        self._times.append(now_ns)
        self._last_ns = now_ns

    def age_s(self, now_ns: int) -> float:
        """Return how long ago the last event was, to the millisecond [s]; there must have been one."""
        return round(max(0, now_ns - self._last_ns) / _SECOND_NS, 3)  # time may have been set back

    def frequency(self, now_ns: int) -> float:
        """Return the events in the second that ends now."""
        times = self._times
        while times and not now_ns - _SECOND_NS < times[0] <= now_ns:  # time may have been set back
            times.popleft()
        return float(len(times))


class MovingMean:
    """The mean of the last samples of a signal; after a gap, the one before it until there are enough new ones.

    Args:
        gap: samples before a gap longer than this say nothing about those after it, in the unit of their times.
        samples: over how many the mean is.

    >>> mean = MovingMean(gap=1.0, samples=2)
    >>> [mean.add(time, value) for time, value in ((0.0, 1.0), (0.5, 2.0), (2.0, 5.0), (3.0, 6.0))]
    [None, 1.5, None, 5.5]
    >>> mean.value, mean.since
    (5.5, 2.0)
    """

    def __init__(self, gap: float, samples: int = WINDOW.samples) -> None:
        self._gap = gap
        self._samples: deque[tuple[float, float]] = deque(maxlen=samples)
        self.value: float | None = None
        """The mean; None until there are enough samples."""

    def add(self, time: float, value: float) -> float | None:
        """Add a sample, and return the mean that it is the last one of; None until there are enough without a gap."""
        if self._samples and time - self._samples[-1][0] > self._gap:
            self._samples.clear()
        self._samples.append((time, value))
        if len(self._samples) < (self._samples.maxlen or 0):
            return None
        self.value = sum(value for _, value in self._samples) / len(self._samples)
        return self.value

    @property
    def since(self) -> float:
        """The time of the first sample that the mean is over."""
        return self._samples[0][0]
