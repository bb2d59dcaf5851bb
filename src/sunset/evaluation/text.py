"""The report as text for a terminal of 100 columns."""

import textwrap
from typing import Final

from rich.cells import cell_len

from sunset.evaluation.blocks import Block, Report, plain
from sunset.tables import aligned, table_width

_WIDTH: Final = 100
_GAP: Final = 2
_LEAST: Final = 16  # so wide is the first column at least


def as_text(report: Report) -> str:
    """Return a report as text; a name that is too long for its column has a line of its own."""
    parts = [_table(block) for block in report.blocks]
    parts.append("\n".join(map(wrapped, report.notes)))
    return "\n\n".join(parts) + "\n"


def wrapped(text: str, indent: str = "  ") -> str:
    """Return a text in lines for a terminal, with an indent of all but the first."""
    return textwrap.fill(text, _WIDTH, subsequent_indent=indent, break_on_hyphens=False)


def _table(block: Block) -> str:
    head = ["system", "runs", *(column.text for column in block.columns)]
    rows = [[line.label, line.runs, *map(plain, line.cells)] for group in block.groups for line in group]
    others = table_width([row[1:] for row in (head, *rows)]) + _GAP
    room = max(_WIDTH - others, _LEAST)
    names = [row[0] for row in rows]
    for row in rows:
        if cell_len(row[0]) > room:  # a line of its own
            row[0] = ""
    rule = "─" * table_width([head, *rows])
    first, *lines = aligned([head, *rows], left={0, *range(2, len(head))})
    out = [f"{block.title}\n", first, rule]
    numbered = zip(names, rows, lines, strict=True)
    for group in block.groups:
        for _ in group:
            name, row, line = next(numbered)
            out += [line] if row[0] == name else [_shortened(name, _WIDTH), line]
        out.append(rule)
    return "\n".join(out)


def _shortened(text: str, width: int) -> str:
    """Cut out the middle of a text that is too wide."""
    if cell_len(text) <= width:
        return text
    middle = len(text) // 2
    head, tail = text[: min(middle, width)], text[max(middle, len(text) - width) :]
    while cell_len(head) + cell_len(tail) + 1 > width:
        head, tail = (head[:-1], tail) if cell_len(head) >= cell_len(tail) else (head, tail[1:])
    return f"{head}…{tail}"
