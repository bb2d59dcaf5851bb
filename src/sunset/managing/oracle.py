"""A managing system that is told what is wrong: how good one can be that knows the truth."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from sunset.errors import ManagerError
from sunset.interfaces.stamps import ns_of
from sunset.interfaces.system_interfaces.msg import FaultEnd, FaultInjection
from sunset.managing.base import ManagingSystem
from sunset.managing.configuration import Configuration, Setting, settings_of, settings_without
from sunset.managing.known import KnownFault, KnownScenario
from sunset.managing.requesting import request
from sunset.managing.symptoms import Symptoms
from sunset.system.vocabulary import (
    FAULT_ENDS_TOPIC,
    INJECTIONS_TOPIC,
    Adaptation,
    AdaptationKind,
    Fault,
    FaultKind,
    Value,
    described_failures,
    described_nodes,
    full_name,
)

ORACLE: Final = "oracle"
"""The name under which the harness tells it the scenario."""

_RESTART_S: Final = 0.1
"""Seconds without output during a restart."""
_RETRY_S: Final = 1.0
"""A request without effect is repeated after this time."""
_TOLERABLE: Final[Mapping[str, float]] = {"depth_degradation": 0.18}
"""Fault → the strength up to which its cure costs more than it: with less noise, the fusion is better than the colour
image alone (`sunset models curves lite`)."""
_UNSEGMENTED: Final = 0.5
"""What a degradation costs of the output, next to an outage: the paper's severities are from a tenth to 70 %."""

Cure = tuple[Adaptation, ...]


@dataclass(eq=False)
class _Present:
    """A fault that is there."""

    fault: Fault
    known: KnownFault
    since_s: float
    tried_s: float = -_RETRY_S


class Oracle(ManagingSystem):
    """Is told by the harness what is wrong, and does the best known about it; no competitor, but the reference.

    It knows the scenario, and hears of every fault when it comes and when it ends.

    - The cheapest cure of a fault comes first. A redeploy cures all that is wrong inside a node.
    - It waits for a fault that heals by itself, when the cure would cost more of the output.
    - While the camera is away or boots, the fusion takes the depth image alone, and the other way round.
    - What works around a fault of the world is undone when that is over. The enhancement undoes the strength that the
      degradation has, if it is told so.
    - Its diagnosis is the truth.

    Args:
        scenario: the scenario of the run, which the harness gives to this class and to no other.
        options: as of `ManagingSystem`.

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
        """Listen for what comes and goes; nothing is wrong yet."""
        self.present: dict[str, _Present] = {}
        self.configuration = Configuration(self)
        self.start_s = math.inf  # when the measured time began, as the first fault tells
        self.symptoms = Symptoms({})
        self.outputs = {node.name: node.outputs for node in described_nodes()}
        self.create_subscription(FaultInjection, INJECTIONS_TOPIC, self.on_injection, 100)
        self.create_subscription(FaultEnd, FAULT_ENDS_TOPIC, self.on_end, 100)

    def on_injection(self, injection: FaultInjection) -> None:
        """Take note of a fault that has come, and do something about it at once."""
        onset_s = ns_of(injection.stamp) / 1e9
        known = self.scenario.find(injection.fault, onset_s - self.start_s)
        if known is None or not injection.confirmed:
            return
        if not known.follows:
            self.start_s = min(self.start_s, onset_s - known.at)
        self.present[injection.fault] = _Present(known.fault, known, onset_s)
        self.diagnose(dict.fromkeys(self.present, 1.0))
        self.adapt(self.symptoms)

    def on_end(self, end: FaultEnd) -> None:
        """Take note of a fault that is over."""
        self.present.pop(end.fault, None)
        self.diagnose(dict.fromkeys(self.present, 1.0))
        if not self.scenario.brings(
            self.now_s - self.start_s
        ):  # else what comes now may need what would be set back
            self.adapt(self.symptoms)

    def adapt(self, symptoms: Symptoms) -> None:
        """Cure what can be cured, and set what works around the rest."""
        self.symptoms = symptoms
        self.configuration.see(symptoms)
        cures = {name: self.best_cure(present) for name, present in self.present.items()}
        redeploys = {cure for cure in cures.values() if _kind(cure) is AdaptationKind.REDEPLOY}
        wanted: dict[Setting, Value] = {}
        for name, cure in cures.items():
            present = self.present[name]
            settings = (
                settings_of(cure, present.fault, self.strength(present))
                if present.fault.kind is FaultKind.EXTERNAL
                else None
            )
            if settings is not None:
                wanted |= settings
            elif cure and (cure in redeploys or not redeploys.intersection(present.fault.cures)):
                self.do(present, cure)
        self.configuration.want(wanted | self.workarounds(cures), symptoms)

    def best_cure(self, present: _Present) -> Cure:
        """Return the cheapest cure of a fault; nothing if it costs more than the fault."""
        end_s = self.start_s + self.scenario.duration_s - self.now_s
        if present.known.until is not None:
            end_s = min(end_s, self.start_s + present.known.until - self.now_s)
        remaining_s = present.known.remaining_s(self.now_s - present.since_s, max(0.0, end_s))
        strength = self.strength(present)
        if isinstance(strength, float) and strength < _TOLERABLE.get(present.fault.name, 0.0):
            return ()
        share = 1.0 if described_failures()[present.fault.failure].topic else _UNSEGMENTED
        cures = sorted(present.fault.cures, key=self.cost_s)
        if not cures or (self.cost_s(cures[0]) >= share * remaining_s and not present.known.brings):
            return ()
        return cures[0]

    def cost_s(self, cure: Cure) -> float:
        """Return for how long a cure stops the output [s]."""
        costs = {AdaptationKind.RESTART: _RESTART_S}
        return sum(
            self.configuration.boot_s[step.node]
            if step.kind is AdaptationKind.REDEPLOY
            else costs.get(step.kind, 0.0)
            for step in cure
        )

    def do(self, present: _Present, cure: Cure) -> None:
        """Do a cure, unless it was just done or its nodes are away."""
        is_away = any(step.node in self.configuration.booting for step in cure)
        if is_away or self.now_s - present.tried_s < _RETRY_S:
            return
        present.tried_s = self.now_s
        for step in cure:
            if step.kind is AdaptationKind.REDEPLOY:
                self.configuration.redeploy(step.node)
            else:
                request(self, step)

    def strength(self, present: _Present) -> Value:
        """Return how strong a fault is now."""
        return present.known.strength(self.now_s - present.since_s)

    def workarounds(self, cures: Mapping[str, Cure]) -> dict[Setting, Value]:
        """Return the settings by which the pipeline does without what is away for longer than a restart."""
        failures = described_failures()
        away = {
            full_name(failures[present.fault.failure].topic)
            for name, present in self.present.items()
            if _kind(cures[name]) is not AdaptationKind.RESTART
        }
        away |= {full_name(topic) for node in self.configuration.booting for topic in self.outputs[node]}
        return {key: value for topic, (key, value) in settings_without().items() if topic in away}


def _kind(cure: Cure) -> AdaptationKind | None:
    return cure[0].kind if cure else None
