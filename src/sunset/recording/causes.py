"""What was behind the symptoms of a run, in words: what the managing system was not told."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from sunset.metrics import FaultOutcome, RunMetrics, Timeline
from sunset.recording.schema import StoredFault
from sunset.system import Fault, current_system, find_fault
from sunset.texts import listed

_MOST: Final = 4
"""Times that are listed of a fault that came often."""
_LATE_S: Final = 0.1
"""A fault may come so much later than planned, and its symptom go so much later than it."""


@dataclass(frozen=True, slots=True)
class Cause:
    """One fault of a run, in words.

    Attributes:
        fault: its name.
        showed_as: its failure, and the ripples of that.
        looks_like: the other faults that show as this failure; empty if there are none.
        cured_by: what cures it, and when that was done.
    """

    fault: str
    showed_as: str
    looks_like: str
    cured_by: str


def causes_of(
    timeline: Timeline, metrics: RunMetrics, planned: Sequence[StoredFault] = ()
) -> tuple[Cause, ...]:
    """Return the faults of a run in the order of their injection, less those that this version's catalogue lacks.

    One that came several times is there once. What became of it is what `metrics` counts. Behind them stand those of
    the scenario that did not come.
    """
    faults = current_system().faults
    healed = {(injection.fault, injection.healed) for injection in timeline.injections}
    came: dict[str, list[str]] = {}
    for outcome in metrics.outcomes:
        came.setdefault(outcome.fault, []).append(
            _became(outcome, healed=True)
            if (outcome.fault, outcome.until) in healed
            else _became(outcome, healed=False) + _would_have_healed(outcome, metrics, planned)
        )
    causes = [
        Cause(
            fault.name,
            _showed_as(fault.failure, metrics),
            ", ".join(
                one.name for one in faults.values() if one.failure == fault.failure and one is not fault
            ),
            _cured_by(fault, became),
        )
        for name, became in came.items()
        if (fault := find_fault(name))
    ]
    missing = [plan for plan in planned if plan.name not in came]
    return (*causes, *(Cause(plan.name, _did_not_come(plan, timeline), "", "") for plan in missing))


def _did_not_come(plan: StoredFault, timeline: Timeline) -> str:
    """Return why a fault of the scenario did not come."""
    if plan.after is None:
        return "nothing: it did not come in the time of the run"
    leader, delay_s = str(plan.after["fault"]), float(plan.after["delay"])
    first = [one for one in timeline.injections if one.fault == leader and one.time < timeline.duration_s]
    if not first:
        return f"nothing: it did not come, since {leader} did not"
    gone = first[0].time + delay_s
    reason = "the run had ended" if gone >= timeline.duration_s else f"{leader} was gone"
    return f"nothing: it did not come, since {reason} by {gone:.2f} s"


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


def _became(outcome: FaultOutcome, *, healed: bool) -> str:
    """Return when a fault was cured, or when it healed; empty if neither."""
    if outcome.cured is not None:
        in_place = outcome.cured == outcome.began > 0
        away = " (while it was away)" if outcome.cured > outcome.until else ""
        return f"{'in place' if in_place else 'done'} at {outcome.cured:.2f} s{away}"
    return f"healed by itself at {outcome.until:.2f} s" if healed else ""


def _would_have_healed(outcome: FaultOutcome, metrics: RunMetrics, planned: Sequence[StoredFault]) -> str:
    """Return when a fault that was cured would have healed by itself, and how long its symptom outlasted that."""
    healing = [
        plan.until
        for plan in planned
        if plan.name == outcome.fault
        and plan.until is not None
        and plan.at <= outcome.began + _LATE_S < plan.until
    ]
    if outcome.cured is None or not healing:
        return ""
    ends = [
        episode.ended
        for episode in metrics.failures
        if episode.failure == outcome.failure
        and episode.injected
        and outcome.began <= episode.began < healing[0]
    ]
    late_s = max((end - healing[0] for end in ends if end is not None), default=0.0)
    later = f", {late_s:.2f} s before {outcome.failure} was over" if late_s > _LATE_S else ""
    return f" (it would have healed by itself at {healing[0]:.2f} s{later})"


def _cured_by(fault: Fault, became: Sequence[str]) -> str:
    """Return what cures a fault, and when that was done, or when the fault healed."""
    what = [text or "not done" for text in became if text or fault.cures]
    more = f" … {len(what) - _MOST} times more" if len(what) > _MOST else ""
    return "; ".join(filter(None, (fault.cured_by, listed(what[:_MOST]) + more)))
