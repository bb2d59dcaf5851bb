"""Which strength of a fault costs how much, from a model's curves."""

from collections.abc import Sequence
from itertools import pairwise

from sunset.perception.severities import LOSSES, SeverityTable
from sunset.system import get_fault
from sunset.training.curves import Curves


def severity_table(curves: Curves) -> SeverityTable:
    """Return the strengths of faults by severity: those of all faults whose strength a scenario can choose."""
    faults = dict.fromkeys(fault for case in curves.points for fault in case.strengths)
    name, version = curves.model
    return SeverityTable(
        model=name,
        version=version,
        frames=curves.frames,
        strengths={fault: _strengths(curves, fault) for fault in faults if get_fault(fault).limits},
    )


def _strengths(curves: Curves, fault: str) -> tuple[float | None, ...]:
    points = [(0.0, 0.0)]
    points += [(case.strengths[fault], 1 - curves.share(case.before)) for case in curves.of(fault)]
    found = [strength_at(points, loss) for loss in LOSSES]
    if isinstance(get_fault(fault).value, int):
        return tuple(None if one is None else float(round(one)) for one in found)
    return tuple(None if one is None else float(f"{one:.4g}") for one in found)


def strength_at(points: Sequence[tuple[float, float]], loss: float) -> float | None:
    """Return the least strength that costs so much, between two that were measured; None if none does.

    Args:
        points: (strength, loss), in the order of the strengths.
        loss: the share of the healthy IoU that is lost.

    >>> strength_at([(0.0, 0.0), (1.0, 0.2), (2.0, 0.4)], 0.3), strength_at([(0.0, 0.0), (1.0, 0.2)], 0.3)
    (1.5, None)
    """
    for (weak, less), (strong, more) in pairwise(points):
        if less < loss <= more:
            return weak + (strong - weak) * (loss - less) / (more - less)
    return None
