"""What became of each fault under a managing system: cured, masked or neither, and which adaptations treated none.

- A fault is *cured* when an adaptation has ended it, or has kept one that was away from coming again. One that lives in
  the world does not end, but is worked around: it is cured from when on all steps of a cure are in place, if they are
  so until the fault heals or the experiment ends, and for a second at least.
- It is *masked* while it is there and no cure of it is in place, its symptom does not hold although frames come,
  something that the managing system has set is in place (or was in one of the last five frames, of which a symptom is
  the mean) at the failing node or upstream of it, which is no step of its cure, and the mean IoU of such a stretch,
  which lasts a second at least, is under 0.85 of that of the healthy frames. These are the frames before the first
  fault and the first adaptation; where there are fewer than five of them, the IoU does not matter. A frame without
  truth counts as those around it, and on a flight without any truth nothing can be called masked.
- An adaptation is *mistreating* if it treats no fault: it is a step of no cure of a fault that is there, or away for a
  while, and does not set something back to what it was at first. While a fault is away, it is treated by what keeps it
  from coming again, or is in place when it does. What is in place already is no step of a cure. Parts of a restart are
  steps of it, and so is the strength that undoes enough of a fault, of a node that a cure activates. A call that sets
  several parameters is one for each, less those that it leaves as they were beside one that treats a fault.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.metrics.adaptations import ExecutedAdaptation, affects
from sunset.metrics.episodes import Episode
from sunset.metrics.limits import Amount
from sunset.metrics.settings import Settings, Stretch, settings_of
from sunset.metrics.timeline import Injection, Timeline, Times, Values
from sunset.system import (
    SILENCE_S,
    WINDOW,
    Adaptation,
    AdaptationKind,
    FaultKind,
    Key,
    find_fault,
    get_fault,
    goal_of,
)

FATES: Final = ("cured", "masked", "missed")
"""What can become of a fault."""

MASKING_SHARE: Final = 0.85
"""A fault is masked only if the IoU is under this share of that of healthy frames."""

_PARTS_OF_RESTART: Final = frozenset({"deactivate", "cleanup", "configure", "activate"})


@dataclass(frozen=True, slots=True)
class FaultOutcome:
    """What became of one fault.

    Attributes:
        fault: its name.
        failure: what it shows as.
        began: when it came [s].
        until: when it healed, was ended by an adaptation or the experiment ended [s].
        cured: from when on it was cured, which may be while it was away [s]; None if it was not.
        masked_s: how long it was masked [s]; None where no frame has a truth.
        diagnosed: when it was first part of a right diagnosis [s]; None if it was not, or none was published.
    """

    fault: str
    failure: str
    began: Amount
    until: Amount
    cured: Amount | None = None
    masked_s: Amount | None = 0.0
    diagnosed: Amount | None = None

    @property
    def fate(self) -> str:
        """`cured`; or `masked`, of one that was so for a while; or `missed`."""
        return "cured" if self.cured is not None else "masked" if self.masked_s else "missed"

    @property
    def observed_s(self) -> float:
        """How long it was there without a cure [s]; one that is cured while it is away was there until then."""
        return (self.until if self.cured is None else min(self.until, self.cured)) - self.began


class Treatments:
    """What a managing system did about the faults of a run, and what became of them.

    Args:
        timeline: of the run.
        executed: its adaptations, in order of time.
    """

    def __init__(self, timeline: Timeline, executed: Sequence[ExecutedAdaptation]) -> None:
        self._timeline = timeline
        self._executed = executed
        self._settings = Settings(timeline.settings)
        self.faults = _faults_there(timeline)
        """The faults, in order of time; one that is injected again while it is there is the same one."""

    def mistreating(self) -> tuple[ExecutedAdaptation, ...]:
        """Return the adaptations that treat no fault and set nothing back; of a call, each parameter by itself."""
        return tuple(part for call in self._executed for part in self._mistreating_parts(call))

    def _mistreating_parts(self, call: ExecutedAdaptation) -> list[ExecutedAdaptation]:
        parts = _parts(call)
        treating = [part for part in parts if any(self._treats(part, fault) for fault in self.faults)]
        return [
            part
            for part in parts
            if part not in treating
            and not self._sets_back(part)
            # beside a treatment, what is set as it was is no harm
            and not (treating and self._is_set(part))
        ]

    def _is_set(self, adaptation: ExecutedAdaptation) -> bool:
        """Return whether all that an adaptation sets is so already."""
        return all(self._settings.at(key, adaptation.time) == value for key, value in settings_of(adaptation))

    def outcomes(self, episodes: Sequence[Episode]) -> tuple[tuple[FaultOutcome, ...], float | None]:
        """Return what became of each fault, and for how long any of them was masked [s].

        The time is None where there is no fault, or no frame has a truth.

        Args:
            episodes: those of all failures, which say when symptoms held.
        """
        period_s, found = self._timeline.period_s, list(map(self._outcome, self.faults))
        if not (found and self._timeline.has_truth):
            return tuple(replace(outcome, masked_s=None) for outcome in found), None
        masked = [self._masked(outcome, episodes) for outcome in found]
        lengths = [round(int(frames.sum()) * period_s, 9) for frames in masked]
        total = round(int(np.any(masked, axis=0).sum()) * period_s, 9)
        pairs = zip(found, lengths, strict=True)
        return tuple(replace(outcome, masked_s=length) for outcome, length in pairs), total

    def _outcome(self, fault: Injection) -> FaultOutcome:
        end = self._timeline.duration_s
        until = end if fault.ended is None else min(fault.ended, end)
        around = [
            start
            for start, stop in self._settings.around(fault.fault, fault.time, until)
            if stop >= until and stop - start >= SILENCE_S
        ]
        cured = min(around, default=None)
        ended_by_cure = fault.ended if fault.cause else fault.cured_away
        is_treated = any(self._treats(adaptation, fault) for adaptation in self._executed)
        if ended_by_cure is not None and ended_by_cure <= end and is_treated:
            cured = ended_by_cure  # without an adaptation, its process has ended by itself
        return FaultOutcome(fault.fault, fault.failure, fault.time, until, cured)

    def _treats(self, adaptation: ExecutedAdaptation, fault: Injection) -> bool:
        """Return whether an adaptation is a step of a cure of a fault that is there, or away until it comes."""
        is_there = any(
            fault.time <= moment and (fault.over is None or moment < fault.over)
            for moment in adaptation.moments
        )
        described = find_fault(fault.fault)
        lives_on = described is not None and described.kind is FaultKind.EXTERNAL
        if not (is_there or (lives_on and self._is_awaited(fault, adaptation.time))):
            return False
        done = [
            (key, value)
            for key, value in settings_of(adaptation)
            if not lives_on or self._works_around(key, value, adaptation.time, fault.time)
        ]
        return any(
            _is_step(adaptation, step, done) or self._sets_strength(step, done, fault, adaptation.time)
            for cure in _cures(fault.fault)
            for step in cure
        )

    def _sets_strength(
        self, step: Adaptation, done: Sequence[tuple[Key, str]], fault: Injection, time: float
    ) -> bool:
        """Return whether a node that a cure activates is set to undo enough of a fault, as it is then or comes."""
        described = get_fault(fault.fault)
        amounts = [value for key, value in done if key == (step.node, described.parameter)]
        strength = self._settings.at((described.node, described.parameter), max(time, fault.time))
        return (
            step.kind is AdaptationKind.ACTIVATE and bool(amounts) and described.is_undone(strength, amounts)
        )

    def _is_awaited(self, fault: Injection, time: float) -> bool:
        """Return whether a fault has healed at a time, and comes again as this one."""
        earlier = [other for other in self.faults if other.fault == fault.fault and other.time < fault.time]
        return bool(earlier) and earlier[-1].healed is not None and earlier[-1].healed <= time < fault.time

    def _works_around(self, key: Key, value: str, time: float, onset: float) -> bool:
        """Return whether what is set was not set already, and stays so until the onset of the fault."""
        return self._settings.at(key, time) != value and (
            time >= onset or self._settings.until(key, value, time, onset) == onset
        )

    def _sets_back(self, adaptation: ExecutedAdaptation) -> bool:
        """Return whether all that an adaptation changes is set back to what it was at first, and no cure taken away."""
        there = [fault.fault for fault in self.faults if fault.is_there(adaptation.time)]
        cures = [goal_of(step) for fault in there for cure in _cures(fault) for step in cure]
        changed = [
            (key, present, value)
            for key, value in settings_of(adaptation)
            if (present := self._settings.at(key, adaptation.time)) not in {value, None}
        ]
        return bool(changed) and all(
            value == self._settings.first(key) and (key, present) not in cures
            for key, present, value in changed
        )

    def _masked(self, outcome: FaultOutcome, episodes: Sequence[Episode]) -> npt.NDArray[np.bool_]:
        """Return of each frame that was evaluated, or lacks a truth, whether a fault was masked in it."""
        times, iou, period_s = *self._iou_over_time, self._timeline.period_s
        end, masked = self._timeline.duration_s, np.zeros(len(times), dtype=bool)
        hidden = (times >= outcome.began) & (times < outcome.began + outcome.observed_s)
        for episode in episodes:
            if episode.failure == outcome.failure:
                hidden &= (times < episode.holds) | (
                    times >= (end if episode.ended is None else episode.ended)
                )
        for start, stop in self._settings.around(outcome.fault, outcome.began, outcome.until):
            hidden &= (times < start) | (times >= stop)
        changed = np.zeros(len(times), dtype=bool)
        for start, stop in self._changes(outcome):
            lasts = stop - start >= period_s  # what a node sets back at once is an act, and masks nothing
            changed |= lasts & (times >= start) & (times < stop + WINDOW.samples * period_s)
        for first, last in _stretches_of(hidden & changed, times, period_s):
            known = iou[first:last][~np.isnan(iou[first:last])]
            if len(known):
                is_bad = self._healthy is None or known.mean() < MASKING_SHARE * self._healthy
                masked[first:last] = is_bad and (last - first) * period_s >= SILENCE_S
        return masked

    def _changes(self, outcome: FaultOutcome) -> list[Stretch]:
        """Return when something was in place that the managing system has set, and that can mask a fault.

        It is of the failing node or of one upstream of it, and no step of a cure of the fault.
        """
        cures = [goal_of(step) for cure in _cures(outcome.fault) for step in cure]
        return [
            (adaptation.time, self._settings.until(key, value, adaptation.time, self._timeline.duration_s))
            for adaptation in self._executed
            if affects(adaptation.node, outcome.failure)
            for key, value in settings_of(adaptation)
            if value != self._settings.first(key) and (key, value) not in cures
        ]

    def cured_for_a_while(self, outcome: FaultOutcome) -> list[Stretch]:
        """Return when a cure was in place of a fault that lives in the world, but did not stay so."""
        stretches = self._settings.around(outcome.fault, outcome.began, outcome.until)
        return [
            (start, stop) for start, stop in stretches if stop < outcome.until and stop - start >= SILENCE_S
        ]

    @cached_property
    def _iou_over_time(self) -> tuple[Times, Values]:
        """When frames were taken [s], and the IoU of each; NaN of one without truth."""
        frames, without_truth = self._timeline.frames, self._timeline.without_truth
        times = np.concatenate([frames.times, without_truth])
        order = np.argsort(times, kind="stable")
        return times[order], np.concatenate([frames.iou, np.full(len(without_truth), np.nan)])[order]

    @cached_property
    def _healthy(self) -> float | None:
        """The mean IoU of the frames before the first fault and the first adaptation; None of too few."""
        moments = [fault.time for fault in self.faults[:1]] + [
            adaptation.time for adaptation in self._executed[:1]
        ]
        frames = self._timeline.frames
        iou = frames.iou[frames.times < min(moments, default=self._timeline.duration_s)]
        return float(iou.mean()) if len(iou) >= WINDOW.samples else None


def _stretches_of(
    shown: npt.NDArray[np.bool_], times: npt.NDArray[np.float64], period_s: float
) -> Iterator[tuple[int, int]]:
    """Yield from which to before which frame they follow one another and all are so; none is lost between them."""
    places = np.flatnonzero(shown)
    breaks = np.flatnonzero((np.diff(places) > 1) | (np.diff(times[places]) > 1.5 * period_s)) + 1
    for stretch in np.split(places, breaks):
        if len(stretch):
            yield int(stretch[0]), int(stretch[-1]) + 1


def _parts(adaptation: ExecutedAdaptation) -> list[ExecutedAdaptation]:
    """Return an adaptation for each parameter that one call sets; any other adaptation as it is.

    So nobody hides what treats nothing in one call with what does.
    """
    pairs = zip(adaptation.parameters, adaptation.values, strict=True)
    return [replace(adaptation, parameters=(name,), values=(value,)) for name, value in pairs] or [adaptation]


def _faults_there(timeline: Timeline) -> list[Injection]:
    there: list[Injection] = []
    for injection in timeline.injections:
        same = [place for place, fault in enumerate(there) if fault.fault == injection.fault]
        if same and there[same[-1]].is_there(injection.time):
            last = there[same[-1]]
            there[same[-1]] = replace(injection, time=last.time)
        elif injection.time < timeline.duration_s:
            there.append(injection)
    return there


def _cures(fault: str) -> tuple[tuple[Adaptation, ...], ...]:
    """Return the cures of a fault; an empty tuple for a fault of another version's catalogue."""
    described = find_fault(fault)
    return described.cures if described else ()


def _is_step(adaptation: ExecutedAdaptation, step: Adaptation, done: Sequence[tuple[Key, str]]) -> bool:
    """Return whether an adaptation performs a cure's step, or a part of it; `done`: its settings that count."""
    setting = goal_of(step)
    if setting in done:
        return True
    if adaptation.node != step.node:
        return False
    is_part = step.kind is AdaptationKind.RESTART and adaptation.kind in _PARTS_OF_RESTART
    return setting is None and (adaptation.kind == step.kind or is_part)
