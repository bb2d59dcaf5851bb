"""The faults behind the symptoms of a run, in words; they are hidden from the managing system."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from sunset.metrics import FaultOutcome, RunMetrics, Timeline
from sunset.recording.schema import StoredFault
from sunset.system import Fault, current_system, find_fault
from sunset.texts.sentences import listed

_MOST: Final = 4  # occurrences of a fault that are listed
_LATE_S: Final = 0.1
"""The delay at which a fault still counts as on time, and a symptom as gone with its fault."""


@dataclass(frozen=True, slots=True)
class Cause:
    """A fault of a run, in words.

    Attributes:
        fault: its name.
        showed_as: its failure, and the ripples of the failure.
        looks_like: the other faults with this failure; may be empty.
        cured_by: its cure, and when the fault was cured.
    """

    fault: str
    showed_as: str
    looks_like: str
    cured_by: str


def causes_of(
    timeline: Timeline, metrics: RunMetrics, planned: Sequence[StoredFault] = ()
) -> tuple[Cause, ...]:
    """Return the faults of a run in the order of their injection, each once, and then those that did not come.

    Faults of another version's catalogue are left out.
    """
    faults = current_system().faults
    healed = {(injection.fault, injection.healed) for injection in timeline.injections}
    came: dict[str, list[str]] = {}
    for outcome in metrics.outcomes:
        if (outcome.fault, outcome.until) in healed:
            text = _cure_text(outcome) or f"healed by itself at {outcome.until:.2f} s"
        else:
            text = _cure_text(outcome) + _healing_text(outcome, metrics, planned)
        came.setdefault(outcome.fault, []).append(text)
    causes = []
    for name, cures in came.items():
        if fault := find_fault(name):
            alike = [
                other.name
                for other in faults.values()
                if other.failure == fault.failure and other is not fault
            ]
            shown = _showed_as(fault.failure, metrics)
            causes.append(Cause(fault.name, shown, ", ".join(alike), _cured_by(fault, cures)))
    missing = [fault for fault in planned if fault.name not in came]
    return (*causes, *(Cause(fault.name, _did_not_come(fault, timeline), "", "") for fault in missing))


def _did_not_come(fault: StoredFault, timeline: Timeline) -> str:
    if fault.after is None:
        return "nothing: it did not come in the time of the run"
    leader, delay_s = str(fault.after["fault"]), float(fault.after["delay"])
    times = [injection.time for injection in timeline.injections if injection.fault == leader]
    if not times or times[0] >= timeline.duration_s:
        return f"nothing: it did not come, since {leader} did not"
    due_s = times[0] + delay_s
    reason = "the run had ended" if due_s >= timeline.duration_s else f"{leader} was gone"
    return f"nothing: it did not come, since {reason} by {due_s:.2f} s"


def _showed_as(failure: str, metrics: RunMetrics) -> str:
    system = current_system()
    text = f"{failure} ({system.failures[failure].description})"
    if not any(episode.injected and episode.failure == failure for episode in metrics.failures):
        return f"nothing; it can show as {text}"
    ripples = {
        episode.failure
        for episode in metrics.failures
        if not episode.injected
        and {failure, episode.failure} <= system.outages
        and system.failing_nodes[failure] in system.upstream[system.failing_nodes[episode.failure]]
    }
    return f"{text}; {listed(sorted(ripples))} by ripple, for lack of input" if ripples else text


def _cure_text(outcome: FaultOutcome) -> str:
    """Return when a fault was cured; empty if it was not."""
    if outcome.cured is None:
        return ""
    in_place = outcome.cured == outcome.began > 0
    away = " (while it was away)" if outcome.cured > outcome.until else ""
    return f"{'in place' if in_place else 'done'} at {outcome.cured:.2f} s{away}"


def _healing_text(outcome: FaultOutcome, metrics: RunMetrics, planned: Sequence[StoredFault]) -> str:
    """Return when a fault that was cured would have healed, and how long its symptom outlasted that."""
    healing_s = next(
        (
            fault.until
            for fault in planned
            if fault.name == outcome.fault
            and fault.until is not None
            and fault.at <= outcome.began + _LATE_S < fault.until
        ),
        None,
    )
    if outcome.cured is None or healing_s is None:
        return ""
    ends = [
        episode.ended
        for episode in metrics.failures
        if episode.failure == outcome.failure
        and episode.injected
        and outcome.began <= episode.began < healing_s
    ]
    late_s = max((end - healing_s for end in ends if end is not None), default=0.0)
    later = f", {late_s:.2f} s before {outcome.failure} was over" if late_s > _LATE_S else ""
    return f" (it would have healed by itself at {healing_s:.2f} s{later})"


def _cured_by(fault: Fault, texts: Sequence[str]) -> str:
    cures = [text or "not done" for text in texts if text or fault.cures]
    more = f" … {len(cures) - _MOST} times more" if len(cures) > _MOST else ""
    times = listed(cures[:_MOST]) + more if cures else ""
    return "; ".join(filter(None, (fault.cured_by, times)))
