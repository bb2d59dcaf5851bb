"""Parameters and lifecycle states of the managed system over time, as the nodes reported them."""

import itertools
from bisect import bisect_right
from collections.abc import Sequence
from functools import partial

from sunset.metrics.adaptations import ExecutedAdaptation
from sunset.metrics.timeline import Setting
from sunset.system import (
    STATE,
    AdaptationKind,
    FaultKind,
    Key,
    comparable_text,
    current_system,
    find_fault,
    goal_of,
    is_in_place,
    short_name,
)

Stretch = tuple[float, float]
"""From when to when [s], the end not included."""


class Settings:
    """Every parameter and lifecycle state over time, from settings in order of time."""

    def __init__(self, settings: Sequence[Setting]) -> None:
        self._times: dict[Key, list[float]] = {}
        self._values: dict[Key, list[str]] = {}
        self._first: dict[Key, str] = {
            (node, STATE): state for node, state in current_system().initial_states.items()
        }
        for setting in settings:
            key = short_name(setting.node), setting.name
            value = comparable_text(key, setting.value)
            if setting.declared:
                self._first.setdefault(key, value)
            values = self._values.setdefault(key, [])
            if values[-1:] != [value]:
                self._times.setdefault(key, []).append(setting.time)
                values.append(value)

    def at(self, key: Key, time: float) -> str | None:
        """Return the value at a time; None if it is unknown."""
        place = bisect_right(self._times.get(key, []), time)
        return self._values[key][place - 1] if place else self._first.get(key)

    def in_place(self, name: str, start: float, end: float) -> list[Stretch]:
        """Return when a cure of an external fault was in place within `[start, end)`; empty for any other fault."""
        fault = find_fault(name)  # a record may be of another version
        if fault is None or fault.kind is not FaultKind.EXTERNAL:
            return []
        steps = [step for cure in fault.cures for step in cure]
        goals = [goal[0] for step in steps if (goal := goal_of(step))]
        keys = [(fault.node, fault.parameter), *((step.node, fault.parameter) for step in steps), *goals]
        moments = {time for key in keys for time in self._times.get(key, []) if start < time < end}
        stretches: list[Stretch] = []
        for begin, following in itertools.pairwise([start, *sorted(moments), end]):
            setting = partial(self.at, time=begin)
            if begin < following and any(is_in_place(fault, cure, setting) for cure in fault.cures):
                since = stretches.pop()[0] if stretches and stretches[-1][1] == begin else begin
                stretches.append((since, following))
        return stretches


def settings_of(adaptation: ExecutedAdaptation) -> list[tuple[Key, str]]:
    """Return the parameters or the state that an adaptation sets, with their values."""
    if adaptation.parameters:
        pairs = zip(adaptation.parameters, adaptation.values, strict=True)
        keys = [((adaptation.node, name), value) for name, value in pairs]
        return [(key, comparable_text(key, value)) for key, value in keys]
    states = (kind.goal_state for kind in AdaptationKind if kind == adaptation.kind)
    return [((adaptation.node, STATE), state) for state in states if state is not None]
