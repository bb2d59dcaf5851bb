"""The actions of a policy: the adaptations of the catalogue by number, and longer ones that are made of them."""

from collections.abc import Callable, Generator, Sequence
from functools import partial
from math import ceil
from typing import Final, NamedTuple, cast

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import Configuration, Setting, Thresholds, Wiring, healthy_settings
from sunset.system.vocabulary import Adaptation, AdaptationKind, Value, current_system, redeploy, restart

Steps = Sequence[Adaptation]
Script = Generator[Steps, Symptoms, None]
"""Yields the adaptations of each of its decisions, and gets the symptoms of the next."""

_RESTART_S: Final = 0.5
"""Time until a restarted node sends again."""
_LOOK_S: Final = 0.8
"""Time until all signals, means over 5 frames, are of new frames only."""


def _long_cures() -> tuple[Steps, ...]:
    """Return the cures that have several steps, each once."""
    cures = (cure for fault in current_system().faults.values() for cure in fault.cures if len(cure) > 1)
    return tuple(dict.fromkeys(cures))


def action_names() -> tuple[str, ...]:
    """Return the names of all actions, in words."""
    return (
        "nothing",
        *map(str, current_system().adaptations),
        *(f"restart {node}, or redeploy it" for node in current_system().nodes),
        *(" and ".join(map(str, cure)) for cure in _long_cures()),
        "look back",
    )


class _Action(NamedTuple):
    script: Callable[[], Script]
    may: Callable[[Symptoms], bool] = lambda _: True


class Actions:
    """The actions of a managing system, which are numbered; 0 does nothing.

    After the adaptations of the system come, for each node, a restart with a redeploy if that did not help; the cures
    that have several steps; and a look back, which restores the settings of a healthy system for a moment and keeps
    them if all signals stay on the good side of their thresholds. These longer actions decide for several decisions.

    Args:
        manager: the managing system, whose requests the actions are.

    Attributes:
        adaptations: of the system, each once.
        names: of all actions, in words.
        since_s: when each action was last begun, by the experiment's clock; minus infinity if it never was.
    """

    def __init__(self, manager: ManagingSystem) -> None:
        system = current_system()
        self._manager = manager
        self._period_s = cast("float", manager.get_parameter("period").value)
        self._wiring, self._thresholds = Wiring(), Thresholds(manager)
        self._configuration = Configuration(manager)
        self._healthy = healthy_settings()
        self.adaptations = system.adaptations
        self._actions = (
            _Action(partial(_at_once, ())),
            *(_Action(partial(_at_once, (step,)), partial(self._may, step)) for step in self.adaptations),
            *(
                _Action(partial(self._repair, node), partial(self._may, restart(node)))
                for node in system.nodes
            ),
            *(_Action(partial(_at_once, cure)) for cure in _long_cures()),
            _Action(self._look_back, lambda _: bool(self._differing())),
        )
        self.names = action_names()
        self._script: Script | None = None
        self.since_s = [float("-inf")] * len(self.names)

    def is_set(self, step: Adaptation) -> bool:
        """Return whether the parameter of an adaptation has its value, as far as the managing system knows."""
        return self._configuration.get((step.node, step.parameter)) == step.value

    def allowed(self, symptoms: Symptoms) -> list[bool]:
        """Return which actions can have an effect."""
        return [action.may(symptoms) for action in self._actions]

    def proceed(self, symptoms: Symptoms) -> bool:
        """Note the symptoms; return whether an earlier action has decided for now, and do that."""
        self._configuration.see(symptoms)
        if self._script is None:
            return False
        try:
            self._do(self._script.send(symptoms))
        except StopIteration:
            self._script = None
        return self._script is not None

    def begin(self, action: int) -> None:
        """Begin an action, by its number."""
        self.since_s[action] = self._manager.now_s
        self._script = self._actions[action].script()
        self._do(next(self._script))

    def _may(self, step: Adaptation, symptoms: Symptoms) -> bool:
        is_there = step.kind.goal_state == symptoms.state(step.node)
        return bool(step.parameter) or not (is_there or step.node in self._configuration.booting)

    def _do(self, steps: Steps) -> None:
        for step in steps:
            if step.parameter and step.value is not None:
                self._configuration.set((step.node, step.parameter), step.value)
            else:
                self._configuration.do(step)

    def _wait(self, seconds: float) -> Generator[Steps, Symptoms, Symptoms]:
        for _ in range(ceil(seconds / self._period_s) - 1):
            yield ()
        return (yield ())

    def _repair(self, node: str) -> Script:
        yield (restart(node),)
        symptoms = yield from self._wait(_RESTART_S)
        if symptoms.state(node) != "active" or self._wiring.first_silent(symptoms) == node:
            yield (redeploy(node),)

    def _look_back(self) -> Script:
        differing = self._differing()
        yield _settings({setting: self._healthy[setting] for setting in differing})
        symptoms = yield from self._wait(_LOOK_S)
        if any(self._thresholds.is_beyond(name, symptoms) for name in current_system().signals):
            yield _settings(differing)

    def _differing(self) -> dict[Setting, Value]:
        """Return the parameters of the catalogue that were set to other values than a healthy system's."""
        settings = {(step.node, step.parameter) for step in self.adaptations if step.parameter}
        present = {setting: self._configuration.get(setting) for setting in sorted(settings)}
        return {
            setting: value
            for setting, value in present.items()
            if value is not None and setting in self._healthy and value != self._healthy[setting]
        }


def _at_once(steps: Steps) -> Script:
    yield steps


def _settings(values: dict[Setting, Value]) -> Steps:
    return [
        Adaptation(AdaptationKind.SET_PARAMETER, node, parameter, value)
        for (node, parameter), value in values.items()
    ]
