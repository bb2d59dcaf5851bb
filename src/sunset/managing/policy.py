"""Policies: managing systems that choose a numbered action for an observation of arrays, as an agent learns to."""

from collections.abc import Awaitable, Iterable, Mapping
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from sunset.managing.actions import Actions
from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import Thresholds
from sunset.system.vocabulary import (
    Value,
    current_system,
    frequency_entry,
    full_name,
    heartbeat_entry,
    state_entry,
)

Array = npt.NDArray[np.float32]
Mask = npt.NDArray[np.int8]

STATES: Final = ("unconfigured", "inactive", "active", "finalized", "unknown")
"""Lifecycle states, in the order of an observation; a node that is in none of them is in a transition."""

LIMITS: Final[Mapping[str, tuple[float, float]]] = {
    "signals": (-100.0, 100.0),
    "signals_missing": (0.0, 1.0),
    "states": (0.0, 1.0),
    "heartbeats": (0.0, 100.0),
    "heartbeats_missing": (0.0, 1.0),
    "frequencies": (0.0, 100.0),
    "frequencies_missing": (0.0, 1.0),
    "settings": (0.0, 1.0),
    "since": (0.0, 60.0),
}
"""Part of an observation → its least and greatest value; others are cut."""


class Graph(NamedTuple):
    """An observation as a graph of the managed nodes; a feature that does not belong to a node is 0.

    Attributes:
        nodes: (N, F) the features of each node: its row of `states`, its heartbeat and whether that is missing, the
            signals, which of them are missing, the settings, and the times since each adaptation.
        edges: (E, 2) the frequency of the topic between two nodes, and whether that is missing.
        links: (E, 2) the numbers of the nodes that publish and subscribe.
    """

    nodes: Array
    edges: Array
    links: npt.NDArray[np.int64]


class Sight:
    """Turns symptoms into observations; it sees what a managing system may, and what that has done.

    Args:
        manager: the managing system.
        actions: its actions.
    """

    def __init__(self, manager: ManagingSystem, actions: Actions) -> None:
        system = current_system()
        self._manager, self._actions = manager, actions
        self._thresholds = Thresholds(manager)
        known = {name: self._thresholds.threshold(name) for name in system.signals}
        self._scales = {name: value if value > 0 else 1.0 for name, value in known.items()}
        self._nodes = tuple(system.nodes)
        self._heartbeats = [heartbeat_entry(node) for node in system.nodes]
        self._states = [state_entry(node) for node in system.nodes]
        self._topics = {full_name(topic): frequency_entry(topic) for topic in system.topics}
        self._setters = [step for step in actions.adaptations if step.parameter]
        links = [
            (
                self._nodes.index(system.publishers[topic]),
                self._nodes.index(node),
                list(self._topics).index(topic),
            )
            for node, topics in system.inputs.items()
            for topic in sorted(topics)
            if topic in system.publishers and topic in self._topics
        ]
        self._links = np.array(links, np.int64).reshape(-1, 3)

    def arrays(self, symptoms: Symptoms) -> dict[str, Array]:
        """Return the observation as new arrays.

        - `signals`: each as a multiple of its threshold if it has one; 0 while it is missing.
        - `states`: (N, 5) whether each node is in each of `STATES`.
        - `heartbeats`, `frequencies`: of the nodes and of the watched topics [Hz]; 0 while they are missing.
        - `settings`: for each adaptation that sets a parameter, whether the parameter has that value as far as the
          managing system knows: until it has set it, a healthy system's.
        - `since`: the time since each action but the first was begun [s]; 60 if it never was.
        """
        now_s = self._manager.now_s
        signals, no_signals = _numbers(symptoms, self._scales)
        heartbeats, no_heartbeats = _numbers(symptoms, self._heartbeats)
        frequencies, no_frequencies = _numbers(symptoms, self._topics.values())
        states = [symptoms.get(entry, "unknown") for entry in self._states]
        parts = {
            "signals": signals / np.array([*self._scales.values()]),
            "signals_missing": no_signals,
            "states": np.equal.outer(states, STATES),
            "heartbeats": heartbeats,
            "heartbeats_missing": no_heartbeats,
            "frequencies": frequencies,
            "frequencies_missing": no_frequencies,
            "settings": np.array([self._actions.is_set(step) for step in self._setters]),
            "since": now_s - np.array(self._actions.since_s[1:]),
        }
        return {name: np.clip(part, *LIMITS[name]).astype(np.float32) for name, part in parts.items()}

    def graph(self, symptoms: Symptoms) -> Graph:
        """Return the observation as a graph."""
        parts = self.arrays(symptoms)
        adaptations = self._actions.adaptations
        signals = current_system().signals.values()
        owned = [
            ([signal.node for signal in signals], parts["signals"]),
            ([signal.node for signal in signals], parts["signals_missing"]),
            ([step.node for step in self._setters], parts["settings"]),
            ([step.node for step in adaptations], parts["since"][: len(adaptations)]),
        ]
        rows = [
            np.where(np.equal.outer(self._nodes, owners), values, np.float32(0)) for owners, values in owned
        ]
        beats = np.stack([parts["heartbeats"], parts["heartbeats_missing"]], axis=1)
        topics = self._links[:, 2]
        edges = np.stack([parts[name][topics] for name in ("frequencies", "frequencies_missing")], axis=1)
        return Graph(
            np.concatenate([parts["states"], beats, *rows], axis=1), edges, self._links[:, :2].copy()
        )

    def situation(self, symptoms: Symptoms) -> tuple[str, ...]:
        """Return in words what differs from a healthy system, which is nothing in a healthy one."""
        nodes = current_system().nodes.values()
        states = {node.name: (symptoms.state(node.name), node.initial_state) for node in nodes}
        return (
            *(f"{node} is {state}" for node, (state, initial) in states.items() if state != initial),
            *(f"{topic} has stopped" for topic in current_system().topics if symptoms.stopped(topic)),
            *(f"{name} is bad" for name in self._scales if self._thresholds.is_beyond(name, symptoms)),
        )

    def text(self, symptoms: Symptoms) -> str:
        """Return the observation as lines of text, an entry of the blackboard or a past action on each."""
        now_s = self._manager.now_s
        lines = [f"{name}: {_text(value)}" for name, value in sorted(symptoms.items())]
        done = zip(self._actions.names[1:], self._actions.since_s[1:], strict=True)
        lines += [f"{name}: {now_s - since_s:.1f} s ago" for name, since_s in done if since_s >= 0]
        return "\n".join(lines)


class Policy(ManagingSystem):
    """A managing system that chooses one of `actions` by an observation; subclass it and write `act`.

    While an action takes several decisions, `act` is not called.

    Attributes:
        patience: after how many decisions `act` is called again if the situation has not changed; 1 unless a subclass
            says otherwise.
        symptoms: the latest.

    Example:
        A policy that restarts a node when its topic has stopped::

            class Restarts(Policy):
                def act(self, observation, action_mask):
                    stopped = (observation["frequencies"] == 0) & (observation["frequencies_missing"] == 0)
                    return self.actions.names.index("restart camera") if stopped[0] else 0
    """

    patience = 1
    symptoms: Symptoms
    _waited = 0
    _before: tuple[str, ...] = ()

    def act(self, observation: dict[str, Array], action_mask: Mask) -> int | Awaitable[int]:
        """Return the number of an action, or what can be awaited for it; override this.

        Args:
            observation: as of `Sight.arrays`.
            action_mask: (number of actions,) 1 for each action that can have an effect.
        """
        raise NotImplementedError(f"{type(self).__name__} has no method act.")

    async def adapt(self, symptoms: Symptoms) -> None:  # type: ignore[override]  # it may be a coroutine
        """Go on with an action, or begin the action that `act` chooses."""
        self.symptoms = symptoms
        if self.actions.proceed(symptoms) or self._waits():
            return
        choice = self.act(*self.view(symptoms))
        self.actions.begin(int(await choice if isinstance(choice, Awaitable) else choice))

    def _waits(self) -> bool:
        """Return whether to wait for another situation."""
        if 0 < self._waited < self.patience and self.situation == self._before:
            self._waited += 1
            return True
        self._waited, self._before = 1, self.situation if self.patience > 1 else ()
        return False

    @property
    def situation(self) -> tuple[str, ...]:
        """What differs from a healthy system, in words."""
        return self.sight.situation(self.symptoms)

    def view(self, symptoms: Symptoms) -> tuple[dict[str, Array], Mask]:
        """Return the arguments of `act`."""
        return self.sight.arrays(symptoms), self.mask

    @property
    def mask(self) -> Mask:
        """(number of actions,) 1 for each action that can have an effect."""
        return np.array(self.actions.allowed(self.symptoms), np.int8)

    @cached_property
    def actions(self) -> Actions:
        """The actions, by number."""
        return Actions(self)

    @cached_property
    def sight(self) -> Sight:
        """The way in which symptoms become observations."""
        return Sight(self, self.actions)


def _numbers(
    symptoms: Symptoms, entries: Iterable[str]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """Return the numbers of entries, 0 for missing ones, and which are missing."""
    values = np.array([symptoms.get(entry, np.nan) for entry in entries], np.float64)
    missing = np.isnan(values)
    return np.where(missing, 0.0, values), missing


def _text(value: Value) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
