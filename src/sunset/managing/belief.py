"""How probable each fault of the catalogue is, after what was seen and done."""

from collections.abc import Collection, Iterable
from math import exp, prod
from typing import Final

_RARE: Final = 0.01
"""Probability of a fault without a symptom."""
_USUAL: Final = 0.1
"""Probability of each suspect of a symptom, before it is taken into account that one of them is there."""
_PLAUSIBLE: Final = 0.08
"""Suspects whose joint probability, before their symptom is taken into account, is below this are implausible."""
_EXCLUDED: Final = 0.002
_CERTAIN: Final = 0.97
_HEALED: Final = 0.25
"""Probability, in the long run, that a confirmed fault has healed."""
_FORGETTING_S: Final = 8.0
"""Time constant with which exclusions and confirmations decay, since a fault may come again or heal."""


class Belief:
    """The faults are independent of each other, but for a symptom: one of its suspects is there, or several.

    Args:
        faults: the names of all that there could be.

    >>> belief = Belief(["camera_driver_issue", "hardware_disconnect"])
    >>> belief.suspect("F1", ["camera_driver_issue", "hardware_disconnect"])
    >>> round(belief.probability("hardware_disconnect"), 2)
    0.53
    >>> belief.exclude(["camera_driver_issue"])  # for a restart was no help
    >>> round(belief.probability("hardware_disconnect"), 2)
    0.98
    """

    def __init__(self, faults: Iterable[str]) -> None:
        self._alone = dict.fromkeys(faults, _USUAL)
        self._suspects: dict[str, frozenset[str]] = {}
        self._healed: dict[str, float] = {}  # of what was confirmed

    def probability(self, fault: str) -> float:
        """Return how probable it is that a fault is there.

        Of a suspect it is what it would be alone, divided by the probability that any of the suspects is there.
        """
        alone = self._alone[fault]
        if self.is_certain(fault):
            return alone
        for suspects in self._suspects.values():
            if fault in suspects:
                return alone / (1 - prod(1 - self._alone[name] for name in sorted(suspects)))
        return min(alone, _RARE)

    def probability_of_any(self, faults: Iterable[str]) -> float:
        """Return how probable it is that at least one of some faults is there."""
        return 1 - prod(1 - self.probability(fault) for fault in faults)

    def suspect(self, failure: str, faults: Collection[str]) -> None:
        """Take a symptom of a failure into account, which at least one of some faults must have led to."""
        self._suspects[failure] = frozenset(faults)

    def is_plausible(self, faults: Iterable[str]) -> bool:
        """Return whether any of some faults may be there, since not all of them were excluded a moment ago."""
        return 1 - prod(1 - self._alone[fault] for fault in faults) > _PLAUSIBLE

    def settle(self, failure: str, faults: Iterable[str]) -> None:
        """Take into account that the symptom of a failure is gone; which of its faults comes next is open again."""
        self._suspects.pop(failure, None)
        self._alone |= {fault: _USUAL for fault in faults if not self.is_certain(fault)}

    def exclude(self, faults: Iterable[str]) -> None:
        """Take into account that faults are not there, or not any more."""
        self._alone |= dict.fromkeys(faults, _EXCLUDED)

    def confirm(self, fault: str) -> None:
        """Take into account that a fault is there, whether it shows or not, until it is excluded."""
        self._alone[fault] = _CERTAIN
        self._healed[fault] = 0.0

    def is_certain(self, fault: str) -> bool:
        """Return whether a fault was confirmed."""
        return self._alone[fault] >= _CERTAIN

    def probability_healed(self, fault: str) -> float:
        """Return how probable it is that a fault that was confirmed has healed since."""
        return self._healed.get(fault, 0.0)

    def forget(self, seconds: float) -> None:
        """Let time pass, in which faults may come that were excluded, and heal that were confirmed."""
        share = exp(-seconds / _FORGETTING_S)
        for fault, alone in self._alone.items():
            if alone < _USUAL:
                self._alone[fault] = _USUAL - (_USUAL - alone) * share
        for fault, healed in self._healed.items():
            self._healed[fault] = _HEALED - (_HEALED - healed) * share
