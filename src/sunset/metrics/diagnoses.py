"""How right the diagnoses of a managing system were, in levels: a fault is there, its node, the fault itself."""

import itertools
import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from sunset.metrics.limits import Amount, Count, Share
from sunset.metrics.timeline import Injection, Timeline
from sunset.names import base_name
from sunset.system import current_system

SURE: Final = 0.5
"""A diagnosis says that a fault is there if the probability of that is at least this."""
WINDOW_S: Final = 8.0
"""A fault counts as diagnosed only within this time from its onset [s]."""
LEVELS: Final = ("detected", "located", "identified", "top1")


@dataclass(frozen=True, slots=True, kw_only=True)
class DiagnosisFigures:
    """The figures of a run's diagnoses, as `docs/metrics.md` defines them; a run without any names nothing.

    Attributes:
        diagnoses: how many diagnoses were published until the end of the run.
        faults_detected: faults of which diagnoses said, up to the end of their window, that there is a fault.
        faults_located: faults of which they said so that there is a fault of their node.
        faults_identified: faults of which they said so that they are there.
        faults_top1: faults that they had so among the k most probable, of k faults that were there.
        t_detected_s: mean over detected faults, from the onset to the first such diagnosis [s]; None if there is none.
        t_located_s: likewise, of located faults.
        t_identified_s: likewise, of identified faults.
        false_alarms: how often a diagnosis began to say that there is a fault while there was none.
        faultless_s: time without a fault [s].
        brier: mean over time and over the faults of the catalogue of (probability − there)², in [0, 1].
    """

    diagnoses: Count
    faults_detected: Count
    faults_located: Count
    faults_identified: Count
    faults_top1: Count
    t_detected_s: Amount | None
    t_located_s: Amount | None
    t_identified_s: Amount | None
    false_alarms: Count
    faultless_s: Amount
    brier: Share


def diagnosis_figures(timeline: Timeline, faults: Sequence[Injection]) -> DiagnosisFigures:
    """Return the figures of a run's diagnoses.

    A diagnosis holds until the next one; before the first, all probabilities are 0.

    Args:
        timeline: of the run.
        faults: those that came, each time that they came.
    """
    catalogue = current_system().faults
    delays: list[dict[str, float]] = [{} for _ in faults]  # of each level that a fault reached
    alarms, faultless_s, squares, is_alarmed = 0, 0.0, 0.0, False
    for start, stop, named in _stretches(timeline, faults):
        there = {fault.fault for fault in faults if fault.is_there(start)}
        squares += (stop - start) * sum((named.get(name, 0.0) - (name in there)) ** 2 for name in catalogue)
        was_alarmed, is_alarmed = is_alarmed, _says(named.values())
        if not there:
            faultless_s += stop - start
            alarms += is_alarmed and not was_alarmed
        for fault, delay in zip(faults, delays, strict=True):
            if fault.is_there(start) and start < fault.time + WINDOW_S:
                reached = set(_levels(fault, named, len(there)))
                for level in LEVELS:  # who names all in turn has not found it out
                    if level in reached:
                        delay.setdefault(level, start - fault.time)
                    else:
                        delay.pop(level, None)
    found = {level: [delay[level] for delay in delays if level in delay] for level in LEVELS}
    return DiagnosisFigures(
        diagnoses=sum(diagnosis.time < timeline.duration_s for diagnosis in timeline.diagnoses),
        faults_detected=len(found["detected"]),
        faults_located=len(found["located"]),
        faults_identified=len(found["identified"]),
        faults_top1=len(found["top1"]),
        t_detected_s=mean(found["detected"]),
        t_located_s=mean(found["located"]),
        t_identified_s=mean(found["identified"]),
        false_alarms=alarms,
        faultless_s=round(faultless_s, 9),
        brier=min(1.0, squares / timeline.duration_s / len(catalogue)),
    )


def _levels(fault: Injection, named: Mapping[str, float], number: int) -> Iterator[str]:
    """Return the levels that a diagnosis reaches for a fault that is there, as one of a number of faults."""
    catalogue, node = current_system().faults, base_name(fault.node)
    probability = named.get(fault.fault, 0.0)
    reached = (
        _says(named.values()),
        _says(sure for name, sure in named.items() if catalogue[name].node == node),
        _says([probability]),
        probability > 0 and sum(other >= probability for other in named.values()) <= number,
    )
    return itertools.compress(LEVELS, reached)


def _stretches(
    timeline: Timeline, faults: Sequence[Injection]
) -> Iterator[tuple[float, float, Mapping[str, float]]]:
    """Yield the stretches of time in which nothing changes, with the probabilities that hold in them."""
    catalogue, end = current_system().faults, timeline.duration_s
    times = [diagnosis.time for diagnosis in timeline.diagnoses]
    moments = {0.0, end, *times}
    for fault in faults:
        moments |= {fault.time, fault.time + WINDOW_S, end if fault.ended is None else fault.ended}
    for start, stop in itertools.pairwise(sorted(moment for moment in moments if 0 <= moment <= end)):
        place = bisect_right(times, start)
        said = timeline.diagnoses[place - 1].probabilities if place else {}
        # anything may be published on the topic: a probability that is none, and a name of no fault, say nothing
        yield start, stop, {name: sure for name, sure in said.items() if name in catalogue and 0 <= sure <= 1}


def _says(probabilities: Iterable[float]) -> bool:
    """Return whether one of several faults is there, by their probabilities, as if they were independent.

    >>> _says([0.3, 0.3]), _says([0.3, 0.2]), _says([])
    (True, False, False)
    """
    return 1 - math.prod(1 - probability for probability in probabilities) >= SURE


def mean(values: Iterable[float | None]) -> float | None:
    """Return the mean of the values that are known, rounded to nanoseconds; None of nothing."""
    known = [value for value in values if value is not None]
    return round(sum(known) / len(known), 9) if known else None
