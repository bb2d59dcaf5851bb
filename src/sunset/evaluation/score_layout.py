"""What a report leads with: the scores, and how managing systems differ."""

from collections.abc import Sequence
from typing import Final

from sunset.evaluation.blocks import Block, Cell, Column, Line, LineKind, Quantity, interval_cell
from sunset.evaluation.differences import DIFFERENCE_METHOD, ManagerDifference
from sunset.evaluation.estimates import Estimate
from sunset.evaluation.power import DIFFERENCE, POWER
from sunset.evaluation.scores import NO_SCORE, SCORE_METHOD, ScoreRow, ScoreTable
from sunset.texts import counted

_SCORE_COLUMNS: Final = (
    Column(
        "score ↑", r"score $\uparrow$", "how much is won of what repairing can win: 0 as none, 1 as oracle"
    ),
    Column(
        "harm ↓", r"harm $\downarrow$", "what IoU_net loses against none where there is nothing to repair"
    ),
    Column("scored", "scored", "runs in which there is something to repair"),
    Column("nothing to repair", "nothing to repair", "runs that count for harm"),
    Column("invalid", "invalid", "invalid runs, which count as those of none, or as they were if worse"),
    Column("without a pair", "without a pair", "runs without a valid one of none and of oracle beside them"),
)
_DIFFERENCE_COLUMNS: Final = (
    Column("score", "score", "the difference in score"),
    Column("IoU_net", r"IoU$_\mathrm{net}$", "the difference in IoU_net"),
    Column("pairs won", "pairs won", "the share of pairs in which the first has more IoU_net, ties by half"),
    Column("p", "$p$", "of the difference in IoU_net, adjusted after Holm"),
    Column("detectable", "detectable", f"the difference in IoU_net that is detected with {100 * POWER:g} %"),
    Column(
        f"runs for {DIFFERENCE:g}",
        f"runs for {DIFFERENCE:g}",
        f"how many runs of each detect a difference of {DIFFERENCE:g} so",
    ),
)
_LEAST_P: Final = 0.001


def lead_blocks(tables: Sequence[ScoreTable]) -> tuple[Block, ...]:
    """Return the tables that a report leads with."""
    scores = tuple(
        tuple(line for row in table.rows for line in _score_lines(row))
        for table in tables
        if table.has_scores
    )
    differences = tuple(
        tuple(line for one in table.neighbours for line in _difference_lines(one)) for table in tables
    )
    return (
        Block("The score", _SCORE_COLUMNS, scores, "tab:sunset-score"),
        Block("Differences between neighbours", _DIFFERENCE_COLUMNS, differences, "tab:sunset-differences"),
    )


def lead_notes(tables: Sequence[ScoreTable]) -> tuple[str, ...]:
    """Return what stands beneath a report about these tables."""
    if not tables:
        return ()
    scored = [table for table in tables if table.has_scores]
    unpaired = [
        f"{row.system}: {row.unpaired} of {counted(row.runs, 'run')} without a score, for want of one of none or "
        "oracle."
        for table in scored
        for row in table.rows
        if row.unpaired
    ]
    uneven = [
        f"Where others have {most} runs, some have fewer, and may lack those that go badly: {'; '.join(few)}."
        for table in tables
        if (most := max(table.runs_counted))
        if (
            few := [
                f"{row.system} has {runs}"
                for row, runs in zip(table.rows, table.runs_counted, strict=True)
                if runs < most
            ]
        )
    ]
    return (SCORE_METHOD if scored else NO_SCORE, *unpaired, *uneven, DIFFERENCE_METHOD)


def _score_lines(row: ScoreRow) -> tuple[Line, ...]:
    counts = (_runs(row.score), _runs(row.harm), str(row.invalid), str(row.unpaired))
    label = f"{row.system} (reference)" if row.is_reference else row.system
    line = Line(LineKind.OURS, label, str(row.runs), (_mean(row.score), _mean(row.harm), *counts))
    # the references are what they are by definition
    found = (None, row.harm) if row.is_reference else (row.score, row.harm)
    return (line, *_intervals(found, len(_SCORE_COLUMNS)))


def _difference_lines(one: ManagerDifference) -> tuple[Line, ...]:
    needed = "N/A" if one.detectable is None else "never" if one.runs_needed is None else str(one.runs_needed)
    cells: tuple[Cell, ...] = (
        _mean(one.score),
        _mean(one.iou_net),
        None if one.pairs_won is None else Quantity(one.pairs_won, None),
        None if one.p is None else f"< {_LEAST_P}" if one.p < _LEAST_P else f"{one.p:.3f}",
        None if one.detectable is None else Quantity(one.detectable, None),
        needed,
    )
    line = Line(LineKind.OURS, f"{one.first} − {one.second}", str(one.pairs), cells)
    return (line, *_intervals((one.score, one.iou_net), len(_DIFFERENCE_COLUMNS)))


def _intervals(found: Sequence[Estimate | None], columns: int) -> tuple[Line, ...]:
    """Return the line of the confidence intervals of the first columns; none where there is no interval."""
    cells = [interval_cell(one) for one in found]
    if not any(cells):
        return ()
    return (Line(LineKind.CONFIDENCE, "  95 % conf.", "", (*cells, *[""] * (columns - len(cells)))),)


def _mean(found: Estimate | None) -> Cell:
    return None if found is None else Quantity(found.mean, None)


def _runs(found: Estimate | None) -> str:
    return str(found.runs if found else 0)
