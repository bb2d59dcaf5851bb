"""What became of the faults in the runs of a row: columns of the report, and the time to cure by failure."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from sunset.evaluation.blocks import Block, Cell, Column, Line, LineKind, Quantity, interval_cell
from sunset.evaluation.estimates import Estimate
from sunset.evaluation.summary import SystemRow
from sunset.evaluation.survival import Survival, kaplan_meier
from sunset.metrics import FATES, FaultOutcome
from sunset.texts import shorten

_COLUMNS: Final[Mapping[str, Column]] = MappingProxyType(
    {
        "cured": Column("cured ↑", r"cured $\uparrow$", "faults that the managing system cured, of all"),
        "masked_s": Column(
            "masked [s] ↓",
            r"masked $[\mathrm{s}]\downarrow$",
            "time in which a fault was there, its symptom was not, and the segmentation was bad",
        ),
        "adaptations_mistreated": Column(
            "mistreated ↓", r"mistreated $\downarrow$", "adaptations that treat no fault that is there"
        ),
    }
)
_TIME_TO_CURE_NOTE: Final = (
    "Time to cure: mean over faults from onset to cure by the estimate of Kaplan and Meier, in which one that heals "
    "counts until then, as if it would have been cured later as the others were; one that is cured later than the "
    "measured time is long, or not at all, counts with that time. It says little of who lets faults heal."
)
ALL: Final = "all"
"""What stands in the place of a failure for all faults together."""


@dataclass(frozen=True, slots=True)
class TimeToCure:
    """The time from onset to cure of the faults of one failure.

    Attributes:
        survival: which share is not cured yet, over the time since the onset [s].
        horizon_s: how much time at most counts for the mean [s].
    """

    survival: Survival
    horizon_s: float

    @property
    def mean_s(self) -> float:
        """The restricted mean [s]."""
        return self.survival.restricted_mean(self.horizon_s)

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values, with the steps of the curve."""
        return {
            "faults": self.survival.number,
            "cured": self.survival.events,
            "restricted_mean_s": self.mean_s,
            "horizon_s": self.horizon_s,
            "times_s": self.survival.times.tolist(),
            "not_cured": self.survival.shares.tolist(),
        }


def fault_blocks(rows: Sequence[SystemRow]) -> tuple[Block, ...]:
    """Return the tables of what became of the faults: the figures, and the time to cure by failure."""
    judged = [row for row in rows if not row.is_reference]
    names, columns = tuple(_COLUMNS), tuple(_COLUMNS.values())
    groups = tuple(
        lines_of(row, fault_cells(row, names), tuple(row.estimates.get(name) for name in names))
        for row in judged
    )
    times = {row.system: times_to_cure(row.outcomes, row.flight.duration_s) for row in judged}
    failures = sorted({failure for found in times.values() for failure in found} - {ALL})
    failures += [ALL] * (len(failures) > 1)
    by_failure = tuple(
        lines_of(row, tuple(_mean(times[row.system].get(failure)) for failure in failures))
        for row in judged
        if times[row.system]
    )
    heads = tuple(_head(name) for name in failures)
    return (
        Block("What became of the faults", columns, groups, "tab:sunset-faults"),
        Block("Time to cure by failure [s]", heads, by_failure, "tab:sunset-cures"),
    )


def fault_cells(row: SystemRow, names: Sequence[str]) -> tuple[Cell, ...]:
    """Return a row's cells in some columns of what became of the faults."""
    return tuple(_cell(row, name) for name in names)


def fault_notes(rows: Sequence[SystemRow]) -> list[str]:
    """Return what a reader must know of the tables of what became of the faults."""
    notes = [_TIME_TO_CURE_NOTE] if any(row.outcomes for row in rows) else []
    notes += [untold_note(row.system, row.untold, row.runs) for row in rows if row.untold]
    for row in rows:
        found = row.estimates["adaptations_mistreated"]
        if found is not None and found.mean > row.flight.duration_s:
            notes.append(
                f"{row.system}: {found.mean:.0f} adaptations of a run treated no fault that was there, more than one "
                "for each second measured: its times to cure may come of repairing without looking."
            )
    return notes


def untold_note(system: str, untold: int, runs: int) -> str:
    """Return what a reader must know where so many of a managing system's runs do not say what became of the faults."""
    return (
        f"{shorten(system, 100)}: {untold} of {runs} runs are of a version that did not say what became of the faults; "
        "--recompute finds it out."
    )


def lines_of(
    row: SystemRow, cells: tuple[Cell, ...], estimates: Sequence[Estimate | None] = ()
) -> tuple[Line, ...]:
    """Return a row's line and, where there are any, one with the confidence intervals of estimates."""
    intervals = tuple(map(interval_cell, estimates))
    line = Line(LineKind.OURS, row.system, str(row.runs), cells)
    if not any(intervals):
        return (line,)
    return (line, Line(LineKind.CONFIDENCE, "  95 % conf.", "", intervals))


def times_to_cure(outcomes: Iterable[FaultOutcome], horizon_s: float) -> Mapping[str, TimeToCure]:
    """Return the time to cure by failure, in their order, and that of `ALL` faults last; nothing without a fault.

    Args:
        outcomes: of the faults of some runs.
        horizon_s: how long a run is measured.
    """
    by_failure: dict[str, list[FaultOutcome]] = {}
    for outcome in outcomes:
        by_failure.setdefault(outcome.failure, []).append(outcome)
    groups = {failure: by_failure[failure] for failure in sorted(by_failure)}
    if groups:
        groups[ALL] = [outcome for group in groups.values() for outcome in group]
    return MappingProxyType(
        {failure: TimeToCure(_survival(group), horizon_s) for failure, group in groups.items()}
    )


def fates(outcomes: Iterable[FaultOutcome]) -> Mapping[str, Mapping[str, int]]:
    """Return how many of each fault were cured, masked or missed: fault → fate → number."""
    counts: dict[str, dict[str, int]] = {}
    for outcome in outcomes:
        of_fault = counts.setdefault(outcome.fault, dict.fromkeys(FATES, 0))
        of_fault[outcome.fate] += 1
    return MappingProxyType({fault: MappingProxyType(counts[fault]) for fault in sorted(counts)})


def _survival(outcomes: Sequence[FaultOutcome]) -> Survival:
    return kaplan_meier(
        [outcome.observed_s for outcome in outcomes], [outcome.cured is not None for outcome in outcomes]
    )


def cured_rate(row: SystemRow) -> float | None:
    """Return the share of a row's faults that was cured; None where there was none."""
    cured = sum(outcome.cured is not None for outcome in row.outcomes)
    return cured / len(row.outcomes) if row.outcomes else None


def _head(failure: str) -> Column:
    name = failure.replace("_", r"\_")
    what = "all faults" if failure == ALL else f"faults that show as {failure}"
    return Column(f"{failure} ↓", rf"{name} $\downarrow$", f"mean time from onset to cure of {what}")


def _cell(row: SystemRow, name: str) -> Cell:
    if name == "cured":
        rate = cured_rate(row)
        cured = sum(outcome.cured is not None for outcome in row.outcomes)
        return None if rate is None else f"{cured}/{len(row.outcomes)} ({rate:.0%})"
    found = row.estimates[name]
    return None if found is None else Quantity(found.mean, found.std)


def _mean(found: TimeToCure | None) -> Cell:
    return None if found is None else Quantity(found.mean_s, None)
