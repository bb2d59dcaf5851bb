"""What became of each fault, and which adaptations were needless, as `docs/metrics.md` defines it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.metrics.adaptations import ExecutedAdaptation
from sunset.metrics.episodes import Episode
from sunset.metrics.limits import Amount
from sunset.metrics.settings import Settings, settings_of
from sunset.metrics.timeline import Injection, Timeline
from sunset.system import SILENCE_S, Adaptation, AdaptationKind, Fault, find_fault, goal_of

FATES: Final = ("cured", "masked", "missed")
"""What can become of a fault."""

MASKING_SHARE: Final = 0.85
"""A fault is masked only in frames whose IoU is under this share of the healthy one."""

_PARTS_OF_RESTART: Final = frozenset({"restart", "deactivate", "cleanup", "configure", "activate"})


@dataclass(frozen=True, slots=True)
class FaultOutcome:
    """What became of one fault.

    Attributes:
        fault: its name.
        failure: what it shows as.
        began: its onset [s].
        until: when it healed, an adaptation ended it, or the experiment ended [s].
        cured: since when it was cured, which may be while it was away [s]; None if it was not.
        uncured_s: how long it was there without a cure in place [s].
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
        """`cured`; or `masked`, if it was masked for a while; or `missed`."""
        return "cured" if self.cured is not None else "masked" if self.masked_s else "missed"


def faults_of(timeline: Timeline) -> tuple[Injection, ...]:
    """Return the faults, in order of time; one that is injected again while it is there is the same fault."""
    there: list[Injection] = []
    for injection in timeline.injections:
        same = [place for place, fault in enumerate(there) if fault.fault == injection.fault]
        if same and there[same[-1]].is_there(injection.time):
            last = there[same[-1]]
            there[same[-1]] = replace(injection, time=last.time)
        elif injection.time < timeline.duration_s:
            there.append(injection)
    return tuple(there)


def fault_outcomes(
    timeline: Timeline,
    faults: Sequence[Injection],
    episodes: Sequence[Episode],
    parts: Sequence[ExecutedAdaptation],
    healthy: float | None,
) -> tuple[tuple[FaultOutcome, ...], float | None]:
    """Return what became of each fault, and for how long any of them was masked [s].

    The time is None where there is no fault, or no frame has a truth.

    Args:
        timeline: of the run.
        faults: its faults.
        episodes: those of all failures, which say when symptoms held.
        parts: its adaptations, in order of time; a call that sets several parameters is one for each.
        healthy: the mean IoU of healthy frames; None if there is none.
    """
    settings = Settings(timeline.settings)
    found, masks = [], []
    for fault in faults:
        until = timeline.duration_s if fault.ended is None else min(fault.ended, timeline.duration_s)
        in_place = settings.in_place(fault.fault, fault.time, until)
        lasting = [start for start, stop in in_place if stop - start >= SILENCE_S]
        ended = fault.ended if fault.cause else fault.cured_away
        # a process may also end by itself
        is_treated = any(_treats(part, fault) for part in parts)
        ends = [ended] if ended is not None and ended <= timeline.duration_s and is_treated else []
        hidden = _hidden(timeline, fault, until, episodes, parts)
        for start, stop in in_place:
            hidden &= (timeline.frames.times < start) | (timeline.frames.times >= stop)
        masks.append(hidden & (timeline.frames.iou < MASKING_SHARE * (healthy or 0.0)))
        covered = sum(stop - start for start, stop in in_place)
        found.append(
            FaultOutcome(
                fault=fault.fault,
                failure=fault.failure,
                began=fault.time,
                until=until,
                cured=min([*lasting, *ends], default=None),
                uncured_s=max(0.0, round(until - fault.time - covered, 9)),
                masked_s=_seconds(masks[-1], timeline) if timeline.has_truth else None,
            )
        )
    if not (found and timeline.has_truth):
        return tuple(found), None
    return tuple(found), _seconds(np.any(masks, axis=0), timeline)


def needless_adaptations(
    parts: Sequence[ExecutedAdaptation], faults: Sequence[Injection]
) -> tuple[ExecutedAdaptation, ...]:
    """Return the adaptations that are no step of a cure of any fault that was there at the time.

    A fault that comes and goes is there until an adaptation has cured it while it was away.

    Args:
        parts: the adaptations; a call that sets several parameters is one for each.
        faults: those of the run.
    """
    return tuple(part for part in parts if not any(_treats(part, fault) for fault in faults))


def _treats(adaptation: ExecutedAdaptation, fault: Injection) -> bool:
    """Return whether an adaptation performs a step, or a part of one, of a cure of a fault that is there."""
    described = find_fault(fault.fault)  # that of a record may be of another version
    if described is None:
        return False
    is_there = any(
        fault.time <= moment and (fault.over is None or moment < fault.over) for moment in adaptation.moments
    )
    return is_there and any(
        _performs(adaptation, step, described) for cure in described.cures for step in cure
    )


def _performs(adaptation: ExecutedAdaptation, step: Adaptation, fault: Fault) -> bool:
    goal = goal_of(step)
    if goal is not None and goal in settings_of(adaptation):
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
    episodes: Sequence[Episode],
    executed: Sequence[ExecutedAdaptation],
) -> npt.NDArray[np.bool_]:
    """Return of each evaluated frame whether a fault is there and its symptom has gone after an adaptation."""
    times = timeline.frames.times
    ours = [episode for episode in episodes if episode.failure == fault.failure]
    gone = [
        episode.ended
        for episode in ours
        if episode.ended is not None
        and any(fault.time <= adaptation.time <= episode.ended for adaptation in executed)
    ]
    hidden = (times >= max(fault.time, min(gone, default=until))) & (times < until)
    for episode in ours:
        stop = timeline.duration_s if episode.ended is None else episode.ended
        hidden &= (times < episode.holds) | (times >= stop)
    return hidden


def _seconds(frames: npt.NDArray[np.bool_], timeline: Timeline) -> float:
    return round(int(frames.sum()) * timeline.period_s, 9)
