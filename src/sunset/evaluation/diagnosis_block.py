"""The block of a report that says how right the diagnoses were."""

from collections.abc import Sequence
from typing import Final

from sunset.evaluation.blocks import Block, Cell, Column, Line, LineKind, Quantity
from sunset.evaluation.summary import SystemRow

_LEVELS: Final = {
    "faults_detected": Column("detected ↑", r"detected $\uparrow$", "of all faults: a fault was reported"),
    "faults_located": Column("located ↑", r"located $\uparrow$", "a fault of the same node was reported"),
    "faults_identified": Column("identified ↑", r"identified $\uparrow$", "the fault itself was reported"),
    "faults_top1": Column(
        "top 1 ↑", r"top 1 $\uparrow$", "the fault was among the k most probable, of k faults that were there"
    ),
}
_TIMES: Final = {
    "t_detected_s": Column(
        "t_detected [s] ↓", r"$t_\mathrm{detected}\,[\mathrm{s}]\downarrow$", "from the onset"
    ),
    "t_located_s": Column("t_located [s] ↓", r"$t_\mathrm{located}\,[\mathrm{s}]\downarrow$", "likewise"),
    "t_identified_s": Column(
        "t_identified [s] ↓", r"$t_\mathrm{identified}\,[\mathrm{s}]\downarrow$", "likewise"
    ),
}
_ALARMS: Final = Column(
    "false alarms [1/min] ↓", r"false alarms $[1/\mathrm{min}]\downarrow$", "per minute without a fault"
)
_BRIER: Final = Column(
    "Brier ↓", r"Brier $\downarrow$", "mean square error of the probabilities, over time and faults"
)


def diagnosis_blocks(rows: Sequence[SystemRow]) -> tuple[Block, ...]:
    """Return the block; nothing where no run published a diagnosis.

    `none`, which publishes nothing, stands in it for comparison.
    """
    diagnosing = [row for row in rows if _total(row, "diagnoses")]
    shown = [row for row in rows if row in diagnosing or row.manager == "none"] if diagnosing else []
    groups = tuple(
        (Line(LineKind.OURS, row.system, str(row.runs), _cells(row)),)
        for row in shown
        if not row.is_reference
    )
    columns = (*_LEVELS.values(), *_TIMES.values(), _ALARMS, _BRIER)
    return (Block("Diagnosis", columns, groups, "tab:sunset-diagnosis"),) if groups else ()


def _cells(row: SystemRow) -> tuple[Cell, ...]:
    injected, calm_s = _total(row, "faults_injected"), _total(row, "faultless_s")
    shares = (
        f"{round(found)}/{round(injected)} ({found / injected:.0%})" if injected else None
        for found in (_total(row, name) for name in _LEVELS)
    )
    times = ((found.mean, found.std) if (found := row.estimates[name]) else None for name in _TIMES)
    alarms = Quantity(60 * _total(row, "false_alarms") / calm_s, None) if calm_s else None
    brier = row.estimates["brier"]
    return (
        *shares,
        *(time and Quantity(*time) for time in times),
        alarms,
        None if brier is None else f"{brier.mean:.3f}",
    )


def _total(row: SystemRow, name: str) -> float:
    """Return a figure's sum over the valid runs of a row."""
    found = row.estimates[name]
    return found.mean * found.runs if found else 0.0
