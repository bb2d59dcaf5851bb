"""Which failures show, as far as that can be known while repairs are under way."""

from collections import Counter, deque
from typing import Final

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import Configuration, Thresholds, Wiring, settings_without, view_setting
from sunset.system.vocabulary import Failure, Fault, Value, View, current_system, full_name

NEW_FRAMES_S: Final = 0.75
"""The time until a signal, a mean over 5 frames, is of new frames only, and is on the blackboard."""
PASSING_S: Final = 0.35
"""The time until a node's output can be seen: `_SILENT` periods at 10 Hz, and a blackboard."""
_SILENT: Final = 2.5
"""The age of the last message, in periods, from which on a topic is silent: two messages are missing, and half a period
is left for jitter. The period follows from the number of messages in most seconds."""
_DOUBTFUL: Final = 1.5
"""The age, in periods, from which on a topic may be silent: a message is missing."""
_JUMP: Final = 1 / 6
"""A jump: the rise of a signal within `NEW_FRAMES_S`, as a share of its threshold. The scene changes it by less."""


class Watch:
    """Says which failures show.

    - A topic is silent if its node gets all of its inputs and sends nothing; topics downstream are unknown then.
    - A signal counts when all of its frames are new. While a good value proves nothing, a jump shows the failure, too.

    Args:
        manager: the managing system, whose parameters are the thresholds.
        configuration: the settings of the managed system.
    """

    def __init__(self, manager: ManagingSystem, configuration: Configuration) -> None:
        self._manager = manager
        self._configuration = configuration
        self._thresholds = Thresholds(manager)
        self._nodes = {signal.name: signal.node for signal in current_system().signals.values()}
        self._wiring = Wiring()
        self._view, self._without = view_setting(), settings_without()
        self._views = {view.setting.value: view for view in current_system().views}
        self._symptoms = Symptoms({})
        self._rates: dict[str, Counter[float]] = {}  # topic → messages in a second → how often
        self._stopped: set[str] = set()
        self._repair_s: dict[str, float] = {}  # topic → when the repair of its node began
        self._asked_s: dict[str, float] = {}  # topic → when its node must have sent something
        self._clear_s: dict[str, float] = {}  # signal → when it is of new frames
        self._seen: dict[str, deque[tuple[float, float]]] = {}  # signal → its last values
        self._calm: dict[str, float] = {}  # signal that has jumped → the value to come back to
        self._set: Value | None = None

    def sees(self, fault: Fault, *, is_conclusive: bool = False) -> bool:
        """Return whether a fault can show with the sensors in use or, if `is_conclusive`, must show if present."""
        signal = current_system().failures[fault.failure].signal
        view = self._view_of(signal) if signal else None
        if view is None or fault.effect is None:
            return True
        return fault.effect.sensor in view.sensors and view.is_conclusive >= is_conclusive

    def _view_of(self, signal: str) -> View | None:
        """Return the view in use if it affects a signal; else None."""
        node, _ = self._view
        before = {self._wiring.publisher[topic] for topic in self._wiring.topics_until(self._nodes[signal])}
        return self._views.get(self._configuration.get(self._view)) if node in before else None

    def see(self, symptoms: Symptoms) -> None:
        """Note the symptoms of a moment."""
        self._symptoms = symptoms
        for topic in self._wiring.topics:
            frequency = symptoms.frequency(topic)
            if frequency > 0:
                self._rates.setdefault(topic, Counter())[frequency] += 1
        if self._set != self._configuration.get(self._view):
            self._set = self._configuration.get(self._view)
            self._clear_s = dict.fromkeys(self._nodes, self._manager.now_s + NEW_FRAMES_S)

    def is_away(self, topic: str) -> bool:
        """Return whether a topic's node boots, or has stopped and not yet regained half of its rate."""
        is_booting = self._wiring.publisher[topic] in self._configuration.booting
        if is_booting or self._symptoms.frequency(topic) >= self._usual(topic) / 2:
            self._stopped.discard(topic)
        elif self._symptoms.stopped(topic):
            self._stopped.add(topic)
        return is_booting or topic in self._stopped

    def begin_repair(self, topic: str) -> None:
        """Note that the repair of a topic's node begins."""
        self._repair_s[topic] = self._manager.now_s

    def is_back(self, failure: Failure) -> bool:
        """Return whether messages came on a failure's topic since the repair of its node began."""
        if not failure.topic:
            return False
        last_s = self._manager.now_s - self._symptoms.age(failure.topic)
        return last_s > self._repair_s.get(full_name(failure.topic), last_s)

    def end_repair(self, topic: str) -> None:
        """Note that the repair of a topic's node is over."""
        self._repair_s.pop(topic, None)

    def shows(self, failure: Failure) -> bool | None:
        """Return whether a failure shows; None if that is unknown now."""
        return self._is_silent(full_name(failure.topic)) if failure.topic else self._is_beyond(failure.signal)

    def badness(self, failure: Failure) -> float:
        """Return a failure's signal, negated if low is bad, so that less is better; 0 for a topic."""
        return 0.0 if failure.topic else self._thresholds.badness(failure.signal, self._symptoms)

    def _is_late(self, topic: str, periods: float) -> bool:
        return self._symptoms.age(topic) * self._usual(topic) > periods

    def _usual(self, topic: str) -> float:
        """Return the number of messages that a topic has in most seconds."""
        return self._rates[topic].most_common(1)[0][0] if topic in self._rates else 0.0

    def _is_silent(self, topic: str) -> bool | None:
        node = self._wiring.publisher[topic]
        if node in self._configuration.booting or any(map(self._lacks, self._wiring.topics_before(node))):
            self._asked_s[topic] = self._manager.now_s + PASSING_S
        is_asked = self._manager.now_s > self._asked_s.get(topic, 0.0)
        return self._is_late(topic, _SILENT) if is_asked else None

    def _is_beyond(self, name: str) -> bool | None:
        now_s = self._manager.now_s
        if any(map(self._lacks, self._wiring.topics_until(self._nodes[name]))):
            self._clear_s[name] = now_s + NEW_FRAMES_S
        if now_s < self._clear_s.get(name, 0.0):
            self._seen.pop(name, None)
            self._calm.pop(name, None)
            return None
        return self._thresholds.is_beyond(name, self._symptoms) or self._has_jumped(name)

    def _has_jumped(self, name: str) -> bool:
        """Return whether a signal whose good values prove nothing has jumped and not come back."""
        view = self._view_of(name)
        if view is None or view.is_conclusive:
            return False
        now_s, value = self._manager.now_s, self._thresholds.badness(name, self._symptoms)
        seen = self._seen.setdefault(name, deque())
        seen.append((now_s, value))
        while seen[0][0] < now_s - NEW_FRAMES_S:
            seen.popleft()
        limit = min(old for _, old in seen) + _JUMP * abs(self._thresholds.threshold(name))
        if value > limit:
            self._calm.setdefault(name, limit)
        if value <= self._calm.get(name, value):
            self._calm.pop(name, None)
        return name in self._calm

    def _lacks(self, topic: str) -> bool:
        """Return whether a topic may be silent while the pipeline needs it."""
        node = self._wiring.publisher[topic]
        is_away = (
            node in self._configuration.booting or topic in self._repair_s or self._is_late(topic, _DOUBTFUL)
        )
        setting, value = self._without.get(topic, (None, None))
        return is_away and (setting is None or self._configuration.get(setting) != value)
