"""Times: the length of an experiment, the samples of a mean, the silence of a stopped topic."""

from collections import deque
from typing import Final

DURATION_S: Final = 20.0
"""The time that the paper measures [s]."""

PERIOD_S: Final = 0.1
"""Time between two frames of a flight [s]."""

SILENCE_S: Final = 1.0
"""A topic without a message for this time has stopped [s]."""

SAMPLES: Final = 5
"""The last samples of a signal, which its mean is over."""

GAP_S: Final = 1.0
"""A longer gap separates samples: a mean is over the samples after it [s]."""

_SECOND_NS: Final = 10**9


class Rate:
    """Counts the events of the last second, up to 1000."""

    def __init__(self) -> None:
        self._times: deque[int] = deque(maxlen=1000)
        self._last_ns = 0

    def note(self, now_ns: int) -> None:
        """Count an event."""
        self._times.append(now_ns)
        self._last_ns = now_ns

    def age_s(self, now_ns: int) -> float:
        """Return the time since the last event, to the millisecond [s]; there must be an event."""
        return round(max(0, now_ns - self._last_ns) / _SECOND_NS, 3)  # time may have been set back

    def frequency(self, now_ns: int) -> float:
        """Return the events in the second that ends now."""
        times = self._times
        while times and not now_ns - _SECOND_NS < times[0] <= now_ns:  # time may have been set back
            times.popleft()
        return float(len(times))


class MovingMean:
    """The mean of the last samples of a signal; after a gap, the previous mean until there are enough samples.

    Args:
        gap: a longer gap separates samples, in the unit of their times.
        samples: the number of samples of the mean.

    >>> mean = MovingMean(gap=1.0, samples=2)
    >>> [mean.add(time, value) for time, value in ((0.0, 1.0), (0.5, 2.0), (2.0, 5.0), (3.0, 6.0))]
    [None, 1.5, None, 5.5]
    >>> mean.value, mean.since
    (5.5, 2.0)
    """

    def __init__(self, gap: float, samples: int = SAMPLES) -> None:
        self._gap = gap
        self._samples: deque[tuple[float, float]] = deque(maxlen=samples)
        self.value: float | None = None
        """The mean; None until there are enough samples."""

    def add(self, time: float, value: float) -> float | None:
        """Add a sample, and return the mean that ends with it; None until there are enough without a gap."""
        if self._samples and time - self._samples[-1][0] > self._gap:
            self._samples.clear()
        self._samples.append((time, value))
        if len(self._samples) < (self._samples.maxlen or 0):
            return None
        self.value = sum(value for _, value in self._samples) / len(self._samples)
        return self.value

    @property
    def since(self) -> float:
        """The time of the mean's first sample."""
        return self._samples[0][0]
