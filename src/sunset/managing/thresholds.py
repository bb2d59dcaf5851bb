"""Which signals are beyond their thresholds."""

from typing import cast

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.system.vocabulary import described_signals


class Thresholds:
    """The thresholds of all signals; those of the model's card are parameters of every managing system.

    Args:
        manager: whose parameters they are.
    """

    def __init__(self, manager: ManagingSystem) -> None:
        self._manager = manager
        self._signals = {signal.name: signal for signal in described_signals()}
        for signal in self._signals.values():
            if signal.calibrated and not manager.has_parameter(signal.threshold_name):
                manager.declare_parameter(signal.threshold_name, 0.0)

    def badness(self, name: str, symptoms: Symptoms) -> float:
        """Return a signal, such that less is better; NaN until it is measured."""
        value = symptoms.signal(name)
        return -value if self._signals[name].below else value

    def is_beyond(self, name: str, symptoms: Symptoms) -> bool:
        """Return whether a signal is on the wrong side of its threshold; False where it has none."""
        signal, value = self._signals[name], symptoms.signal(name)
        threshold = signal.threshold
        if signal.calibrated:
            threshold = cast("float", self._manager.get_parameter(signal.threshold_name).value)
        return threshold is not None and signal.is_beyond(value, threshold)
