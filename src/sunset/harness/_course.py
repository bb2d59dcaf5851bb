"""How strong a fault is from its onset on, as long as it is not cured."""

from collections.abc import Iterator
from itertools import count
from math import inf
from typing import Final

from sunset.scenarios import ScenarioFault
from sunset.system import PERIOD_S, Value

STEP_S: Final = PERIOD_S
"""Seconds between two steps of a ramp; frames come as often."""

Change = tuple[float, Value | None]
"""Seconds after the measured time began, and the strength from then on; None without the fault."""


def course(fault: ScenarioFault, onset_s: float) -> Iterator[Change]:
    """Yield the changes of a fault's strength in order of time; endlessly for an intermittent fault that stays.

    Args:
        fault: the fault.
        onset_s: when it comes, in seconds after the measured time began.

    >>> list(course(ScenarioFault("gpu_failure", until=4.0), 2.0))
    [(2.0, True), (4.0, None)]
    """
    end = inf if fault.until is None else fault.until
    for time_s, value in _changes(fault, onset_s):
        if time_s >= end:
            break
        yield time_s, value
    if end < inf:
        yield end, None


def _changes(fault: ScenarioFault, onset_s: float) -> Iterator[Change]:
    profile, full = fault.profile, fault.value
    if full is None:
        raise ValueError(f"The severity of {fault.name} has no strength yet.")
    if profile.rise is not None and not isinstance(full, str):
        yield from _growth(full, profile.rise, onset_s)
    elif profile.on is not None and profile.off is not None:
        for number in count():
            begin = onset_s + number * (profile.on + profile.off)
            yield begin, full
            yield begin + profile.on, None
    else:
        yield onset_s, full


def _growth(full: float, rise_s: float, onset_s: float) -> Iterator[Change]:
    """Yield a strength that grows from nothing, each time that it changes."""
    steps = max(1, round(rise_s / STEP_S))
    last: float = 0
    for number in range(1, steps + 1):
        share = full * number / steps
        # a whole number has its least strength at once
        value = (round(share) or (1 if full > 0 else -1)) if isinstance(full, int) else share
        if value != last:
            yield onset_s + rise_s * number / steps, value
        last = value
