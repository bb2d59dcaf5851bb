"""Which failures show, as far as that can be told while repairs are under way."""

from typing import Final

from sunset.managing.base import ManagingSystem
from sunset.managing.configuration import MODALITY, WITHOUT, Configuration
from sunset.managing.silence import Silence
from sunset.managing.symptoms import Symptoms
from sunset.managing.thresholds import Thresholds
from sunset.managing.wiring import Wiring
from sunset.system.vocabulary import Failure, Value, described_signals, full_name

NEW_FRAMES_S: Final = 0.75
"""After so long a signal is one of new frames only: a mean over 5 of them, reported and shown ten times a second."""
PASSING_S: Final = 0.35
"""After so long one sees whether a node passes on what it gets."""


class Watch:
    """Tells which failures show.

    - A topic is silent if its node gets all of its inputs and sends nothing; whatever is behind it is not asked.
    - A signal counts when it is one of new frames only.

    Args:
        manager: the managing system that watches; thresholds are its parameters.
        configuration: how the managed system is set.
    """

    def __init__(self, manager: ManagingSystem, configuration: Configuration) -> None:
        self._manager = manager
        self._configuration = configuration
        self._thresholds = Thresholds(manager)
        self._nodes = {signal.name: signal.node for signal in described_signals()}
        self._wiring = Wiring()
        self._silence = Silence(self._wiring.topics)
        self._symptoms = Symptoms({})
        self._repaired: set[str] = set()  # topics whose nodes are under repair
        self._asked_s: dict[str, float] = {}  # topic → from then on its node must have sent something
        self._clear_s: dict[str, float] = {}  # signal → from then on it is of new frames
        self._modality: Value | None = None

    def see(self, symptoms: Symptoms) -> None:
        """Take note of a moment."""
        self._symptoms = symptoms
        self._silence.see(symptoms)
        if self._modality != self._configuration.get(MODALITY):
            self._modality = self._configuration.get(MODALITY)
            self._clear_s = dict.fromkeys(self._nodes, self._manager.now_s + NEW_FRAMES_S)

    def begin_repair(self, topic: str) -> None:
        """Take note that a topic's node is repaired: only what it loses from now on counts."""
        self._silence.forgive(topic)
        self._repaired.add(topic)

    def is_back(self, failure: Failure) -> bool:
        """Return whether messages came on a failure's topic since the repair of its node began."""
        return bool(failure.topic) and self._silence.is_back(full_name(failure.topic))

    def end_repair(self, topic: str) -> None:
        """Take note that a topic's node is repaired no longer."""
        self._repaired.discard(topic)

    def shows(self, failure: Failure) -> bool | None:
        """Return whether a failure shows; None where that cannot be told now."""
        return self._is_silent(full_name(failure.topic)) if failure.topic else self._is_beyond(failure.signal)

    def badness(self, failure: Failure) -> float:
        """Return a failure's signal, negated if low is bad, so that less is better; 0 for a topic."""
        return 0.0 if failure.topic else self._thresholds.badness(failure.signal, self._symptoms)

    def _is_silent(self, topic: str) -> bool | None:
        node = self._wiring.publisher[topic]
        if node in self._configuration.booting or any(map(self._lacks, self._wiring.topics_before(node))):
            self._asked_s[topic] = self._manager.now_s + PASSING_S
            self._silence.forgive(topic)
        return self._silence.is_silent(topic) if self._manager.now_s > self._asked_s.get(topic, 0.0) else None

    def _is_beyond(self, name: str) -> bool | None:
        if any(map(self._lacks, self._wiring.topics_until(self._nodes[name]))):
            self._clear_s[name] = self._manager.now_s + NEW_FRAMES_S
        is_clear = self._manager.now_s >= self._clear_s.get(name, 0.0)
        return self._thresholds.is_beyond(name, self._symptoms) if is_clear else None

    def _lacks(self, topic: str) -> bool:
        """Return whether a topic may be silent, and the pipeline is not set to work without it."""
        node = self._wiring.publisher[topic]
        is_away = (
            node in self._configuration.booting
            or topic in self._repaired
            or self._silence.may_be_silent(topic)
        )
        setting, value = WITHOUT.get(topic, (None, None))
        return is_away and (setting is None or self._configuration.get(setting) != value)
