"""What was behind the symptoms of a run, in words: what the managing system was not told."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from sunset.metrics import ExecutedAdaptation, Injection, RunMetrics
from sunset.system import Adaptation, Fault, current_system
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

    One that came several times is there once.
    """
    faults = current_system().faults
    came: dict[str, list[Injection]] = {}
    for injection in injections:
        came.setdefault(injection.fault, []).append(injection)
    return tuple(
        Cause(
            fault.name,
            _showed_as(fault.failure, metrics),
            ", ".join(
                one.name for one in faults.values() if one.failure == fault.failure and one is not fault
            ),
            _cured_by(fault, times, metrics.executed),
        )
        for name, times in came.items()
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


def _cured_by(fault: Fault, injections: Sequence[Injection], executed: Sequence[ExecutedAdaptation]) -> str:
    """Return what cures a fault, and when that was done, or when the fault healed."""
    what = []
    for injection in injections:
        done = _first_cure(fault, injection, executed)
        if done is not None:
            what.append(f"done at {done:.2f} s")
        elif injection.healed is not None:
            what.append(f"healed by itself at {injection.healed:.2f} s")
        else:
            what.append("not done")
    if not fault.cures:
        what = [text for text in what if text != "not done"]
    more = f" … {len(what) - _MOST} times more" if len(what) > _MOST else ""
    return "; ".join(filter(None, (fault.cured_by, listed(what[:_MOST]) + more)))


def _first_cure(fault: Fault, injection: Injection, executed: Sequence[ExecutedAdaptation]) -> float | None:
    """Return when a fault was cured first, of which what was done after it had healed is not a cure."""
    meanwhile = [one for one in executed if injection.healed is None or one.time < injection.healed]
    times = [_done(cure, injection.time, meanwhile) for cure in fault.cures]
    return min((time for time in times if time is not None), default=None)


def _done(
    cure: Sequence[Adaptation], injected_s: float, executed: Sequence[ExecutedAdaptation]
) -> float | None:
    """Return when the last step of a cure was done for the first time since the injection; None if one was not."""
    times = [
        next((one.time for one in executed if one.time >= injected_s and str(step) in one.steps), None)
        for step in cure
    ]
    known = [time for time in times if time is not None]
    return max(known) if len(known) == len(times) else None
