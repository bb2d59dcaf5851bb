"""Which topics have fallen silent, seen before a second without messages is over."""

from typing import Final

from sunset.managing.symptoms import Symptoms

_LOST: Final = 0.35
"""A topic is silent when its frequency, over the last second, has fallen by this share without a rise in between."""
_DOUBTFUL: Final = 0.15
"""From this share on it may be."""


class Silence:
    """Watches how the frequencies of topics fall.

    A frequency is the messages of the last second. While none come, it falls by a tenth every tenth of a second, long
    before it is 0. After a repair it may stay low for a second, but it does not fall.

    Args:
        topics: names of topics.
    """

    def __init__(self, topics: tuple[str, ...]) -> None:
        self._topics = topics
        self._last: dict[str, float] = {}
        self._before: dict[str, float] = {}  # its fall
        self._most: dict[str, float] = {}
        self._risen: set[str] = set()

    def see(self, symptoms: Symptoms) -> None:
        """Take note of the frequencies of a moment; what was never heard of has none."""
        for topic in self._topics:
            frequency = symptoms.frequency(topic)
            if frequency >= 0:
                if frequency > self._last.get(topic, -1.0):
                    self._before[topic] = frequency
                    self._risen.add(topic)
                self._most[topic] = max(frequency, self._most.get(topic, 0.0))
                self._last[topic] = frequency

    def forgive(self, topic: str) -> None:
        """Forget a topic's history, since its node was repaired: only messages that it lacks from now on count."""
        self._before[topic] = self._last.get(topic, 0.0)
        self._risen.discard(topic)

    def is_back(self, topic: str) -> bool:
        """Return whether messages have certainly come since a topic's history was forgotten."""
        return topic in self._risen

    def is_silent(self, topic: str) -> bool:
        """Return whether a topic that once had messages has none now."""
        return self._has_lost(topic, _LOST)

    def may_be_silent(self, topic: str) -> bool:
        """Return whether a topic may have fallen silent just now."""
        return self._has_lost(topic, _DOUBTFUL)

    def _has_lost(self, topic: str, share: float) -> bool:
        if topic not in self._last:
            return False
        lost = self._before[topic] - self._last[topic]
        return self._last[topic] == 0 or lost > share * self._most[topic]
