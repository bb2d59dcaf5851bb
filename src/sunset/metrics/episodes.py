"""Failure episodes: when the symptom held, when the failure began, and which adaptation resolved it.

`docs/metrics.md` has the definitions, which the paper leaves open, under *The paper's five figures*.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from sunset.metrics.adaptations import ExecutedAdaptation, affects
from sunset.metrics.timeline import TOLERANCE_S, Injection, Samples, Timeline
from sunset.system import (
    GAP_S,
    SILENCE_S,
    Failure,
    MovingMean,
    Signal,
    current_system,
    full_name,
    short_name,
)


@dataclass(frozen=True, slots=True)
class Spell:
    """A time in which a symptom held.

    Attributes:
        origin: the evidence: the last message before the silence, or the first sample of the window [s].
        holds: when the symptom began to hold [s].
        ended: when it stopped [s]; None if it held to the end.
        turned: the time from which on all samples were on the right side of the threshold [s]; None for a silence.
    """

    origin: float
    holds: float
    ended: float | None
    turned: float | None = None


@dataclass(frozen=True, slots=True)
class Episode:
    """An occurrence of a failure.

    Attributes:
        failure: such as `F1`.
        began: when the failure began [s].
        holds: when its symptom began to hold [s].
        ended: when its symptom stopped [s]; None if it held to the end.
        injected: whether a fault of this failure caused it; False for a ripple or a relapse.
        adaptation: the adaptation that resolved it; None if it is unresolved.
    """

    failure: str
    began: float
    holds: float
    ended: float | None
    injected: bool
    adaptation: ExecutedAdaptation | None

    @property
    def resolved(self) -> bool:
        """Whether it ended after an adaptation that can have ended it."""
        return self.adaptation is not None

    @property
    def subsided(self) -> bool:
        """Whether it ended without being resolved."""
        return self.ended is not None and self.adaptation is None

    @property
    def t_detect(self) -> float:
        """From when it began to when its symptom held [s]."""
        return self.holds - self.began

    @property
    def t_decide(self) -> float | None:
        """From when its symptom held to the command [s]; negative if the command came first."""
        return None if self.adaptation is None else self.adaptation.time - self.holds

    @property
    def t_react(self) -> float | None:
        """From when it began to the command [s]."""
        return None if self.adaptation is None else self.adaptation.time - self.began

    @property
    def t_repair(self) -> float | None:
        """From the command to when its symptom was gone [s]."""
        if self.adaptation is None or self.ended is None:
            return None
        return self.ended - self.adaptation.time


def silences(times: npt.NDArray[np.float64], *, duration_s: float) -> list[Spell]:
    """Return the spells in which a topic had no message for 1 s.

    Args:
        times: (N,) ascending, when its messages left [s], also before 0.
        duration_s: the end of the experiment; later messages do not count.

    >>> [(spell.origin, spell.holds, spell.ended) for spell in silences(np.array([0.0, 0.5, 3.0]), duration_s=5.0)]
    [(0.5, 1.5, 3.0), (3.0, 4.0, None)]
    """
    moments = times[times <= duration_s].tolist()
    if not moments or moments[0] > 0:
        moments.insert(0, 0.0)
    spells = [
        Spell(last, last + SILENCE_S, following)
        for last, following in itertools.pairwise(moments)
        if following - last > SILENCE_S + TOLERANCE_S
    ]
    if moments[-1] + SILENCE_S < duration_s - TOLERANCE_S:
        spells.append(Spell(moments[-1], moments[-1] + SILENCE_S, None))
    return _within(spells)


def excesses(samples: Samples, signal: Signal, threshold: float, *, duration_s: float) -> list[Spell]:
    """Return the spells in which the mean of a signal's last five samples was beyond a threshold.

    Args:
        samples: of the signal, also before 0.
        signal: says on which side of the threshold a mean is a symptom.
        threshold: a mean equal to it is not beyond it.
        duration_s: the end of the experiment; later samples do not count.
    """
    spells: list[Spell] = []
    holding: tuple[float, float] | None = None
    turned: float | None = None
    moving = MovingMean(GAP_S + TOLERANCE_S)
    early = samples.times <= duration_s
    for time, value in zip(samples.times[early].tolist(), samples.values[early].tolist(), strict=True):
        mean = moving.add(time, value)
        if signal.is_beyond(value, threshold):
            turned = None
        elif turned is None:
            turned = time
        if mean is None:
            continue
        beyond = signal.is_beyond(mean, threshold)
        if beyond and holding is None:
            holding = (moving.since, time)
        elif holding is not None and not beyond:
            spells.append(Spell(*holding, time, turned))
            holding = None
    return _within([*spells, Spell(*holding, None)] if holding else spells)


def _within(spells: Sequence[Spell]) -> list[Spell]:
    """Return the spells that hold after 0, from there on."""
    return [
        replace(spell, holds=max(spell.holds, 0.0))
        for spell in spells
        if spell.ended is None or spell.ended > 0
    ]


def failure_episodes(timeline: Timeline, adaptations: Sequence[ExecutedAdaptation]) -> tuple[Episode, ...]:
    """Return every episode of every failure, in order of the times at which their symptoms began to hold.

    The executed adaptations are in order of time.
    """
    episodes = [
        episode
        for failure in current_system().failures.values()
        for episode in _episodes(failure, spells_of(failure, timeline), timeline, adaptations)
    ]
    return tuple(sorted(episodes, key=lambda episode: (episode.holds, episode.failure)))


def spells_of(failure: Failure, timeline: Timeline) -> list[Spell]:
    """Return the spells in which a failure's symptom held."""
    duration = timeline.duration_s
    if failure.topic:
        times = timeline.message_times.get(full_name(failure.topic), np.empty(0))
        return silences(times, duration_s=duration)
    signal = current_system().signals[failure.signal]
    samples = timeline.samples.get(signal.name, Samples())
    threshold = timeline.thresholds[signal.threshold_name]
    return excesses(samples, signal, threshold, duration_s=duration)


def _episodes(
    failure: Failure, spells: Sequence[Spell], timeline: Timeline, adaptations: Sequence[ExecutedAdaptation]
) -> list[Episode]:
    """Return the episodes of a failure: when each spell's failure began, and the adaptation that resolved it."""
    faults = [injection for injection in timeline.injections if injection.failure == failure.name]
    episodes: list[Episode] = []
    begun: list[Injection] = []  # faults that have begun an episode, or came during an episode
    explaining: list[Injection] = []  # faults that explain a resolved episode
    for spell in spells:
        # injected again, a present fault is the same fault
        present = {fault.fault for fault in begun if fault.ended is None}
        due = [
            fault
            for fault in faults
            if fault not in begun and fault.fault not in present and fault.time <= spell.holds
        ]
        begun += due
        causes = [fault.time for fault in due if not _is_past(fault, spell, adaptations)]
        began = min(causes, default=max(spell.origin, 0.0))
        able = _able_faults(failure.name, spell, timeline.injections)
        candidates = [
            fault for fault in able if fault not in explaining and _is_behind(fault, failure.name, spell)
        ]
        resolving = _resolving(failure.name, began, spell.ended, adaptations) if candidates else None
        if resolving is not None and _healed(failure.name, spell, able, resolving):
            resolving = None
        if resolving is not None:  # faults of the failure itself first
            explaining.append(min(candidates, key=lambda fault: fault.failure != failure.name))
        episodes.append(Episode(failure.name, began, spell.holds, spell.ended, bool(causes), resolving))
        last = timeline.duration_s if spell.ended is None else spell.ended - SILENCE_S
        begun += [fault for fault in faults if fault not in begun and spell.holds < fault.time <= last]
    return episodes


def _is_past(fault: Injection, spell: Spell, adaptations: Sequence[ExecutedAdaptation]) -> bool:
    """Return whether a fault was gone before the spell's evidence: it had ended, or its process had."""
    is_old_outage = fault.failure in current_system().outages and spell.origin > fault.time + SILENCE_S
    redeploys = (
        adaptation.time
        for adaptation in adaptations
        if adaptation.kind == "redeploy" and adaptation.node == short_name(fault.node)
    )
    is_redeployed = fault.internal and any(fault.time <= time < spell.origin for time in redeploys)
    return is_old_outage or is_redeployed or _ended_before(fault, spell)


def _ended_before(fault: Injection, spell: Spell) -> bool:
    """Return whether a fault had ended before a spell; its effect on frames that are under way comes later."""
    lag_s = TOLERANCE_S if fault.failure in current_system().outages else SILENCE_S
    return fault.ended is not None and fault.ended + lag_s < spell.origin


def _able_faults(failure: str, spell: Spell, injections: Sequence[Injection]) -> list[Injection]:
    """Return the faults that can have caused a failure or prolonged it."""
    outages = current_system().outages
    return [
        fault
        for fault in injections
        if (fault.failure in outages) is (failure in outages)
        and (failure not in outages or affects(short_name(fault.node), failure))
        and (spell.ended is None or fault.time <= spell.ended)
        and not _ended_before(fault, spell)
    ]


def _is_behind(fault: Injection, failure: str, spell: Spell) -> bool:
    """Return whether one of the able faults can have begun a spell."""
    if failure in current_system().outages:
        return abs(spell.origin - fault.time) <= SILENCE_S + TOLERANCE_S
    return fault.time <= spell.holds


def _healed(failure: str, spell: Spell, able: Sequence[Injection], adaptation: ExecutedAdaptation) -> bool:
    """Return whether a spell ended because faults healed, first of all faults of the failure itself."""
    if spell.ended is None:
        return False
    able = [fault for fault in able if fault.failure == failure] or able
    ends = [
        (fault.ended, fault.healed is not None)
        for fault in able
        if fault.ended is not None and fault.ended <= spell.ended
    ]
    if not ends:
        return False
    last, has_healed = max(ends)
    if len(ends) == len(able):
        return has_healed
    came_too_late = spell.turned is not None and spell.turned < adaptation.time
    return has_healed and (adaptation.time < last or came_too_late) and spell.ended - last <= SILENCE_S


def _resolving(
    failure: str, began: float, ended: float | None, adaptations: Sequence[ExecutedAdaptation]
) -> ExecutedAdaptation | None:
    """Return the last adaptation that can have ended an episode."""
    moments = [each for each in adaptations if ended is not None and began <= each.time <= ended]
    return next((each for each in reversed(moments) if affects(each.node, failure)), None)
