"""A report's first page: the score with what stands beside it, and how neighbours differ."""

from collections.abc import Sequence
from typing import Final

from sunset.evaluation.blocks import Block, Cell, Column, Line, LineKind, Quantity, interval_cell
from sunset.evaluation.differences import DIFFERENCE_METHOD, ManagerDifference
from sunset.evaluation.estimates import Estimate
from sunset.evaluation.scores import (
    FIRST_FIGURES,
    NO_SCORE,
    PRICE_MULTIPLES,
    SCORE_METHOD,
    ScoreRow,
    ScoreTable,
)
from sunset.texts import counted, listed

_SCORE_COLUMNS: Final = (
    Column("evidence", "evidence", "what the managing system looked at"),
    Column("score ↑", r"score $\uparrow$", "the share of what repairing can win: 0 as none, 1 as oracle"),
    Column(
        "quality ↑", r"quality $\uparrow$", "IoU_all: mean IoU, in which a frame that never came counts 0"
    ),
    Column("t_down [s] ↓", r"$t_\mathrm{down}\,[\mathrm{s}]\downarrow$", "time without segmentation"),
    Column("needless ↓", r"needless $\downarrow$", "adaptations that are no step of a cure of a fault there"),
    Column("cured ↑", r"cured $\uparrow$", "faults that were cured, of all"),
    Column("invalid", "invalid", "runs that broke a rule or are missing, and count as those of none"),
)
_HARM: Final = Column(
    "harm ↓", r"harm $\downarrow$", "what utility loses against none where nothing can be won"
)
_DIFFERENCE_COLUMNS: Final = (
    Column("score", "score", "the difference in score"),
    Column("utility", "utility", "the difference in utility"),
    Column("pairs won", "pairs won", "the share of pairs in which the first has more utility, ties by half"),
    Column("p", "$p$", "of the difference in utility, adjusted after Holm"),
)
_LEAST_P: Final = 0.001


def lead_blocks(tables: Sequence[ScoreTable]) -> tuple[Block, ...]:
    """Return the tables that a report leads with."""
    has_harm = any(row.harm for table in tables for row in table.rows)
    columns = (*_SCORE_COLUMNS[:2], *[_HARM] * has_harm, *_SCORE_COLUMNS[2:])
    blocks = []
    for table in tables:
        suite = f": {table.suite}" if table.suite else ""
        label = f"-{table.suite}" if table.suite else ""
        rows = tuple(line for row in table.rows for line in _score_lines(row, has_harm=has_harm))
        pairs = tuple(line for one in table.neighbours for line in _difference_lines(one))
        blocks.append(Block(f"The score{suite}", columns, (rows,), f"tab:sunset-score{label}"))
        if pairs:
            title = f"Differences between neighbours{suite}"
            blocks.append(Block(title, _DIFFERENCE_COLUMNS, (pairs,), f"tab:sunset-differences{label}"))
    return tuple(blocks)


def lead_notes(tables: Sequence[ScoreTable]) -> tuple[str, ...]:
    """Return what stands beneath a report about these tables."""
    if not tables:
        return ()
    scored = [table for table in tables if table.has_scores]
    missing = [
        f"{row.system}: {counted(row.missing, 'run')} that others have {'is' if row.missing == 1 else 'are'} missing."
        for table in scored
        for row in table.rows
        if row.missing
    ]
    unpaired = [
        f"{row.system}: {row.unpaired} of {counted(row.runs, 'run')} without a score, since a valid run of none or "
        "oracle is missing."
        for table in scored
        for row in table.rows
        if row.unpaired
    ]
    methods = [DIFFERENCE_METHOD] if any(table.differences for table in tables) else []
    return (SCORE_METHOD if scored else NO_SCORE, *map(_price_note, scored), *missing, *unpaired, *methods)


def _price_note(table: ScoreTable) -> str:
    """Return the order of a table's rows at all multiples of the prices, each order once."""
    found: dict[tuple[str, ...], list[str]] = {}
    for multiple in PRICE_MULTIPLES:
        found.setdefault(table.orders.get(multiple, ()), []).append(f"{multiple:g}")
    orders = "; ".join(
        f"at {listed(multiples)} times the prices {' > '.join(order)}" for order, multiples in found.items()
    )
    return f"Order{f' in {table.suite}' if table.suite else ''}: {orders}."


def _score_lines(row: ScoreRow, *, has_harm: bool) -> tuple[Line, ...]:
    # the references are what they are by definition
    score = None if row.is_reference else row.score
    found = [score, *[row.harm] * has_harm, *(row.estimates[name] for name in FIRST_FIGURES)]
    cells = [_mean(row.score), *map(_mean, found[1:])]
    cured = f"{row.cured}/{row.faults}" if row.faults else None
    evidence = {"none": "nothing", "oracle": "the faults"}.get(row.manager, row.evidence)
    lost = str(row.invalid + row.missing)
    line = Line(LineKind.OURS, row.system, str(row.runs), (evidence, *cells, cured, lost))
    return (line, *_intervals(["", *map(interval_cell, found), "", ""]))


def _difference_lines(one: ManagerDifference) -> tuple[Line, ...]:
    cells: tuple[Cell, ...] = (
        _mean(one.score),
        _mean(one.utility),
        None if one.pairs_won is None else Quantity(one.pairs_won, None),
        None if one.p is None else f"< {_LEAST_P}" if one.p < _LEAST_P else f"{one.p:.3f}",
    )
    line = Line(LineKind.OURS, f"{one.first} − {one.second}", str(one.pairs), cells)
    return (line, *_intervals([interval_cell(one.score), interval_cell(one.utility), "", ""]))


def _intervals(cells: Sequence[Cell]) -> tuple[Line, ...]:
    """Return the line of the confidence intervals; none where there is no interval."""
    return (Line(LineKind.CONFIDENCE, "  95 % conf.", "", tuple(cells)),) if any(cells) else ()


def _mean(found: Estimate | None) -> Cell:
    return None if found is None else Quantity(found.mean, None)
