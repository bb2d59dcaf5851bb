"""The scenario executor's memory of the managed nodes, and of faults that outlast their processes."""

from collections.abc import Iterable

from sunset.system import (
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

_UP = frozenset({"inactive", "active"})
_FIRST = "use_sim_time"
"""The parameter that a node declares first."""


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
        if not declared or parameter != _FIRST:
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
        if goal not in _UP:
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
