"""The block of a report that says how right the diagnoses were."""

from collections.abc import Sequence
from typing import Final

from sunset.evaluation.blocks import Block, Cell, Column, Line, Quantity
from sunset.evaluation.summary import SystemRow

_LEVELS: Final = {
    ("faults_detected", "t_detected_s"): Column(
        "detected ↑", "of all faults: a fault was reported, and how long after the onset"
    ),
    ("faults_located", "t_located_s"): Column("located ↑", "likewise, a fault of the same node"),
    ("faults_identified", "t_identified_s"): Column("identified ↑", "likewise, the fault itself"),
    ("faults_top1", ""): Column(
        "top 1 ↑", "the fault was among the k most probable, of k faults that were there"
    ),
}
_COLUMNS: Final = (
    *_LEVELS.values(),
    Column("alarms [1/min] ↓", "false alarms per minute without a fault"),
    Column("Brier ↓", "mean square error of the probabilities, over time and faults"),
)

_LEAST_CALM_S: Final = 1.0
"""With less time without a fault there is no rate of false alarms: a fault at 0 comes half a millisecond after 0."""


def diagnosis_blocks(rows: Sequence[SystemRow]) -> tuple[Block, ...]:
    """Return the block; nothing where no run published a diagnosis.

    `none`, which publishes nothing, stands in it for comparison.
    """
    diagnosing = [row for row in rows if _total(row, "diagnoses")]
    shown = [row for row in rows if row in diagnosing or row.example.manager == "none"] if diagnosing else []
    lines = tuple(Line(row.system, str(row.runs), _cells(row)) for row in shown if not row.is_reference)
    return (Block("Diagnosis", _COLUMNS, lines, "tab:sunset-diagnosis"),) if lines else ()


def _cells(row: SystemRow) -> tuple[Cell, ...]:
    injected, calm_s = _total(row, "faults_injected"), _total(row, "faultless_s")
    shares = (_level(row, count, time, injected) if injected else None for count, time in _LEVELS)
    alarms = Quantity(60 * _total(row, "false_alarms") / calm_s) if calm_s >= _LEAST_CALM_S else None
    brier = row.estimates["brier"]
    return (*shares, alarms, None if brier is None else f"{brier.mean:.3f}")


def _level(row: SystemRow, count: str, time: str, injected: float) -> str:
    """Return how many of the faults reached a level, and the mean time until then."""
    after = row.estimates.get(time)
    return f"{_total(row, count):.0f}/{injected:.0f}" + (f", {after.mean:.2f} s" if after else "")


def _total(row: SystemRow, name: str) -> float:
    """Return a figure's sum over the valid runs of a row."""
    found = row.estimates[name]
    return found.mean * found.runs if found else 0.0
