"""A managing system that is told what is wrong: how good one can be that knows the truth."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from sunset.errors import ManagerError
from sunset.interfaces.stamps import ns_of
from sunset.interfaces.system_interfaces.msg import FaultEnd, FaultInjection
from sunset.managing.base import ManagingSystem
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
    described_faults,
    described_nodes,
)

ORACLE: Final = "oracle"
"""The name under which the harness tells it the scenario."""

_RESTART_S: Final = 0.1
"""How long a node sends nothing for a restart."""
_RETRY_S: Final = 1.0
"""So long after a request without effect it is made again."""
_UNSEGMENTED: Final = 0.5
"""What a degradation costs of the output, next to an outage: the paper's severities are from a tenth to 70 %."""

_WITHOUT: Final = {
    "rgb_camera": (("sensor_fusion", "modality"), 2),
    "depth_camera": (("sensor_fusion", "modality"), 1),
}
"""Topic → what is to be set so that the pipeline works without it."""

_HEALTHY: Final[Mapping[tuple[str, str], Value]] = {
    ("image_enhancement", "image_degradation"): described_faults()["image_degradation"].value,
    ("sensor_fusion", "modality"): 0,
    ("sensor_fusion", "topic_camera_input"): "rgb_camera",
}

_LASTING: Final = {AdaptationKind.SET_PARAMETER, AdaptationKind.CHANGE_TOPIC, AdaptationKind.ACTIVATE}

Cure = tuple[Adaptation, ...]
Setting = tuple[str, str]
"""A node and its parameter; an empty one is for whether the node is active."""


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
        self.booting: dict[str, float] = {}  # node → when it was redeployed
        self.settings: dict[Setting, Value] = {}  # what it has changed, as it is now
        self.start_s = math.inf  # when the measured time began, as the first fault tells
        self.symptoms = Symptoms({})
        self.nodes = {node.name: node for node in described_nodes()}
        self.create_subscription(FaultInjection, INJECTIONS_TOPIC, self.on_injection, 100)
        self.create_subscription(FaultEnd, FAULT_ENDS_TOPIC, self.on_end, 100)

    @property
    def now_s(self) -> float:
        """The experiment's time."""
        return self.get_clock().now().nanoseconds / 1e9

    def on_injection(self, injection: FaultInjection) -> None:
        """Take note of a fault that has come, and do something about it at once."""
        onset_s = ns_of(injection.stamp) / 1e9
        known = self.scenario.find(injection.fault, onset_s - self.start_s)
        if known is None or not injection.confirmed:
            return
        if not known.follows:
            self.start_s = min(self.start_s, onset_s - known.at)
        self.present[injection.fault] = _Present(described_faults()[injection.fault], known, onset_s)
        self.adapt(self.symptoms)

    def on_end(self, end: FaultEnd) -> None:
        """Take note of a fault that is over."""
        self.present.pop(end.fault, None)
        self.adapt(self.symptoms)

    def adapt(self, symptoms: Symptoms) -> None:
        """Cure what can be cured, and set what works around the rest."""
        self.symptoms = symptoms
        for node, since_s in list(self.booting.items()):
            if self.now_s - since_s > self.boot_s(node) and symptoms.state(node) == "active":
                del self.booting[node]
        cures = {name: self.best_cure(one) for name, one in self.present.items()}
        redeployed = {cure[0].node for cure in cures.values() if _kind(cure) is AdaptationKind.REDEPLOY}
        wanted: dict[Setting, Value] = {}
        for name, cure in cures.items():
            fault = self.present[name].fault
            if fault.kind is FaultKind.EXTERNAL and all(step.kind in _LASTING for step in cure):
                wanted |= self.lasting(self.present[name], cure)
            elif not (fault.node in redeployed and _redeploy(fault.node) in fault.cures):
                self.do(self.present[name], cure)
        for name, cure in cures.items():
            if _kind(cure) is AdaptationKind.REDEPLOY:
                self.do(self.present[name], cure)
        wanted |= self.workarounds(cures)
        self.set_all(wanted)

    def best_cure(self, one: _Present) -> Cure:
        """Return the cheapest cure of a fault; nothing if it costs more than the fault."""
        end_s = self.start_s + self.scenario.duration_s - self.now_s
        if one.known.until is not None:
            end_s = min(end_s, self.start_s + one.known.until - self.now_s)
        remaining_s = one.known.remaining_s(self.now_s - one.since_s, max(0.0, end_s))
        share = 1.0 if described_failures()[one.fault.failure].topic else _UNSEGMENTED
        cures = sorted(one.fault.cures, key=self.cost_s)
        if not cures or (self.cost_s(cures[0]) >= share * remaining_s and not one.known.brings):
            return ()
        return cures[0]

    def cost_s(self, cure: Cure) -> float:
        """Return for how long a cure stops the output [s]."""
        costs = {AdaptationKind.RESTART: _RESTART_S}
        return sum(
            self.boot_s(step.node) if step.kind is AdaptationKind.REDEPLOY else costs.get(step.kind, 0.0)
            for step in cure
        )

    def boot_s(self, node: str) -> float:
        """Return how long a node is away for a redeploy [s]."""
        return max(0.0, self.nodes[node].activation_delay_s)

    def do(self, one: _Present, cure: Cure) -> None:
        """Do a cure, unless it was just done or its nodes are away."""
        if not cure or self.now_s - one.tried_s < _RETRY_S or any(step.node in self.booting for step in cure):
            return
        one.tried_s = self.now_s
        for step in cure:
            request(self, step)
            if step.kind is AdaptationKind.REDEPLOY:
                self.booting[step.node] = self.now_s
                self.settings = {key: value for key, value in self.settings.items() if key[0] != step.node}

    def lasting(self, one: _Present, cure: Cure) -> dict[Setting, Value]:
        """Return the settings that work around a fault of the world."""
        wanted: dict[Setting, Value] = {}
        for step in cure:
            value = True if step.value is None else step.value
            wanted[step.node, step.parameter] = value
            if step.kind is AdaptationKind.ACTIVATE and step.node == "image_enhancement":
                wanted[step.node, one.fault.parameter] = one.known.strength(self.now_s - one.since_s)
        return wanted

    def workarounds(self, cures: Mapping[str, Cure]) -> dict[Setting, Value]:
        """Return the settings by which the pipeline does without what is away."""
        failures = described_failures()
        away = {
            failures[one.fault.failure].topic
            for name, one in self.present.items()
            if _kind(cures[name]) is not AdaptationKind.RESTART
        }
        away |= {topic for node in self.booting for topic in self.nodes[node].outputs}
        return {key: value for topic, (key, value) in _WITHOUT.items() if topic in away}

    def set_all(self, wanted: Mapping[Setting, Value]) -> None:
        """Set what is wanted, and what it has set before as it was."""
        undone = {
            key: _HEALTHY.get(key, False)
            for key in self.settings
            if key not in wanted and (key in _HEALTHY or not key[1])
        }
        for key, value in (undone | dict(wanted)).items():
            node, parameter = key
            is_away = node in self.booting and self.symptoms.state(node) != "inactive"
            if is_away or self.settings.get(key, _HEALTHY.get(key)) == value:
                continue
            self.settings[key] = value
            if parameter:
                self.set_parameter(node, parameter, value)
            elif value and self.symptoms.state(node) != "active":
                self.activate(node)
            elif not value:
                self.deactivate(node)


def _kind(cure: Cure) -> AdaptationKind | None:
    return cure[0].kind if cure else None


def _redeploy(node: str) -> Cure:
    return (Adaptation(AdaptationKind.REDEPLOY, node),)
