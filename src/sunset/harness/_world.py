"""The scenario executor's memory of its faults and of the managed nodes."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import count
from math import inf

from sunset.scenarios import ScenarioFault
from sunset.system import (
    PERIOD_S,
    STATE,
    Adaptation,
    AdaptationKind,
    Fault,
    FaultKind,
    Key,
    Value,
    comparable_text,
    current_system,
    goal_of,
    is_in_place,
)

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
    """Yield the changes of a strength that grows from 0, as often as frames come."""
    steps = max(1, round(rise_s / PERIOD_S))
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
    """A fault of a scenario, and its state."""

    plan: ScenarioFault
    waiting: bool = False
    """Its onset is due, and its node is not up."""
    coming: bool = False
    """Its injection was ordered, and is not confirmed yet."""
    begun: bool = False
    """It has come once."""
    there: bool = False
    over: bool = False
    """It never comes again: it was cured, has healed for good, or could not be injected."""
    changes: Iterator[Change] = field(default_factory=lambda: iter(()))
    """The rest of its course."""
    grown: Value | None = None
    """The last strength that was set while it was there."""
    activated: set[str] = field(default_factory=set)
    """The nodes that its injection has activated."""

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
        return self.begun and not (self.coming or self.there or self.over)

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


class World:
    """The external and configuration faults that are there now, the steps that restore them, and the nodes' states."""

    def __init__(self) -> None:
        self._lasting: dict[tuple[str, str], tuple[Adaptation, Fault]] = {}
        self._states: dict[str, str] = {}
        self._values: dict[Key, str] = {}
        self._starting: set[str] = set()
        self._restarted: set[str] = set()
        self._initial_states = current_system().initial_states

    def hold(self, steps: Iterable[Adaptation], fault: Fault) -> None:
        """Remember the steps of an injection, unless the fault is internal to its node."""
        if fault.kind is not FaultKind.INTERNAL:
            self._lasting |= {_key(step): (step, fault) for step in steps}

    def release(self, fault: Fault) -> None:
        """Forget the steps of a fault's injection."""
        self._lasting = {key: held for key, held in self._lasting.items() if held[1] is not fault}

    def holds(self, fault: Fault) -> bool:
        """Return whether any step of a fault's injection is remembered."""
        return any(held is fault for _, held in self._lasting.values())

    def settle(self) -> None:
        """Take all nodes except redeployed nodes as up, since the first fault is being injected."""
        self._starting &= self._restarted

    def is_settled(self, node: str) -> bool:
        """Return whether a node has been in its initial state since its process started."""
        return node not in self._starting

    def see_transition(self, node: str, start: str, goal: str) -> bool:
        """Note a lifecycle transition; return whether it ends the process, or shows that the process is new."""
        is_new = start == "unconfigured" and self._states.get(node, "unconfigured") != "unconfigured"
        self._states[node] = goal
        if goal == "finalized" or is_new:
            self._restart(node)
            return True
        if goal == self._initial_states.get(node):
            self._starting.discard(node)
        return False

    def see_value(self, node: str, parameter: str, value: Value, *, declared: bool) -> bool:
        """Note the value of a parameter; return whether it shows that the process is new."""
        self._values[node, parameter] = comparable_text((node, parameter), value)
        if not declared or parameter != "use_sim_time":  # which a node declares first
            return False
        self._restart(node)
        self._states[node] = "unconfigured"
        return True

    def _restart(self, node: str) -> None:
        """Note that a node's process has ended, and another is starting."""
        if node in self._states:
            self._restarted.add(node)
        self._starting.add(node)

    def after_transition(self, node: str, start: str, goal: str) -> list[Adaptation]:
        """Return the steps to repeat after a lifecycle transition from the state `start` to `goal`.

        A node that comes up gets its parameters when it is configured, and again when it is active, since its first
        messages may be lost during discovery.
        """
        if (start, goal) == ("deactivating", "inactive"):  # the node was removed on purpose
            self._lasting.pop(_key(Adaptation(AdaptationKind.ACTIVATE, node)), None)
            return []
        if goal not in {"inactive", "active"}:
            return []
        return [
            step
            for step, _ in self._lasting.values()
            if step.node == node and (step.parameter or goal == "inactive")
        ]

    def after_change_to(self, node: str, parameter: str, value: Value) -> list[Adaptation]:
        """Return the steps to repeat after a change of a parameter of a running node."""
        key = node, parameter
        step, fault = self._lasting.get(key, (None, None))
        if step is None or fault is None or goal_of(step) == (key, comparable_text(key, value)):
            return []
        if fault.kind is FaultKind.CONFIGURATION:
            # the managing system owns this configuration from now on
            self.release(fault)
            return []
        return [step]

    def is_worked_around(self, fault: Fault) -> bool:
        """Return whether a cure of an external fault is in place."""
        return fault.kind is FaultKind.EXTERNAL and any(
            is_in_place(fault, cure, self._setting) for cure in fault.cures
        )

    def _setting(self, key: Key) -> str | None:
        node, name = key
        return (
            self._states.get(node, self._initial_states.get(node)) if name == STATE else self._values.get(key)
        )

    def cause_of(self, fault: Fault, done: str) -> str:
        """Return the cause of an internal fault's end, whose parameter its node has just reset.

        The cause is a restart if the node is not active; otherwise a parameter that is a cure, else `done`.
        """
        if self._states.get(fault.node, "active") != "active":
            return f"restart {fault.node}"
        steps = (cure[0] for cure in fault.cures if len(cure) == 1 and cure[0].parameter)
        done_steps = (step for step in steps if is_in_place(fault, [step], self._setting))
        return next(map(str, done_steps), done)


def _key(step: Adaptation) -> tuple[str, str]:
    return step.node, step.parameter or str(step.kind)
