"""The scenario as the oracle gets it: the faults, and when they heal."""

from dataclasses import dataclass, fields
from typing import Final

from sunset.system.vocabulary import Adaptation, Fault, FaultKind, Value, described_faults


@dataclass(frozen=True, slots=True, kw_only=True)
class UnlistedFault:
    """A fault that the catalogue of the managing system's process does not list, as of `Fault`."""

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
        until: when it heals; None if it stays.
        rise: how long it grows [s].
        on: how long it is present each time, if it comes and goes [s]; else 0.
        off: how long it is away after that [s].
        brings: whether another fault follows it.
        unlisted: its description, if the catalogue does not list it.
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
        """Its description."""
        if self.unlisted is None:
            return described_faults()[self.name]
        described = {field.name: getattr(self.unlisted, field.name) for field in fields(self.unlisted)}
        return Fault(name=self.name, value=self.value, description="", **described)

    def strength(self, age_s: float) -> Value:
        """Return its strength `age_s` seconds after it has come, in steps of a tenth of its growth."""
        if not self.rise or isinstance(self.value, bool | str):
            return self.value
        share = min(1.0, max(1, round(10 * age_s / self.rise)) / 10)
        return type(self.value)(self.value * share)

    def remaining_s(self, age_s: float, end_s: float) -> float:
        """Return for how long it stays without a cure [s].

        Args:
            age_s: how long ago it came.
            end_s: seconds until it heals for good or the run ends.
        """
        if not self.on or not self.off:
            return end_s
        period_s = self.on + self.off
        begins = (number * period_s - age_s % period_s for number in range(int(end_s / period_s) + 2))
        return sum(max(0.0, min(begin + self.on, end_s) - max(begin, 0.0)) for begin in begins)


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownScenario:
    """The faults of a run, and the measured time."""

    faults: tuple[KnownFault, ...] = ()
    duration_s: float = 20.0

    def find(self, name: str, time_s: float) -> KnownFault | None:
        """Return the last fault of a name until a time of the measured time; the first if the time is unknown (-∞)."""
        faults = sorted((fault for fault in self.faults if fault.name == name), key=lambda fault: fault.at)
        past = [fault for fault in faults if fault.at <= time_s + _LATE_S]
        return next(iter([*past[::-1], *faults]), None)

    def brings(self, time_s: float) -> bool:
        """Return whether a fault comes at a time of the measured time, or within a frame of it."""
        return any(not fault.follows and abs(fault.at - time_s) < _FRAME_S for fault in self.faults)


_FRAME_S: Final = 0.1
_LATE_S: Final = 0.05
"""Tolerance of an injection time."""
