"""A report's first page: scores with the figures beside them, and differences between neighbours."""

import re
from collections.abc import Iterator, Sequence
from typing import Final

from sunset.evaluation.blocks import CURED, NEEDLESS, Block, Column, Line, Quantity, interval_cell
from sunset.evaluation.differences import DIFFERENCE_METHOD, ManagerDifference
from sunset.evaluation.intervals import NO_INTERVAL
from sunset.evaluation.scores import HARM, NO_SCORE, SCORE_METHOD, ScoreRow, ScoreTable
from sunset.texts.sentences import counted, listed

_SCORE_COLUMNS: Final = (
    Column("evidence", "what the managing system looked at, and is ranked by"),
    Column("score ↑", "the share of what repairing can win: 0 as none, 1 as oracle; with its 95 % interval"),
    Column("quality ↑", "mean IoU of all frames (IoU_all), of which one that never came counts 0"),
    Column("t_down ↓", "time of a run without segmentation"),
    NEEDLESS,
    CURED,
)
_HARM_COLUMNS: Final = (Column("harm ↓", "what utility loses against none where repairing wins nothing"),)
_DIFFERENCE_COLUMNS: Final = (
    Column("score", "the difference in score"),
    Column("utility", "the difference in utility"),
    Column("pairs won", "the share of pairs in which the first has more utility, ties by half"),
    Column("p", "of the difference in utility, adjusted after Holm"),
)
_LEAST_P: Final = 0.001
_BESIDE: Final = (
    "Beside the score: "
    + "; ".join(
        f"{column.text.rstrip(' ↑↓')}: {column.meaning}"
        for column in _SCORE_COLUMNS
        if "score" not in column.text
    )
    + "."
)


def lead_blocks(tables: Sequence[ScoreTable]) -> tuple[Block, ...]:
    """Return the tables of a report's first page."""
    blocks = []
    for table in tables:
        names = re.findall(r"[a-z0-9.]+", table.title.lower())
        rows = sorted(table.rows, key=lambda row: row.evidence == "images")  # evidence is ranked apart
        parts = (
            ("The score", "score", _SCORE_COLUMNS, map(_score_line, rows)),
            ("Harm where there is nothing to repair", "harm", _HARM_COLUMNS, _harm_lines(table)),
            (
                *("Differences between neighbours", "differences", _DIFFERENCE_COLUMNS),
                map(_difference_line, table.neighbours),
            ),
        )
        blocks += [
            Block(
                title + (f": {table.title}" if table.title else ""),
                columns,
                tuple(lines),
                "-".join(("tab:sunset", label, *names)),
            )
            for title, label, columns, lines in parts
        ]
    return tuple(blocks)


def lead_notes(tables: Sequence[ScoreTable]) -> tuple[str, ...]:
    """Return the notes of a report about its first page."""
    if not tables:
        return ()
    scored = [table for table in tables if table.has_scores]
    rows = [row for table in scored for row in table.rows]
    pairs = [pair for table in tables for pair in table.neighbours]
    estimates = [
        *(estimate for row in rows for estimate in (row.score, row.harm)),
        *(estimate for pair in pairs for estimate in (pair.score, pair.utility)),
    ]
    return (
        SCORE_METHOD if scored else NO_SCORE,
        *([HARM] if any(row.harm for row in rows) else []),
        _BESIDE,
        *(_price_note(table, evidence) for table in scored if table.orders for evidence in table.classes),
        *(
            f"{row.system}{_where(table)}: {row.unpaired} of {counted(row.runs, 'run')} without a score, since a valid "
            "run of none or oracle is missing."
            for table in scored
            for row in table.rows
            if row.unpaired
        ),
        *([DIFFERENCE_METHOD] if pairs else []),
        *filter(None, map(_sizes, scored)),
        *([NO_INTERVAL] if any(estimate and estimate.lacks_interval for estimate in estimates) else []),
    )


def _price_note(table: ScoreTable, evidence: str) -> str:
    """Return a note about the order of rows with the same evidence, and its changes at multiples of the prices."""
    orders = table.orders_of(evidence)
    order = orders[1.0]
    changed: dict[tuple[str, ...], list[str]] = {}
    for multiple, other in orders.items():
        if other != order:
            changed.setdefault(_changed(other, order), []).append(f"{multiple:g}")
    others = [
        f"at {listed(multiples)} times the prices {' > '.join(names)}" for names, multiples in changed.items()
    ]
    same = [f"{multiple:g}" for multiple, other in orders.items() if multiple != 1 and other == order]
    if same:
        others.insert(0, f"the same at {listed(same)} times the prices")
    by = f" by {evidence} (oracle and none for reference)" if len(table.classes) > 1 else ""
    return f"Order{_where(table)}{by}: {'; '.join([' > '.join(order), *others])}."


def _sizes(table: ScoreTable) -> str:
    """Return a note about the numbers of degradations, flights and seeds; empty without intervals."""
    sizes = max(
        (row.score.spread.sizes for row in table.rows if row.score and row.score.spread), default=None
    )
    if sizes is None:
        return ""
    alike, flights, seeds = (
        counted(*of) for of in zip(sizes, ("degradation", "flight", "seed"), strict=True)
    )
    return f"Intervals{_where(table)} are of {alike}, {flights} and {seeds}."


def _where(table: ScoreTable) -> str:
    return f" in the suite {table.title}" if table.title else ""


def _changed(order: tuple[str, ...], usual: tuple[str, ...]) -> tuple[str, ...]:
    """Return the part of an order that differs from the usual order."""
    places = [place for place, names in enumerate(zip(order, usual, strict=True)) if len(set(names)) > 1]
    return order[places[0] : places[-1] + 1]


def _score_line(row: ScoreRow) -> Line:
    lost = {"invalid": row.invalid, "missing": row.missing}
    runs = ", ".join([str(row.runs), *(f"{number} {state}" for state, number in lost.items() if number)])
    # the scores of references are 0 and 1 by definition
    score = Quantity(row.score.mean) if row.score and row.is_reference else interval_cell(row.score)
    quality, down, needless = (
        None if estimate is None else Quantity(estimate.mean) for estimate in row.estimates.values()
    )
    return Line(
        row.system,
        runs,
        (
            *(row.evidence, score, quality, down and f"{down.mean:.2f} s", needless),
            f"{row.cured}/{row.faults}" if row.faults else None,
        ),
    )


def _harm_lines(table: ScoreTable) -> Iterator[Line]:
    for row in table.rows:
        if row.harm:
            yield Line(row.system, str(row.harm.runs), (interval_cell(row.harm),))


def _difference_line(pair: ManagerDifference) -> Line:
    won = None if pair.pairs_won is None else Quantity(pair.pairs_won)
    p = None if pair.p_holm is None else f"< {_LEAST_P}" if pair.p_holm < _LEAST_P else f"{pair.p_holm:.3f}"
    cells = (interval_cell(pair.score), interval_cell(pair.utility), won, p)
    return Line(f"{pair.first} − {pair.second}", str(pair.pairs), cells)
