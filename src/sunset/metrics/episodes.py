"""When a failure's symptom held, when the failure began, and what resolved it.

`docs/metrics.md` has the definitions, which the paper leaves open, under *The paper's five figures*.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from sunset.metrics.adaptations import ExecutedAdaptation, affects
from sunset.metrics.downtime import TOLERANCE_S
from sunset.metrics.timeline import Injection, Samples, Timeline
from sunset.system import (
    SILENCE_S,
    WINDOW,
    Failure,
    MovingMean,
    Signal,
    current_system,
    full_name,
    short_name,
)


@dataclass(frozen=True, slots=True)
class Spell:
    """A time over which a symptom held.

    Attributes:
        origin: the last message before the silence, or the first sample of the window [s].
        holds: when the symptom began to hold [s].
        ended: when it stopped [s]; None if it held to the end.
        turned: since when each sample was on the right side of the threshold [s]; None of a silence.
    """

    origin: float
    holds: float
    ended: float | None
    turned: float | None = None


@dataclass(frozen=True, slots=True)
class Episode:
    """One occurrence of a failure.

    Attributes:
        failure: its name, such as `F1`.
        began: when the failure began [s].
        holds: when its symptom began to hold [s].
        ended: when its symptom stopped [s]; None if it held to the end.
        injected: whether a fault of this failure was injected, or it came by itself: a ripple or a relapse.
        adaptation: the one that resolved it; None if none did.
    """

    failure: str
    began: float
    holds: float
    ended: float | None
    injected: bool
    adaptation: ExecutedAdaptation | None

    @property
    def resolved(self) -> bool:
        """Whether it ended after an adaptation that can have done it."""
        return self.adaptation is not None

    @property
    def subsided(self) -> bool:
        """Whether it ended by itself."""
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
    """Return the spells in which a topic had sent nothing for 1 s.

    Args:
        times: (N,) ascending, when its messages left [s], with those before 0.
        duration_s: the end of the experiment; what came later is not looked at.

    >>> [(one.origin, one.holds, one.ended) for one in silences(np.array([0.0, 0.5, 3.0]), duration_s=5.0)]
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
        samples: with those before 0.
        signal: says on which side of the threshold a mean is a symptom.
        threshold: a mean equal to it is not beyond it.
        duration_s: the end of the experiment; what came later is not looked at.
    """
    spells: list[Spell] = []
    holding: tuple[float, float] | None = None
    turned: float | None = None
    moving = MovingMean(WINDOW.gap_s + TOLERANCE_S)
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
    if holding is not None:
        spells.append(Spell(*holding, None))
    return _within(spells)


def _within(spells: Sequence[Spell]) -> list[Spell]:
    """Return the spells that hold after 0, cut off there."""
    return [
        replace(spell, holds=max(spell.holds, 0.0))
        for spell in spells
        if spell.ended is None or spell.ended > 0
    ]


def failure_episodes(timeline: Timeline, adaptations: Sequence[ExecutedAdaptation]) -> tuple[Episode, ...]:
    """Return every episode of every failure, in order of the time at which its symptom held.

    Adaptations are those executed, in order of time.
    """
    episodes = [
        episode
        for failure in current_system().failures.values()
        for episode in _episodes(failure, _spells(failure, timeline), timeline, adaptations)
    ]
    return tuple(sorted(episodes, key=lambda episode: (episode.holds, episode.failure)))


def _spells(failure: Failure, timeline: Timeline) -> list[Spell]:
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
    """Say of each spell of one failure when the failure began, and what resolved it."""
    episodes = []
    blamed: list[Injection] = []
    spent: list[Injection] = []
    for spell in spells:
        # one that is injected again while it is there is not a new one
        there = {fault.fault for fault in blamed if fault.ended is None}
        due = [
            injection
            for injection in timeline.injections
            if injection.failure == failure.name
            and injection not in blamed
            and injection.fault not in there
            and injection.time <= spell.holds
        ]
        blamed += due
        causes = [injection.time for injection in due if not _is_past(injection, spell, adaptations)]
        began = min(causes) if causes else max(spell.origin, 0.0)
        able = _able_faults(failure.name, spell, timeline.injections)
        behind = [fault for fault in able if fault not in spent and _is_behind(fault, failure.name, spell)]
        resolving = _resolving(failure.name, began, spell.ended, adaptations) if behind else None
        if _healed(failure.name, spell, able, resolving):
            resolving = None
        if resolving is not None:  # its own fault explains it, if there is one
            spent.append(min(behind, key=lambda fault: fault.failure != failure.name))
        episodes.append(
            Episode(
                failure=failure.name,
                began=began,
                holds=spell.holds,
                ended=spell.ended,
                injected=bool(causes),
                adaptation=resolving,
            )
        )
        # what came while it lasted does not begin another one when it comes back
        last = timeline.duration_s if spell.ended is None else spell.ended - SILENCE_S
        blamed += [
            injection
            for injection in timeline.injections
            if injection.failure == failure.name
            and injection not in blamed
            and spell.holds < injection.time <= last
        ]
    return episodes


def _is_past(injection: Injection, spell: Spell, adaptations: Sequence[ExecutedAdaptation]) -> bool:
    """Return whether a fault was gone before the spell's first evidence: cured, or ended with its process."""
    if injection.failure in current_system().outages and spell.origin > injection.time + SILENCE_S:
        return True
    if _ended_before(injection, spell):
        return True
    return injection.internal and any(
        adaptation.kind == "redeploy"
        and adaptation.node == short_name(injection.node)
        and injection.time <= adaptation.time < spell.origin
        for adaptation in adaptations
    )


def _ended_before(injection: Injection, spell: Spell) -> bool:
    """Return whether a fault had ended before a spell; what it did to frames that were on their way comes later."""
    lag_s = TOLERANCE_S if injection.failure in current_system().outages else SILENCE_S
    return injection.ended is not None and injection.ended + lag_s < spell.origin


def _able_faults(failure: str, spell: Spell, injections: Sequence[Injection]) -> list[Injection]:
    """Return the faults that can have brought a failure about or kept it up, by themselves or by what else they do."""
    outages = current_system().outages
    return [
        injection
        for injection in injections
        if (injection.failure in outages) is (failure in outages)
        and (failure not in outages or affects(short_name(injection.node), failure))
        and (spell.ended is None or injection.time <= spell.ended)
        and not _ended_before(injection, spell)
    ]


def _is_behind(injection: Injection, failure: str, spell: Spell) -> bool:
    """Return whether a fault, which is able to, can have begun a spell."""
    if failure in current_system().outages:
        return abs(spell.origin - injection.time) <= SILENCE_S + TOLERANCE_S
    return injection.time <= spell.holds


def _healed(
    failure: str, spell: Spell, able: Sequence[Injection], adaptation: ExecutedAdaptation | None
) -> bool:
    """Return whether a spell ended since faults healed by themselves, and not by an adaptation.

    Those of the failure itself decide, where there are any.
    """
    if spell.ended is None or adaptation is None:
        return False
    able = [fault for fault in able if fault.failure == failure] or able
    ends = [
        (fault.ended, fault.healed is not None)
        for fault in able
        if fault.ended is not None and fault.ended <= spell.ended
    ]
    if not ends:
        return False
    last, by_itself = max(ends)
    if len(ends) < len(able):
        # the adaptation came before it healed, or after the symptom had begun to go
        came_too_late = spell.turned is not None and spell.turned < adaptation.time
        return by_itself and (adaptation.time < last or came_too_late) and spell.ended - last <= SILENCE_S
    return by_itself


def _resolving(
    failure: str, began: float, ended: float | None, adaptations: Sequence[ExecutedAdaptation]
) -> ExecutedAdaptation | None:
    """Return the last adaptation that can have ended an episode."""
    able = [
        adaptation
        for adaptation in adaptations
        if ended is not None and began <= adaptation.time <= ended and affects(adaptation.node, failure)
    ]
    return able[-1] if able else None
