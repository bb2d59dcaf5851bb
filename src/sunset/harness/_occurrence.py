"""One fault of a scenario while it is played: whether it has come, is there, and is over."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from sunset.harness._course import Change
from sunset.scenarios import ScenarioFault
from sunset.system import (
    Adaptation,
    AdaptationKind,
    Fault,
    FaultKind,
    Value,
    comparable_text,
    goal_of,
)


@dataclass(eq=False)
class Occurrence:
    """A fault of a scenario, and its state.

    Attributes:
        plan: what the scenario says of it.
        waiting: whether its onset is due, and its node is not up.
        coming: whether its injection was ordered, and is not confirmed yet.
        begun: whether it has come once.
        there: whether it is there now.
        over: whether it does not come any more: it was cured, has healed for good, or could not be injected.
        changes: what is still to come of its course.
        grown: the strength that it was given last while it was there; None if that never was.
        activated: the nodes that its injection has activated.
    """

    plan: ScenarioFault
    waiting: bool = False
    coming: bool = False
    begun: bool = False
    there: bool = False
    over: bool = False
    changes: Iterator[Change] = field(default_factory=lambda: iter(()))
    grown: Value | None = None
    activated: set[str] = field(default_factory=set)

    @property
    def fault(self) -> Fault:
        """The entry of the catalogue."""
        return self.plan.fault

    @property
    def is_internal(self) -> bool:
        """Whether it ends with its node's process."""
        return self.fault.kind is FaultKind.INTERNAL

    @property
    def is_away(self) -> bool:
        """Whether it comes and goes, and has gone for a while."""
        return self.has_left and not self.over

    @property
    def has_left(self) -> bool:
        """Whether it has been there, and is not."""
        return self.begun and not self.coming and not self.there

    @property
    def is_due(self) -> bool:
        """Whether it has not come yet, and its injection was not ordered."""
        return not self.begun and not self.coming

    @property
    def is_cured_by_restart(self) -> bool:
        """Whether a restart of its node cures it."""
        return any(cure[0].kind is AdaptationKind.RESTART for cure in self.fault.cures if len(cure) == 1)

    def is_cured_by(self, parameter: str, value: Value) -> bool:
        """Return whether a value of a parameter of its node cures it."""
        key = self.fault.node, parameter
        wanted = key, comparable_text(key, value)
        return any(goal_of(cure[0]) == wanted for cure in self.fault.cures if len(cure) == 1)

    def injection(self, value: Value) -> tuple[Adaptation, ...]:
        """Return what injects it at a strength."""
        return tuple(
            replace(step, value=value) if step.parameter == self.fault.parameter else step
            for step in self.fault.injection
        )

    def removal(self) -> tuple[Adaptation, ...]:
        """Return what takes it away: its parameter as it is without it, the nodes that it activated as they were."""
        fault = self.fault
        steps = [
            replace(step, value=fault.healthy)
            for step in fault.injection
            if step.parameter == fault.parameter
        ]
        return (*steps, *(Adaptation(AdaptationKind.DEACTIVATE, node) for node in sorted(self.activated)))
