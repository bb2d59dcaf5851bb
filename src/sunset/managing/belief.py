"""The probability of each fault of the catalogue."""

from collections.abc import Collection, Iterable
from math import exp, prod
from typing import Final

_RARE: Final = 0.01
"""Probability of a fault without a symptom."""
_USUAL: Final = 0.1
"""Prior probability of each suspect of a symptom."""
_PLAUSIBLE: Final = 0.08
"""The least joint prior probability of plausible suspects."""
_EXCLUDED: Final = 0.002
_CERTAIN: Final = 0.97
_HEALED: Final = 0.25
"""Probability, in the long run, that a confirmed fault has healed."""
_FORGETTING_S: Final = 8.0
"""Time constant with which exclusions and confirmations decay, since a fault may come again or heal."""


class Belief:
    """The probabilities of independent faults, at least one of which causes each symptom.

    Args:
        faults: the names of all possible faults.

    >>> belief = Belief(["camera_driver_issue", "hardware_disconnect"])
    >>> belief.suspect("F1", ["camera_driver_issue", "hardware_disconnect"])
    >>> round(belief.probability("hardware_disconnect"), 2)
    0.53
    >>> belief.exclude(["camera_driver_issue"])  # a restart did not help
    >>> round(belief.probability("hardware_disconnect"), 2)
    0.98
    """

    def __init__(self, faults: Iterable[str]) -> None:
        self._alone = dict.fromkeys(faults, _USUAL)
        self._suspects: dict[str, frozenset[str]] = {}
        self._healed: dict[str, float] = {}  # of confirmed faults

    def probability(self, fault: str) -> float:
        """Return the probability that a fault is present, for a suspect given that at least one suspect is."""
        alone = self._alone[fault]
        if self.is_certain(fault):
            return alone
        for suspects in self._suspects.values():
            if fault in suspects:
                return alone / (1 - prod(1 - self._alone[name] for name in sorted(suspects)))
        return min(alone, _RARE)

    def probability_of_any(self, faults: Iterable[str]) -> float:
        """Return the probability that at least one of some faults is present."""
        return 1 - prod(1 - self.probability(fault) for fault in faults)

    def suspect(self, failure: str, faults: Collection[str]) -> None:
        """Note a symptom of a failure, which at least one of some faults must cause."""
        self._suspects[failure] = frozenset(faults)

    def is_plausible(self, faults: Iterable[str]) -> bool:
        """Return whether some faults were not all excluded a moment ago."""
        return 1 - prod(1 - self._alone[fault] for fault in faults) > _PLAUSIBLE

    def settle(self, failure: str, faults: Iterable[str]) -> None:
        """Note that the symptom of a failure is gone; each of its faults may come next."""
        self._suspects.pop(failure, None)
        self._alone |= {fault: _USUAL for fault in faults if not self.is_certain(fault)}

    def exclude(self, faults: Iterable[str]) -> None:
        """Note that faults are not present, or not any more."""
        self._alone |= dict.fromkeys(faults, _EXCLUDED)

    def confirm(self, fault: str) -> None:
        """Note that a fault is present, whether it shows or not, until it is excluded."""
        self._alone[fault] = _CERTAIN
        self._healed[fault] = 0.0

    def is_certain(self, fault: str) -> bool:
        """Return whether a fault was confirmed."""
        return self._alone[fault] >= _CERTAIN

    def probability_healed(self, fault: str) -> float:
        """Return the probability that a confirmed fault has healed since."""
        return self._healed.get(fault, 0.0)

    def forget(self, seconds: float) -> None:
        """Let time pass: excluded faults may come, and confirmed faults may heal."""
        share = exp(-seconds / _FORGETTING_S)
        for fault, alone in self._alone.items():
            if alone < _USUAL:
                self._alone[fault] = _USUAL - (_USUAL - alone) * share
        for fault, healed in self._healed.items():
            self._healed[fault] = _HEALED - (_HEALED - healed) * share
