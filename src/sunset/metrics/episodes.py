"""When a failure's symptom held, when the failure began, and what resolved it.

The definitions, which the paper leaves open:

- F1, F2 and F3 hold while the last message on their topic is 1 s or more ago. A topic that has never
  sent anything counts as silent from 0.
- F4 and F5 hold from the sample at which the mean of the last five is beyond the threshold to the sample at
  which it no longer is. No verdict is made of stale samples: after a gap of more than 1 s in them five
  fresh ones are needed, and until then what held holds.
- An episode counts if it holds at any time within the experiment.
- A failure *began* when its fault was injected, the earliest if there are several and none of them has
  been blamed for an episode before. A fault that ended with its process before the silence or the samples
  in question is not to blame, and none is for a silence that begins more than 1 s later: those of F1, F2 and
  F3 show at once. Where there is no fault to blame, as in a ripple or a relapse, the failure began with its
  topic's last message, or with the first of the five samples; 0 at the earliest.
- It is *resolved* if it ended within the experiment, after at least one adaptation of the failing node or of
  one upstream of it since it began. The last such adaptation is the one that resolved it.
- Nobody resolves what no fault has broken: a silence that does not begin within 1 s of a fault of F1, F2 or F3 in the
  failing node or one upstream of it, or an F4 or F5 before which there was no fault of either. Else a managing
  system could break what it then repairs.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.metrics.adaptations import ExecutedAdaptation, affects, short_name
from sunset.metrics.downtime import TOLERANCE_S
from sunset.metrics.timeline import (
    CAMERA_TOPIC,
    FUSION_TOPIC,
    SEGMENTATION_TOPIC,
    Injection,
    Samples,
    Timeline,
)

__all__ = ["SAMPLES", "WINDOW_S", "Episode", "Spell", "excesses", "failure_episodes", "silences"]

WINDOW_S: Final = 1.0
"""Silence of this length is a symptom, and a gap of more than this makes samples stale [s]."""

SAMPLES: Final = 5
"""So many samples are averaged."""

_OUTAGES = {"F1": CAMERA_TOPIC, "F2": FUSION_TOPIC, "F3": SEGMENTATION_TOPIC}


@dataclass(frozen=True, slots=True)
class Spell:
    """A time over which a symptom held.

    Attributes:
        origin: the last message before the silence, or the first sample of the window [s].
        holds: when the symptom began to hold [s].
        ended: when it stopped [s]; None if it held to the end.
    """

    origin: float
    holds: float
    ended: float | None


@dataclass(frozen=True, slots=True)
class Episode:
    """One occurrence of a failure.

    Attributes:
        failure: `F1` … `F5`.
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

    >>> silences(np.array([0.0, 0.5, 3.0]), duration_s=5.0)
    [Spell(origin=0.5, holds=1.5, ended=3.0), Spell(origin=3.0, holds=4.0, ended=None)]
    """
    moments = times[times <= duration_s].tolist()
    if not moments or moments[0] > 0:
        moments.insert(0, 0.0)
    spells = [
        Spell(last, last + WINDOW_S, following)
        for last, following in itertools.pairwise(moments)
        if following - last > WINDOW_S + TOLERANCE_S
    ]
    if moments[-1] + WINDOW_S < duration_s - TOLERANCE_S:
        spells.append(Spell(moments[-1], moments[-1] + WINDOW_S, None))
    return _within(spells)


def excesses(samples: Samples, threshold: float, *, below: bool = False, duration_s: float) -> list[Spell]:
    """Return the spells in which the mean of the last five samples was over a threshold.

    Args:
        samples: with those before 0.
        threshold: a mean equal to it is not over it.
        below: whether the symptom is a mean under the threshold instead.
        duration_s: the end of the experiment; what came later is not looked at.
    """
    spells: list[Spell] = []
    start = 0  # of the samples that no gap separates from the present one
    holding: tuple[float, float] | None = None
    times, values = samples.times.tolist(), samples.values.tolist()
    for position in range(int(np.searchsorted(samples.times, duration_s, side="right"))):
        if position and times[position] - times[position - 1] > WINDOW_S + TOLERANCE_S:
            start = position
        first = position - SAMPLES + 1
        if first < start:
            continue
        mean = sum(values[first : position + 1]) / SAMPLES
        beyond = mean < threshold if below else mean > threshold
        if beyond and holding is None:
            holding = (times[first], times[position])
        elif holding is not None and not beyond:
            spells.append(Spell(*holding, times[position]))
            holding = None
    if holding is not None:
        spells.append(Spell(*holding, None))
    return _within(spells)


def _within(spells: Sequence[Spell]) -> list[Spell]:
    """Return the spells that hold after 0, cut off there."""
    return [
        Spell(spell.origin, max(spell.holds, 0.0), spell.ended)
        for spell in spells
        if spell.ended is None or spell.ended > 0
    ]


def failure_episodes(timeline: Timeline, adaptations: Sequence[ExecutedAdaptation]) -> tuple[Episode, ...]:
    """Return every episode of every failure, in order of the time at which its symptom held.

    Args:
        timeline: of the whole experiment.
        adaptations: those executed, in order of time.
    """
    duration = timeline.duration_s
    spells = {
        failure: silences(timeline.message_times.get(topic, np.empty(0)), duration_s=duration)
        for failure, topic in _OUTAGES.items()
    }
    spells["F4"] = excesses(timeline.entropy, timeline.entropy_threshold, duration_s=duration)
    spells["F5"] = excesses(timeline.sharpness, timeline.sharpness_threshold, below=True, duration_s=duration)
    episodes = [
        episode
        for failure in spells
        for episode in _episodes(failure, spells[failure], timeline, adaptations)
    ]
    return tuple(sorted(episodes, key=lambda episode: (episode.holds, episode.failure)))


def _episodes(
    failure: str,
    spells: Sequence[Spell],
    timeline: Timeline,
    adaptations: Sequence[ExecutedAdaptation],
) -> list[Episode]:
    """Say of each spell of one failure when the failure began, and what resolved it."""
    episodes = []
    blamed: set[str] = set()  # names of faults; one that is injected again is not a new one
    for spell in spells:
        due = [
            injection
            for injection in timeline.injections
            if injection.failure == failure
            and injection.fault not in blamed
            and injection.time <= spell.holds
        ]
        blamed.update(injection.fault for injection in due)
        causes = [injection.time for injection in due if not _is_past(injection, spell, adaptations)]
        began = min(causes) if causes else max(spell.origin, 0.0)
        broken = _has_a_fault_behind_it(failure, spell, timeline.injections)
        episodes.append(
            Episode(
                failure=failure,
                began=began,
                holds=spell.holds,
                ended=spell.ended,
                injected=bool(causes),
                adaptation=_resolving(failure, began, spell.ended, adaptations) if broken else None,
            )
        )
    return episodes


def _is_past(injection: Injection, spell: Spell, adaptations: Sequence[ExecutedAdaptation]) -> bool:
    """Return whether a fault was gone before the spell's first evidence: cured, or ended with its process."""
    if injection.failure in _OUTAGES and spell.origin > injection.time + WINDOW_S:
        return True
    return injection.internal and any(
        adaptation.kind == "redeploy"
        and adaptation.node == short_name(injection.node)
        and injection.time <= adaptation.time < spell.origin
        for adaptation in adaptations
    )


def _has_a_fault_behind_it(failure: str, spell: Spell, injections: Sequence[Injection]) -> bool:
    """Return whether a fault can have brought a failure about, by itself or by what else it does."""
    if failure in _OUTAGES:
        return any(
            injection.failure in _OUTAGES
            and affects(short_name(injection.node), failure)
            and abs(spell.origin - injection.time) <= WINDOW_S + TOLERANCE_S
            for injection in injections
        )
    return any(
        injection.failure not in _OUTAGES and injection.time <= spell.holds for injection in injections
    )


def _resolving(
    failure: str, began: float, ended: float | None, adaptations: Sequence[ExecutedAdaptation]
) -> ExecutedAdaptation | None:
    """Return the last adaptation that can have ended an episode."""
    if ended is None:
        return None
    able = [
        adaptation
        for adaptation in adaptations
        if began <= adaptation.time <= ended and affects(adaptation.node, failure)
    ]
    return able[-1] if able else None
