"""What was behind the symptoms of a run, in words: what the managing system was not told."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from sunset.metrics import FaultOutcome, Injection, RunMetrics
from sunset.system import Fault, current_system
from sunset.texts import listed

_MOST: Final = 4
"""Times that are listed of a fault that came often."""


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


def causes_of(injections: Sequence[Injection], metrics: RunMetrics) -> tuple[Cause, ...]:
    """Return the faults of a run in the order of their injection, less those that this version's catalogue lacks.

    One that came several times is there once. What became of it is what `metrics` counts.
    """
    faults = current_system().faults
    healed = {(injection.fault, injection.healed) for injection in injections}
    came: dict[str, list[str]] = {}
    for outcome in metrics.outcomes:
        came.setdefault(outcome.fault, []).append(
            _became(outcome, healed=(outcome.fault, outcome.until) in healed)
        )
    return tuple(
        Cause(
            fault.name,
            _showed_as(fault.failure, metrics),
            ", ".join(
                one.name for one in faults.values() if one.failure == fault.failure and one is not fault
            ),
            _cured_by(fault, became),
        )
        for name, became in came.items()
        if (fault := faults.get(name))
    )


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
        return f"{'in place' if in_place else 'done'} at {outcome.cured:.2f} s"
    return f"healed by itself at {outcome.until:.2f} s" if healed else ""


def _cured_by(fault: Fault, became: Sequence[str]) -> str:
    """Return what cures a fault, and when that was done, or when the fault healed."""
    what = [text or "not done" for text in became if text or fault.cures]
    more = f" … {len(what) - _MOST} times more" if len(what) > _MOST else ""
    return "; ".join(filter(None, (fault.cured_by, listed(what[:_MOST]) + more)))
