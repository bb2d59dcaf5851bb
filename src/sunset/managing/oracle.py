"""A managing system that gets the scenario: the reference for perfect knowledge."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from sunset.errors import ManagerError
from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import Configuration, Setting, settings_of, settings_without, strengths_of
from sunset.system.vocabulary import (
    FAULT_ENDS_TOPIC,
    INJECTIONS_TOPIC,
    PERIOD_S,
    Adaptation,
    AdaptationKind,
    FaultKind,
    Value,
    current_system,
    full_name,
)
from sunset.system_interfaces.msg import FaultEnd, FaultInjection
from sunset_ros.interfaces.stamps import ns_of

ORACLE: Final = "oracle"
"""The name of the managing system to which the harness gives the scenario."""

_RESTART_S: Final = 0.1
"""Seconds without output during a restart."""
_LATE_S: Final = 0.05
"""Tolerance of an injection time."""
_RETRY_S: Final = 1.0
"""Time after which a request without effect is repeated."""
_TOLERABLE: Final[Mapping[str, float]] = {"depth_degradation": 0.18}
"""Fault → the strength up to which its cure costs more than the fault: with less noise, the fusion is better than the
colour image alone (`sunset models curves lite`)."""
_UNSEGMENTED: Final = 0.5
"""The share of output that a degradation costs: the paper's severities are from a tenth to 70 %."""

Cure = tuple[Adaptation, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownFault:
    """A fault of the scenario, listed or not; times are in seconds after the measured time began.

    Attributes:
        name: its name.
        failure: as in `Fault`, like `kind` and `cures`.
        value: its strength, as its parameter has it.
        at: when it comes; 0 if it follows another fault.
        follows: whether it follows another fault.
        until: when it heals; None if it stays.
        rise: how long it grows [s].
        on: how long it is present each time, if it comes and goes [s]; else 0.
        off: how long it is away after that [s].
        brings: whether another fault follows it.
    """

    name: str
    failure: str
    kind: FaultKind
    cures: tuple[Cure, ...]
    value: Value
    at: float = 0.0
    follows: bool = False
    until: float | None = None
    rise: float = 0.0
    on: float = 0.0
    off: float = 0.0
    brings: bool = False

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
        return any(not fault.follows and abs(fault.at - time_s) < PERIOD_S for fault in self.faults)


@dataclass(eq=False)
class _Present:
    known: KnownFault
    since_s: float
    tried_s: float = -_RETRY_S


class Oracle(ManagingSystem):
    """Knows the scenario and each fault's beginning and end, and applies the best known cures; the reference.

    - The cheapest cure of a fault comes first. A redeploy cures all faults inside a node.
    - It waits for a fault to heal if a cure would cost more of the output.
    - While the camera is away or boots, the fusion takes the depth image alone, and vice versa.
    - The workaround of an external fault is undone after the fault. The enhancement undoes the degradation's strength.
    - Its diagnosis is the truth.

    Args:
        scenario: the scenario of the run, which the harness gives to this class only.
        options: as in `ManagingSystem`.

    Raises:
        ManagerError: there is no scenario.
    """

    def __init__(self, *, scenario: KnownScenario | None = None, **options: Any) -> None:
        if scenario is None:
            raise ManagerError(
                f"The managing system {ORACLE} must be told the scenario, which only a run with --manager {ORACLE} "
                "does: choose another managing system here."
            )
        self.scenario = scenario
        super().__init__(**options)

    def on_start(self) -> None:
        """Subscribe to the beginnings and ends of faults."""
        self.present: dict[str, _Present] = {}
        self.configuration = Configuration(self)
        self.start_s = math.inf  # when the measured time began, known from the first fault
        self.symptoms = Symptoms({})
        self.create_subscription(FaultInjection, INJECTIONS_TOPIC, self.on_injection, 100)
        self.create_subscription(FaultEnd, FAULT_ENDS_TOPIC, self.on_end, 100)

    def on_injection(self, injection: FaultInjection) -> None:
        """Note a fault that has come, and react at once."""
        onset_s = ns_of(injection.stamp) / 1e9
        known = self.scenario.find(injection.fault, onset_s - self.start_s)
        if known is None or not injection.confirmed:
            return
        if not known.follows:
            self.start_s = min(self.start_s, onset_s - known.at)
        self.present[injection.fault] = _Present(known, onset_s)
        self.diagnose(dict.fromkeys(self.present, 1.0))
        self.adapt(self.symptoms)

    def on_end(self, end: FaultEnd) -> None:
        """Note a fault that is over."""
        self.present.pop(end.fault, None)
        self.diagnose(dict.fromkeys(self.present, 1.0))
        # a fault that comes at the same time may need the present settings
        if not self.scenario.brings(self.now_s - self.start_s):
            self.adapt(self.symptoms)

    def adapt(self, symptoms: Symptoms) -> None:
        """Cure the present faults, or work around them."""
        self.symptoms = symptoms
        self.configuration.see(symptoms)
        cures = {name: self.best_cure(present) for name, present in self.present.items()}
        redeploys = {cure for cure in cures.values() if _kind(cure) is AdaptationKind.REDEPLOY}
        wanted: dict[Setting, Value] = {}
        for name, cure in cures.items():
            present = self.present[name]
            settings = settings_of(cure) if present.known.kind is FaultKind.EXTERNAL else None
            if settings is not None:
                fault = current_system().faults.get(name)
                strengths = strengths_of(fault) if fault and cure in fault.cures[:1] else ()
                wanted |= settings | dict.fromkeys(strengths, self.strength(present))
            elif cure and (cure in redeploys or not redeploys.intersection(present.known.cures)):
                self.do(present, cure)
        self.configuration.want(wanted | self.workarounds(cures), symptoms)

    def best_cure(self, present: _Present) -> Cure:
        """Return the cheapest cure of a fault; empty if it costs more than the fault."""
        end_s = self.start_s + self.scenario.duration_s - self.now_s
        if present.known.until is not None:
            end_s = min(end_s, self.start_s + present.known.until - self.now_s)
        remaining_s = present.known.remaining_s(self.now_s - present.since_s, max(0.0, end_s))
        strength = self.strength(present)
        if isinstance(strength, float) and strength < _TOLERABLE.get(present.known.name, 0.0):
            return ()
        share = 1.0 if current_system().failures[present.known.failure].topic else _UNSEGMENTED
        cures = sorted(present.known.cures, key=self.cost_s)
        if not cures or (self.cost_s(cures[0]) >= share * remaining_s and not present.known.brings):
            return ()
        return cures[0]

    def cost_s(self, cure: Cure) -> float:
        """Return for how long a cure stops the output [s]."""
        boots_s = (
            self.configuration.boot_s[step.node] for step in cure if step.kind is AdaptationKind.REDEPLOY
        )
        return sum(boots_s) + _RESTART_S * sum(step.kind is AdaptationKind.RESTART for step in cure)

    def do(self, present: _Present, cure: Cure) -> None:
        """Request a cure, unless it was just requested or its nodes are away."""
        is_away = any(step.node in self.configuration.booting for step in cure)
        if is_away or self.now_s - present.tried_s < _RETRY_S:
            return
        present.tried_s = self.now_s
        for step in cure:
            self.configuration.do(step)

    def strength(self, present: _Present) -> Value:
        """Return the present strength of a fault."""
        return present.known.strength(self.now_s - present.since_s)

    def workarounds(self, cures: Mapping[str, Cure]) -> dict[Setting, Value]:
        """Return the settings for the pipeline without the sensors that are away for longer than a restart."""
        failures = current_system().failures
        away = {
            full_name(failures[present.known.failure].topic)
            for name, present in self.present.items()
            if _kind(cures[name]) is not AdaptationKind.RESTART
        }
        nodes = current_system().nodes
        away |= {full_name(topic) for node in self.configuration.booting for topic in nodes[node].outputs}
        return {key: value for topic, (key, value) in settings_without().items() if topic in away}


def _kind(cure: Cure) -> AdaptationKind | None:
    return cure[0].kind if cure else None
