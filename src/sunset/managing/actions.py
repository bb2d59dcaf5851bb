"""The actions of a policy: the adaptations of the catalogue by number, and longer ones that are made of them."""

from math import ceil
from typing import Final, NamedTuple, cast

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import Configuration, Wiring
from sunset.system.vocabulary import Adaptation, current_system, redeploy, restart

_RESTART_S: Final = 0.5
"""Time until a restarted node sends again."""


class _Action(NamedTuple):
    """Adaptations, and the node that is redeployed if they did not help."""

    name: str
    steps: tuple[Adaptation, ...]
    node: str = ""


def _numbered() -> tuple[_Action, ...]:
    system = current_system()
    cures = (cure for fault in system.faults.values() for cure in fault.cures if len(cure) > 1)
    return (
        _Action("nothing", ()),
        *(_Action(str(step), (step,)) for step in system.adaptations),
        *(_Action(f"restart {node}, or redeploy it", (restart(node),), node) for node in system.nodes),
        *(_Action(" and ".join(map(str, cure)), cure) for cure in dict.fromkeys(cures)),
    )


def action_names() -> tuple[str, ...]:
    """Return the names of all actions, in words."""
    return tuple(action.name for action in _numbered())


class Actions:
    """The actions of a managing system, which are numbered; 0 does nothing.

    After the adaptations of the system come, for each node, a restart with a redeploy if that did not help, which takes
    several decisions; and the cures that have several steps.

    Args:
        manager: the managing system, whose requests the actions are.

    Attributes:
        adaptations: of the system, each once.
        names: of all actions, in words.
        since_s: when each action was last begun, by the experiment's clock; minus infinity if it never was.
    """

    def __init__(self, manager: ManagingSystem) -> None:
        self._manager = manager
        self._restart = ceil(_RESTART_S / cast("float", manager.get_parameter("period").value))
        self._wiring, self._configuration = Wiring(), Configuration(manager)
        self.adaptations = current_system().adaptations
        self._actions = _numbered()
        self.names = action_names()
        self._restarted = ""
        self._wait = 0  # decisions until it is known whether the restart helped
        self.since_s = [float("-inf")] * len(self.names)

    def is_set(self, step: Adaptation) -> bool:
        """Return whether the parameter of an adaptation has its value, as far as the managing system knows."""
        return self._configuration.get((step.node, step.parameter)) == step.value

    def allowed(self, symptoms: Symptoms) -> list[bool]:
        """Return which actions can have an effect."""
        return [len(steps) != 1 or self._may(steps[0], symptoms) for _, steps, _ in self._actions]

    def proceed(self, symptoms: Symptoms) -> bool:
        """Note the symptoms; return whether an earlier action has decided for now, and do that."""
        self._configuration.see(symptoms)
        if self._wait:
            self._wait -= 1
            return True
        node, self._restarted = self._restarted, ""
        if not node or (symptoms.state(node) == "active" and self._wiring.first_silent(symptoms) != node):
            return False
        self._do(redeploy(node))
        return True

    def begin(self, action: int) -> None:
        """Begin an action, by its number."""
        self.since_s[action] = self._manager.now_s
        _, steps, self._restarted = self._actions[action]
        self._wait = self._restart if self._restarted else 0
        for step in steps:
            self._do(step)

    def _may(self, step: Adaptation, symptoms: Symptoms) -> bool:
        is_there = step.kind.goal_state == symptoms.state(step.node)
        return bool(step.parameter) or not (is_there or step.node in self._configuration.booting)

    def _do(self, step: Adaptation) -> None:
        if step.parameter and step.value is not None:
            self._configuration.set((step.node, step.parameter), step.value)
        else:
            self._configuration.do(step)
