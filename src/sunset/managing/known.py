"""What the oracle is told of a run: the faults of its scenario, and when they heal by themselves."""

from dataclasses import dataclass
from typing import Final

from sunset.system.vocabulary import Adaptation, Fault, FaultKind, Value, described_faults


@dataclass(frozen=True, slots=True, kw_only=True)
class UnlistedFault:
    """A fault that the catalogue of the managing system's process does not list.

    Attributes:
        failure: the name of the failure that it shows as first.
        node: the node that it is injected into.
        parameter: the parameter that injects it.
        kind: where it lives.
        cures: each entry is a set of adaptations that cure it together.
    """

    failure: str
    node: str
    parameter: str
    kind: FaultKind
    cures: tuple[tuple[Adaptation, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownFault:
    """A fault of the scenario; times are in seconds after the measured time began.

    Attributes:
        name: a fault of the catalogue.
        value: its strength, as its parameter has it.
        at: when it comes; 0 if it follows another fault.
        follows: whether it follows another fault.
        until: when it heals by itself; None if it stays.
        rise: how long it grows [s]; 0 if all of it comes at once.
        on: how long it is there each time, if it comes and goes [s]; 0 if it does not.
        off: how long it is away after that [s].
        brings: whether another fault follows it.
        unlisted: what it is, if the catalogue does not list it.
    """

    name: str
    value: Value
    at: float = 0.0
    follows: bool = False
    until: float | None = None
    rise: float = 0.0
    on: float = 0.0
    off: float = 0.0
    brings: bool = False
    unlisted: UnlistedFault | None = None

    @property
    def fault(self) -> Fault:
        """What it is."""
        if self.unlisted is None:
            return described_faults()[self.name]
        one = self.unlisted
        return Fault(
            name=self.name,
            failure=one.failure,
            node=one.node,
            parameter=one.parameter,
            value=self.value,
            kind=one.kind,
            cures=one.cures,
            description="",
        )

    def strength(self, age_s: float) -> Value:
        """Return how strong it is so many seconds after it has come, in steps of a tenth of its growth."""
        if not self.rise or isinstance(self.value, bool | str):
            return self.value
        share = min(1.0, max(1, round(10 * age_s / self.rise)) / 10)
        return type(self.value)(self.value * share)

    def remaining_s(self, age_s: float, end_s: float) -> float:
        """Return for how many seconds it is still there, if it is not cured.

        Args:
            age_s: how long ago it came.
            end_s: seconds until it does not matter any more: it heals for good, or the run is over.
        """
        if not self.on or not self.off:
            return end_s
        period_s = self.on + self.off
        there = [
            max(0.0, min(begin + self.on, end_s) - max(begin, 0.0))
            for begin in (number * period_s - age_s % period_s for number in range(int(end_s / period_s) + 2))
        ]
        return sum(there)


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownScenario:
    """The scenario of a run.

    Attributes:
        faults: its faults.
        duration_s: how long is measured.
    """

    faults: tuple[KnownFault, ...] = ()
    duration_s: float = 20.0

    def find(self, name: str, time_s: float) -> KnownFault | None:
        """Return the fault of a name that came last, so many seconds after the measured time began.

        At a time that is not known (minus infinity), it is the first of that name.
        """
        faults = sorted((fault for fault in self.faults if fault.name == name), key=lambda fault: fault.at)
        return next(
            (fault for fault in reversed(faults) if fault.at <= time_s + _LATE_S), next(iter(faults), None)
        )

    def brings(self, time_s: float) -> bool:
        """Return whether a fault comes so many seconds after the measured time began, or within a frame of it."""
        return any(not fault.follows and abs(fault.at - time_s) < _FRAME_S for fault in self.faults)


_FRAME_S: Final = 0.1
_LATE_S: Final = 0.05
"""Tolerance when an injection time is compared with the plan."""
