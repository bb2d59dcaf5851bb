"""What is seen of the managed nodes, and what outlasts their processes, as the scenario executor remembers it."""

from collections.abc import Iterable
from functools import partial

from sunset.system import (
    Adaptation,
    AdaptationKind,
    Fault,
    FaultKind,
    Value,
    current_system,
)

_UP = frozenset({"inactive", "active"})
_FIRST = "use_sim_time"
"""The parameter that a node declares first."""


class World:
    """The external and configuration faults that are there now, the steps that restore them, and the nodes' states.

    Its methods take what was observed of a node.
    """

    def __init__(self) -> None:
        self._lasting: dict[tuple[str, str], tuple[Adaptation, FaultKind]] = {}
        self._states: dict[str, str] = {}
        self._values: dict[tuple[str, str], Value] = {}
        self._starting: set[str] = set()
        self._started_anew: set[str] = set()
        self._initial_states = current_system().initial_states

    def hold(self, steps: Iterable[Adaptation], kind: FaultKind) -> None:
        """Remember the steps of an injection, unless the fault is internal to its node."""
        if kind is not FaultKind.INTERNAL:
            self._lasting |= {_key(step): (step, kind) for step in steps}

    def release(self, steps: Iterable[Adaptation]) -> None:
        """Forget the steps of an injection."""
        for step in steps:
            self._lasting.pop(_key(step), None)

    def holds(self, steps: Iterable[Adaptation]) -> bool:
        """Return whether any step of an injection is remembered."""
        return any(_key(step) in self._lasting for step in steps)

    def settle(self) -> None:
        """Take all nodes except redeployed ones as up, which they are when the first fault is injected."""
        self._starting &= self._started_anew

    def is_settled(self, node: str) -> bool:
        """Return whether a node's process is there, and the node has been in its initial state since its start."""
        return node not in self._starting

    def see_transition(self, node: str, start: str, goal: str) -> bool:
        """Take note of a lifecycle transition; return whether the process ends by it, or is a new one."""
        is_new = start == "unconfigured" and self._states.get(node, "unconfigured") != "unconfigured"
        self._states[node] = goal
        if goal == "finalized" or is_new:
            self._begin_anew(node)
            return True
        if goal == self._initial_states.get(node):
            self._starting.discard(node)
        return False

    def see_value(self, node: str, parameter: str, value: Value, *, declared: bool) -> bool:
        """Take note of the value that a parameter got; return whether this shows that the process is a new one."""
        self._values[node, parameter] = value
        if not declared or parameter != _FIRST:
            return False
        self._begin_anew(node)
        self._states[node] = "unconfigured"
        return True

    def _begin_anew(self, node: str) -> None:
        """Forget what was seen of a node's last process."""
        if node in self._states:
            self._started_anew.add(node)
        self._starting.add(node)
        self._values = {key: value for key, value in self._values.items() if key[0] != node}

    def after_transition(self, node: str, start: str, goal: str) -> list[Adaptation]:
        """Return what to do after a lifecycle transition from the state `start` to `goal`.

        A node that comes up gets its parameters when it is configured, and to be safe when it is active: its
        first messages may be lost while it is being discovered.
        """
        activation = Adaptation(AdaptationKind.ACTIVATE, node)
        if (start, goal) == ("deactivating", "inactive"):  # the node was removed on purpose
            self.release([activation])
            return []
        if goal not in _UP:
            return []
        return [
            step
            for step, _ in self._lasting.values()
            if step.node == node and (step.parameter or goal == "inactive")
        ]

    def after_change_to(self, node: str, parameter: str, value: Value) -> list[Adaptation]:
        """Return what to do after a parameter of a running node got a value."""
        step, kind = self._lasting.get((node, parameter), (None, None))
        if step is None or _sets(step, value):
            return []
        if kind is FaultKind.CONFIGURATION:
            # the managing system owns this configuration from now on
            self._lasting = {
                key: held for key, held in self._lasting.items() if held[1] is not FaultKind.CONFIGURATION
            }
            return []
        return [step]

    def is_worked_around(self, fault: Fault) -> bool:
        """Return whether a cure is in place of a fault that lives in the world and cannot be ended."""
        return fault.kind is FaultKind.EXTERNAL and any(
            all(map(self._is_done, cure))
            and fault.is_undone(
                self._values.get((fault.node, fault.parameter)),
                [self._values.get((step.node, fault.parameter)) for step in cure],
            )
            for cure in fault.cures
        )

    def cause_of(self, fault: Fault, done: str) -> str:
        """Return what has cured an internal fault, whose parameter its node has just set back; `done` if nothing seen.

        A restart does so while the node is not active, and else a parameter that the node acts on.
        """
        if self._states.get(fault.node, "active") != "active":
            return f"restart {fault.node}"
        steps = (cure[0] for cure in fault.cures if len(cure) == 1 and cure[0].parameter)
        return next((str(step) for step in steps if self._is_done(step)), done)

    def _is_done(self, step: Adaptation) -> bool:
        if step.kind is AdaptationKind.ACTIVATE:
            return self._states.get(step.node) == "active"
        if step.kind is AdaptationKind.DEACTIVATE:
            return self._states.get(step.node) == "inactive"
        value = self._values.get((step.node, step.parameter))
        return bool(step.parameter) and value is not None and _sets(step, value)


def _key(step: Adaptation) -> tuple[str, str]:
    return step.node, step.parameter or str(step.kind)


def _sets(step: Adaptation, value: Value) -> bool:
    """Return whether a step sets its parameter to a value."""
    comparable = partial(current_system().comparable, step.node, step.parameter)
    return step.value is not None and comparable(step.value) == comparable(value)
