"""The spaces of observations, and observations in their three forms."""

import string
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
from gymnasium import spaces
from gymnasium.spaces import GraphInstance

from sunset.managing.actions import action_names
from sunset.managing.policy import LIMITS, STATES, Sight
from sunset.managing.symptoms import Symptoms
from sunset.system import current_system

_LONGEST: Final = 20_000
"""Characters of a text."""


def _arrays() -> "spaces.Space[Any]":
    system = current_system()
    nodes, signals, topics = len(system.nodes), len(system.signals), len(system.topics)
    shapes: Mapping[str, tuple[int, ...]] = {
        "signals": (signals,),
        "states": (nodes, len(STATES)),
        "heartbeats": (nodes,),
        "frequencies": (topics,),
        "settings": (sum(bool(step.parameter) for step in system.adaptations),),
        "since": (len(action_names()) - 1,),
    }
    boxes: dict[str, spaces.Space[Any]] = {
        part: spaces.Box(*limits, shapes[part.removesuffix("_missing")], np.float32)
        for part, limits in LIMITS.items()
    }
    return spaces.Dict(boxes)


def _graph() -> "spaces.Space[Any]":
    system = current_system()
    setters = sum(bool(step.parameter) for step in system.adaptations)
    features = len(STATES) + 2 + 2 * len(system.signals) + setters + len(system.adaptations)
    lowest, highest = (
        limit(limits[place] for limits in LIMITS.values()) for place, limit in ((0, min), (1, max))
    )
    return spaces.Graph(
        spaces.Box(lowest, highest, (features,), np.float32),
        spaces.Box(*LIMITS["frequencies"], (2,), np.float32),
    )


def _text() -> "spaces.Space[Any]":
    return spaces.Text(_LONGEST, min_length=0, charset=string.printable)


def _graph_of(sight: Sight, symptoms: Symptoms) -> GraphInstance:
    return GraphInstance(*sight.graph(symptoms))


Form = tuple[Callable[[], "spaces.Space[Any]"], Callable[[Sight, Symptoms], Any]]
FORMS: Final[Mapping[str, Form]] = {
    "arrays": (_arrays, Sight.arrays),
    "graph": (_graph, _graph_of),
    "text": (_text, Sight.text),
}
"""Form of an observation → a function that makes its space, and a function that makes an observation."""
