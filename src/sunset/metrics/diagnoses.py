"""Figures of diagnoses, in levels: a fault is present, its node, the fault itself."""

import itertools
import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

from sunset.metrics.timeline import Injection, Timeline
from sunset.system import current_system
from sunset.texts.names import base_name

SURE: Final = 0.5
"""A diagnosis reports a set of faults if the probability of at least one of them is at least this."""
WINDOW_S: Final = 8.0
"""A fault counts as diagnosed only within this time from its onset [s]."""
LEVELS: Final = ("detected", "located", "identified", "top1")


def diagnosis_figures(timeline: Timeline, faults: Sequence[Injection]) -> dict[str, Any]:
    """Return the figures of a run's diagnoses.

    A diagnosis holds until the next diagnosis; before the first, all probabilities are 0. `faults` has each fault, each
    time that it came.
    """
    catalogue = current_system().faults
    delays: list[dict[str, float]] = [{} for _ in faults]  # level that a fault reached → time since its onset
    alarms, faultless_s, squares, is_alarmed = 0, 0.0, 0.0, False
    for start, stop, named in _stretches(timeline, faults):
        present = [
            (fault, delay) for fault, delay in zip(faults, delays, strict=True) if fault.is_there(start)
        ]
        names = {fault.fault for fault, _ in present}
        squares += (stop - start) * sum((named.get(name, 0.0) - (name in names)) ** 2 for name in catalogue)
        was_alarmed, is_alarmed = is_alarmed, _reports(named.values())
        if not present:
            faultless_s += stop - start
            alarms += is_alarmed and not was_alarmed
        for fault, delay in present:
            if start < fault.time + WINDOW_S:
                reached = dict.fromkeys(_levels(fault, named, len(names)), start - fault.time)
                known = {level: after for level, after in delay.items() if level in reached}
                delay.clear()  # a level counts if it is kept to the end of the window
                delay.update(reached | known)
    times = {level: [delay[level] for delay in delays if level in delay] for level in LEVELS}
    return {
        "diagnoses": sum(diagnosis.time < timeline.duration_s for diagnosis in timeline.diagnoses),
        **{f"faults_{level}": len(reached) for level, reached in times.items()},
        **{f"t_{level}_s": mean(times[level]) for level in LEVELS[:-1]},
        "false_alarms": alarms,
        "faultless_s": round(faultless_s, 9),
        "brier": min(1.0, squares / timeline.duration_s / len(catalogue)),
    }


def _levels(fault: Injection, named: Mapping[str, float], number: int) -> Iterator[str]:
    """Return the levels that a diagnosis reaches for one of a number of present faults."""
    catalogue, node = current_system().faults, base_name(fault.node)
    probability = named.get(fault.fault, 0.0)
    reached = (
        _reports(named.values()),
        _reports(sure for name, sure in named.items() if catalogue[name].node == node),
        _reports([probability]),
        probability > 0 and sum(other >= probability for other in named.values()) <= number,
    )
    return itertools.compress(LEVELS, reached)


def _stretches(
    timeline: Timeline, faults: Sequence[Injection]
) -> Iterator[tuple[float, float, Mapping[str, float]]]:
    """Yield the stretches of time in which nothing changes, with their probabilities."""
    catalogue, end = current_system().faults, timeline.duration_s
    times = [diagnosis.time for diagnosis in timeline.diagnoses]
    moments = {0.0, end, *times}
    for fault in faults:
        moments |= {fault.time, fault.time + WINDOW_S, end if fault.ended is None else fault.ended}
    for start, stop in itertools.pairwise(sorted(moment for moment in moments if 0 <= moment <= end)):
        place = bisect_right(times, start)
        published = timeline.diagnoses[place - 1].probabilities if place else {}
        # other publishers may send unknown names and numbers that are not probabilities
        named = {name: sure for name, sure in published.items() if name in catalogue and 0 <= sure <= 1}
        yield start, stop, named


def _reports(probabilities: Iterable[float]) -> bool:
    """Return whether a diagnosis reports a set of faults with these probabilities, as if they were independent.

    >>> _reports([0.3, 0.3]), _reports([0.3, 0.2]), _reports([])
    (True, False, False)
    """
    return 1 - math.prod(1 - probability for probability in probabilities) >= SURE


def mean(values: Iterable[float | None]) -> float | None:
    """Return the mean of the known values, rounded to nanoseconds; None without a value."""
    known = [value for value in values if value is not None]
    return round(sum(known) / len(known), 9) if known else None
