"""The thresholds of signals."""

import math
from typing import cast

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import FloatOrNaN, Symptoms
from sunset.system.vocabulary import described_signals


class Thresholds:
    """The thresholds of all signals; thresholds of the model's card are parameters of the managing system."""

    def __init__(self, manager: ManagingSystem) -> None:
        self._manager = manager
        self._signals = {signal.name: signal for signal in described_signals()}
        for signal in self._signals.values():
            if signal.calibrated and not manager.has_parameter(signal.threshold_name):
                manager.declare_parameter(signal.threshold_name, 0.0)

    def badness(self, name: str, symptoms: Symptoms) -> float:
        """Return a signal, negated if low is bad; NaN until it is measured."""
        value = symptoms.signal(name)
        return -value if self._signals[name].below else value

    def threshold(self, name: str) -> FloatOrNaN:
        """Return the threshold of a signal; NaN without a threshold."""
        signal = self._signals[name]
        if signal.calibrated:
            return cast("float", self._manager.get_parameter(signal.threshold_name).value)
        return math.nan if signal.threshold is None else signal.threshold

    def is_beyond(self, name: str, symptoms: Symptoms) -> bool:
        """Return whether a signal is on the wrong side of its threshold; False without a threshold."""
        return self._signals[name].is_beyond(symptoms.signal(name), self.threshold(name))
