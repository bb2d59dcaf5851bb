"""What became of the faults in the runs of a row: columns of the report."""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Final

from sunset.evaluation.blocks import Block, Cell, Column, Line, LineKind, Quantity, interval_cell
from sunset.evaluation.estimates import Estimate
from sunset.evaluation.summary import SystemRow
from sunset.metrics import FATES, FaultOutcome

_COLUMNS: Final[Mapping[str, Column]] = MappingProxyType(
    {
        "cured": Column("cured ↑", r"cured $\uparrow$", "faults that were cured, of all"),
        "uncured_s": Column(
            "uncured [s] ↓",
            r"uncured $[\mathrm{s}]\downarrow$",
            "mean time that a fault was there without a cure in place",
        ),
        "masked_s": Column(
            "masked [s] ↓",
            r"masked $[\mathrm{s}]\downarrow$",
            "time in which a fault was there, its symptom had gone, and the segmentation was bad",
        ),
        "needless": Column(
            "needless ↓", r"needless $\downarrow$", "adaptations that are no step of a cure of a fault there"
        ),
        "cost_frames": Column("cost ↓", r"cost $\downarrow$", "prices of the adaptations, in frames"),
    }
)


def fault_blocks(rows: Sequence[SystemRow]) -> tuple[Block, ...]:
    """Return the table of what became of the faults."""
    judged = [row for row in rows if not row.is_reference]
    names = tuple(_COLUMNS)
    groups = tuple(
        lines_of(
            row, tuple(_cell(row, name) for name in names), tuple(row.estimates.get(name) for name in names)
        )
        for row in judged
    )
    columns = tuple(_COLUMNS[name] for name in names)
    return (Block("What became of the faults", columns, groups, "tab:sunset-faults"),)


def lines_of(
    row: SystemRow, cells: tuple[Cell, ...], estimates: Sequence[Estimate | None] = ()
) -> tuple[Line, ...]:
    """Return a row's line and, where there are any, one with the confidence intervals of estimates."""
    intervals = tuple(map(interval_cell, estimates))
    line = Line(LineKind.OURS, row.system, str(row.runs), cells)
    if not any(intervals):
        return (line,)
    return (line, Line(LineKind.CONFIDENCE, "  95 % conf.", "", intervals))


def fates(outcomes: Iterable[FaultOutcome]) -> Mapping[str, Mapping[str, int]]:
    """Return how many of each fault were cured, masked or missed: fault → fate → number."""
    counts: dict[str, dict[str, int]] = {}
    for outcome in outcomes:
        of_fault = counts.setdefault(outcome.fault, dict.fromkeys(FATES, 0))
        of_fault[outcome.fate] += 1
    return MappingProxyType({fault: MappingProxyType(counts[fault]) for fault in sorted(counts)})


def cured_rate(row: SystemRow) -> float | None:
    """Return the share of a row's faults that was cured; None where there was none."""
    cured = sum(outcome.cured is not None for outcome in row.outcomes)
    return cured / len(row.outcomes) if row.outcomes else None


def _cell(row: SystemRow, name: str) -> Cell:
    if name == "cured":
        rate = cured_rate(row)
        cured = sum(outcome.cured is not None for outcome in row.outcomes)
        return None if rate is None else f"{cured}/{len(row.outcomes)} ({rate:.0%})"
    found = row.estimates[name]
    return None if found is None else Quantity(found.mean, found.std)
