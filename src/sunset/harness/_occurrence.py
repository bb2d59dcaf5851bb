"""The state of a fault of a scenario, and its strength over time."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import count
from math import inf
from typing import Final

from sunset.scenarios import ScenarioFault
from sunset.system import (
    PERIOD_S,
    Adaptation,
    AdaptationKind,
    Fault,
    FaultKind,
    Value,
    comparable_text,
    goal_of,
)

STEP_S: Final = PERIOD_S
"""Seconds between two steps of a ramp; frames come as often."""

Change = tuple[float, Value | None]
"""Time in seconds of the measured time, and the strength from then on; None without the fault."""


def course(fault: ScenarioFault, onset_s: float) -> Iterator[Change]:
    """Yield the changes of a fault's strength in order of time; endlessly for an intermittent fault that stays.

    The onset is in seconds of the measured time.

    >>> list(course(ScenarioFault("gpu_failure", until=4.0), 2.0))
    [(2.0, True), (4.0, None)]
    """
    end = inf if fault.until is None else fault.until
    for time_s, value in _changes(fault, onset_s):
        if time_s >= end:
            break
        yield time_s, value
    if end < inf:
        yield end, None


def _changes(fault: ScenarioFault, onset_s: float) -> Iterator[Change]:
    profile, full = fault.profile, fault.value
    if full is None:
        raise ValueError(f"The severity of {fault.name} has no strength yet.")
    if profile.rise is not None and not isinstance(full, str):
        yield from _growth(full, profile.rise, onset_s)
    elif profile.on is not None and profile.off is not None:
        for number in count():
            begin = onset_s + number * (profile.on + profile.off)
            yield begin, full
            yield begin + profile.on, None
    else:
        yield onset_s, full


def _growth(full: float, rise_s: float, onset_s: float) -> Iterator[Change]:
    """Yield the changes of a strength that grows from 0."""
    steps = max(1, round(rise_s / STEP_S))
    last: float = 0
    for number in range(1, steps + 1):
        share = full * number / steps
        # a whole number has its least strength at once
        value = (round(share) or (1 if full > 0 else -1)) if isinstance(full, int) else share
        if value != last:
            yield onset_s + rise_s * number / steps, value
        last = value


@dataclass(eq=False)
class Occurrence:
    """A fault of a scenario, and its state.

    Attributes:
        plan: its entry in the scenario.
        waiting: whether its onset is due, and its node is not up.
        coming: whether its injection was ordered, and is not confirmed yet.
        begun: whether it has come once.
        there: whether it is there now.
        over: whether it never comes again: it was cured, has healed for good, or could not be injected.
        changes: the rest of its course.
        grown: the last strength that was set while it was there; None if there is none.
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
        """Return the steps that inject it at a strength."""
        return tuple(
            replace(step, value=value) if step.parameter == self.fault.parameter else step
            for step in self.fault.injection
        )

    def removal(self) -> tuple[Adaptation, ...]:
        """Return the steps that remove it: they reset its parameter, and deactivate the nodes that it activated."""
        fault = self.fault
        steps = [
            replace(step, value=fault.healthy)
            for step in fault.injection
            if step.parameter == fault.parameter
        ]
        return (*steps, *(Adaptation(AdaptationKind.DEACTIVATE, node) for node in sorted(self.activated)))
