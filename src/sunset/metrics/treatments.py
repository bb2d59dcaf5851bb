"""The outcome of each fault, and needless adaptations, as `docs/metrics.md` defines them."""

import itertools
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import itemgetter
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.metrics.adaptations import ExecutedAdaptation, executed_adaptations
from sunset.metrics.episodes import Episode
from sunset.metrics.timeline import Amount, Injection, Setting, Timeline
from sunset.system import (
    SILENCE_S,
    STATE,
    Adaptation,
    AdaptationKind,
    Fault,
    FaultKind,
    Key,
    comparable_text,
    current_system,
    find_fault,
    goal_of,
    is_in_place,
    short_name,
)

FATES: Final = ("cured", "masked", "missed")
"""The fates of a fault."""

MASKING_SHARE: Final = 0.85
"""A fault is masked only in frames whose IoU is under this share of the healthy IoU."""

_PARTS_OF_RESTART: Final = frozenset({"restart", "deactivate", "cleanup", "configure", "activate"})

Stretch = tuple[float, float]
"""From when to when [s], the end not included."""


class Settings:
    """Every parameter and lifecycle state over time, from settings in order of time."""

    def __init__(self, settings: Sequence[Setting]) -> None:
        self._changes: defaultdict[Key, list[tuple[float, str]]] = defaultdict(list)
        self._first: dict[Key, str] = {
            (node, STATE): state for node, state in current_system().initial_states.items()
        }
        for setting in settings:
            key = short_name(setting.node), setting.name
            value = comparable_text(key, setting.value)
            if setting.declared:
                self._first.setdefault(key, value)
            self._changes[key].append((setting.time, value))

    def at(self, key: Key, time: float) -> str | None:
        """Return the value at a time; None if it is unknown."""
        changes = self._changes.get(key, [])
        place = bisect_right(changes, time, key=itemgetter(0))
        return changes[place - 1][1] if place else self._first.get(key)

    def in_place(self, name: str, start: float, end: float) -> list[Stretch]:
        """Return when a cure of an external fault was in place within `[start, end)`; empty for any other fault."""
        fault = find_fault(name)  # a record may be of another version
        if fault is None or fault.kind is not FaultKind.EXTERNAL:
            return []
        steps = [step for cure in fault.cures for step in cure]
        goals = [goal[0] for step in steps if (goal := goal_of(step))]
        keys = [(fault.node, fault.parameter), *((step.node, fault.parameter) for step in steps), *goals]
        moments = {time for key in keys for time, _ in self._changes.get(key, []) if start < time < end}
        stretches: list[Stretch] = []
        for begin, following in itertools.pairwise([start, *sorted(moments), end]):
            setting = partial(self.at, time=begin)
            if begin < following and any(is_in_place(fault, cure, setting) for cure in fault.cures):
                since = stretches.pop()[0] if stretches and stretches[-1][1] == begin else begin
                stretches.append((since, following))
        return stretches


@dataclass(frozen=True, slots=True)
class FaultOutcome:
    """The outcome of a fault.

    Attributes:
        failure: the failure that it shows as.
        began: its onset [s].
        until: when it healed, an adaptation ended it, or the experiment ended [s].
        cured: when it was cured, also while it was away [s]; None if it was not.
        uncured_s: how long it was present without a cure in place [s].
        masked_s: how long it was masked [s]; None where no frame has a truth.
    """

    fault: str
    failure: str
    began: Amount
    until: Amount
    cured: Amount | None = None
    uncured_s: Amount = 0.0
    masked_s: Amount | None = 0.0

    @property
    def fate(self) -> str:
        """One of `FATES`."""
        return "cured" if self.cured is not None else "masked" if self.masked_s else "missed"


def faults_of(timeline: Timeline) -> tuple[Injection, ...]:
    """Return the faults, in order of time; a present fault that is injected again is the same fault."""
    faults: list[Injection] = []
    for injection in timeline.injections:
        same = [place for place, fault in enumerate(faults) if fault.fault == injection.fault]
        if same and faults[same[-1]].is_there(injection.time):
            faults[same[-1]] = replace(injection, time=faults[same[-1]].time)
        elif injection.time < timeline.duration_s:
            faults.append(injection)
    return tuple(faults)


def faults_cured(timeline: Timeline) -> int:
    """Return how many faults are cured, as `fault_outcomes` counts them."""
    settings = Settings(timeline.settings)
    executed = executed_adaptations(timeline.commands, until_s=timeline.duration_s)
    parts = [part for call in executed for part in call.parts]
    return sum(
        _cured(
            fault,
            settings.in_place(fault.fault, fault.time, _until(fault, timeline)),
            parts,
            timeline.duration_s,
        )
        is not None
        for fault in faults_of(timeline)
    )


def _until(fault: Injection, timeline: Timeline) -> float:
    """Return when a fault ended, or the experiment [s]."""
    return timeline.duration_s if fault.ended is None else min(fault.ended, timeline.duration_s)


def fault_outcomes(
    timeline: Timeline,
    faults: Sequence[Injection],
    episodes: Sequence[Episode],
    parts: Sequence[ExecutedAdaptation],
    healthy: float | None,
) -> tuple[tuple[FaultOutcome, ...], float | None]:
    """Return the outcome of each fault, and for how long any of them was masked [s].

    The time is None without a fault, or where no frame has a truth. Episodes say when symptoms held, `parts` are the
    adaptations, in order of time, separately for each parameter of a call, and `healthy` is the mean IoU of healthy
    frames, if there are any.
    """
    settings = Settings(timeline.settings)
    is_bad = timeline.frames.iou < MASKING_SHARE * (healthy or 0.0)
    outcomes, masks = [], []
    for fault in faults:
        until = _until(fault, timeline)
        in_place = settings.in_place(fault.fault, fault.time, until)
        hidden = _hidden(timeline, fault, until, episodes=episodes, parts=parts, in_place=in_place)
        masks.append(is_bad & hidden)
        covered_s = sum(stop - start for start, stop in in_place)
        outcomes.append(
            FaultOutcome(
                fault=fault.fault,
                failure=fault.failure,
                began=fault.time,
                until=until,
                cured=_cured(fault, in_place, parts, timeline.duration_s),
                uncured_s=max(0.0, round(until - fault.time - covered_s, 9)),
                masked_s=_seconds(masks[-1], timeline) if timeline.has_truth else None,
            )
        )
    has_masks = bool(outcomes) and timeline.has_truth
    return tuple(outcomes), _seconds(np.any(masks, axis=0), timeline) if has_masks else None


def _cured(
    fault: Injection, in_place: Sequence[Stretch], parts: Sequence[ExecutedAdaptation], duration_s: float
) -> float | None:
    """Return when a fault was cured: an adaptation ended it, or a cure was in place for a second."""
    moments = [start for start, stop in in_place if stop - start >= SILENCE_S]
    ended = fault.ended if fault.cause else fault.cured_away
    # a process may also end without an adaptation
    if ended is not None and ended <= duration_s and any(treats(part, fault) for part in parts):
        moments.append(ended)
    return min(moments, default=None)


def treats(adaptation: ExecutedAdaptation, fault: Injection) -> bool:
    """Return whether an adaptation of one parameter performs a step, or a part of it, of a cure of a present fault.

    A fault that comes and goes is present until an adaptation has cured it while it was away.
    """
    described = find_fault(fault.fault)  # a record may be of another version
    if described is None:
        return False
    is_there = any(
        fault.time <= moment and (fault.over is None or moment < fault.over) for moment in adaptation.moments
    )
    return is_there and any(
        _performs(adaptation, step, described) for cure in described.cures for step in cure
    )


def _settings_of(adaptation: ExecutedAdaptation) -> list[tuple[Key, str]]:
    """Return the parameters or the state that an adaptation sets, with their values."""
    node, pairs = adaptation.node, zip(adaptation.parameters, adaptation.values, strict=True)
    texts = [((node, name), comparable_text((node, name), value)) for name, value in pairs]
    states = (kind.goal_state for kind in AdaptationKind if kind == adaptation.kind)
    return texts + [((node, STATE), state) for state in states if state is not None]


def _performs(adaptation: ExecutedAdaptation, step: Adaptation, fault: Fault) -> bool:
    goal = goal_of(step)
    if goal is not None and goal in _settings_of(adaptation):
        return True
    if adaptation.node != step.node:
        return False
    if step.kind is AdaptationKind.ACTIVATE:
        # the strength at which the node that is activated undoes the fault
        return fault.parameter in adaptation.parameters
    if step.kind is AdaptationKind.RESTART:
        return adaptation.kind in _PARTS_OF_RESTART
    return goal is None and adaptation.kind == step.kind


def _hidden(
    timeline: Timeline,
    fault: Injection,
    until: float,
    *,
    episodes: Sequence[Episode],
    parts: Sequence[ExecutedAdaptation],
    in_place: Sequence[Stretch],
) -> npt.NDArray[np.bool_]:
    """Return of each frame whether a fault is uncured, but its symptom has gone after an adaptation."""
    times = timeline.frames.times
    ours = [episode for episode in episodes if episode.failure == fault.failure]
    gone = [
        episode.ended
        for episode in ours
        if episode.ended is not None and any(fault.time <= part.time <= episode.ended for part in parts)
    ]
    hidden = (times >= max(fault.time, min(gone, default=until))) & (times < until)
    held = [
        (episode.holds, timeline.duration_s if episode.ended is None else episode.ended) for episode in ours
    ]
    for start, stop in (*held, *in_place):
        hidden &= (times < start) | (times >= stop)
    return hidden


def _seconds(frames: npt.NDArray[np.bool_], timeline: Timeline) -> float:
    return round(int(frames.sum()) * timeline.period_s, 9)
