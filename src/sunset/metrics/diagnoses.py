"""How right the diagnoses of a managing system were, against the faults that were there."""

import itertools
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from sunset.metrics.timeline import Injection, Timeline
from sunset.system import SILENCE_S

SURE: Final = 0.5
"""A diagnosis names the faults whose probability is at least this."""


@dataclass(frozen=True, slots=True)
class DiagnosisFigures:
    """How right diagnoses were.

    Attributes:
        precision: of the time that faults were named, added up over them, the share in which they were there; None if
            none was named.
        recall: of the time that faults were there, added up likewise, the share in which they were named; None if none
            was there.
        right: of each fault, from when on the diagnosis first named all faults that were there, this one among them,
            and no other [s], for a second or for as long as the same faults were there; None if it never did.
    """

    precision: float | None
    recall: float | None
    right: tuple[float | None, ...]


def diagnosis_figures(timeline: Timeline, faults: Sequence[Injection]) -> DiagnosisFigures | None:
    """Return how right the diagnoses of a run were; None if none was published until its end.

    A diagnosis holds until the next one; before the first, nothing is named. Counted is the time from 0 to the end. A
    fault that lives in the world is there until it heals, also while it is worked around.
    """
    diagnoses = [diagnosis for diagnosis in timeline.diagnoses if diagnosis.time < timeline.duration_s]
    if not diagnoses:
        return None
    moments = {0.0, timeline.duration_s}
    moments |= {diagnosis.time for diagnosis in diagnoses} | {fault.time for fault in faults}
    moments |= {fault.ended for fault in faults if fault.ended is not None}
    named_s = there_s = both_s = 0.0
    right: dict[int, float] = {}
    changes = {moment for fault in faults for moment in (fault.time, fault.ended)} | {timeline.duration_s}
    since: float | None = None
    edges = sorted(moment for moment in moments if 0 <= moment <= timeline.duration_s)
    times = [diagnosis.time for diagnosis in diagnoses]
    for start, stop in itertools.pairwise(edges):
        place = bisect_right(times, start)
        latest = diagnoses[max(0, place - 1) : place]
        named = {
            name for diagnosis in latest for name, sure in diagnosis.probabilities.items() if sure >= SURE
        }
        present = [place for place, fault in enumerate(faults) if fault.is_there(start)]
        there = {faults[place].fault for place in present}
        named_s += len(named) * (stop - start)
        there_s += len(there) * (stop - start)
        both_s += len(named & there) * (stop - start)
        if start in changes or named != there:
            since = None
        if named == there:
            since = start if since is None else since
            if stop in changes or stop - since >= SILENCE_S:  # who names all in turn has not found it out
                right = dict.fromkeys(present, since) | right
    return DiagnosisFigures(
        precision=min(1.0, both_s / named_s) if named_s else None,
        recall=min(1.0, both_s / there_s) if there_s else None,
        right=tuple(right.get(place) for place in range(len(faults))),
    )
