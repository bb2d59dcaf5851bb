"""What outlasts a node's process, as the scenario executor remembers it."""

from sunset.scenarios.schema import ScenarioFault
from sunset.system import Adaptation, AdaptationKind, FaultKind, Value


class World:
    """The external and configuration faults that are there now, and what puts them back.

    Its methods are told what is seen of a node, and return the steps that restore the faults.
    """

    def __init__(self) -> None:
        self._lasting: dict[Adaptation, FaultKind] = {}

    def begin(self, fault: ScenarioFault) -> None:
        """Remember a fault that was injected, unless it is internal to its node."""
        if fault.fault.kind is not FaultKind.INTERNAL:
            self._lasting |= dict.fromkeys(fault.injection, fault.fault.kind)

    def after_transition(self, node: str, start: str, goal: str) -> list[Adaptation]:
        """Return what to do after a lifecycle transition from the state `start` to `goal`.

        A node that comes up gets its parameters when it is configured, and to be safe when it is active: its
        first messages may be lost while it is being discovered.
        """
        activation = Adaptation(AdaptationKind.ACTIVATE, node)
        if (start, goal) == ("deactivating", "inactive"):  # somebody removed the node on purpose
            self._lasting.pop(activation, None)
            return []
        if goal not in {"inactive", "active"}:
            return []
        return [
            step for step in self._lasting if step.node == node and (step.parameter or goal == "inactive")
        ]

    def after_change_to(self, node: str, parameter: str, value: Value) -> list[Adaptation]:
        """Return what to do after a parameter of a running node got a value."""
        changed = [
            step
            for step in self._lasting
            if (step.node, step.parameter) == (node, parameter) and step.value != value
        ]
        if any(self._lasting[step] is FaultKind.CONFIGURATION for step in changed):
            # the configuration is somebody else's from now on
            kinds = self._lasting.items()
            self._lasting = {step: kind for step, kind in kinds if kind is not FaultKind.CONFIGURATION}
            return []
        return changed
