"""The report as text for a terminal of 100 columns."""

import textwrap
from typing import Final

from rich.cells import cell_len

from sunset.evaluation.blocks import Block, Report
from sunset.texts.tables import aligned, table_width

_WIDTH: Final = 100
_GAP: Final = 2
_LEAST: Final = 11  # the least width of the first column


def as_text(report: Report) -> str:
    """Return a report as text; a name that is too long for its column gets a separate line."""
    parts = [_table(block) for block in report.blocks]
    parts.append("\n".join(map(wrapped, report.notes)))
    return "\n\n".join(parts) + "\n"


def wrapped(text: str, indent: str = "  ") -> str:
    """Return a text in lines for a terminal, all but the first with an indent."""
    return textwrap.fill(text, _WIDTH, subsequent_indent=indent, break_on_hyphens=False)


def _table(block: Block) -> str:
    rows = [block.head, *block.rows()]
    room = max(_WIDTH - table_width([row[1:] for row in rows]) - _GAP, _LEAST)
    above = ["" if cell_len(row[0]) <= room else f"{_shortened(row[0], _WIDTH)}\n" for row in rows]
    rows = [["" if name else label, *others] for name, (label, *others) in zip(above, rows, strict=True)]
    head, *lines = (
        name + line
        for name, line in zip(above, aligned(rows, left={0, *range(2, len(block.head))}), strict=True)
    )
    rule = "─" * table_width(rows)
    return "\n".join([f"{block.title}\n", head, rule, *lines, rule])


def _shortened(text: str, width: int) -> str:
    """Return a text without its middle if it is too wide."""
    if cell_len(text) <= width:
        return text
    middle = len(text) // 2
    head, tail = text[: min(middle, width)], text[max(middle, len(text) - width) :]
    while cell_len(head) + cell_len(tail) + 1 > width:
        head, tail = (head[:-1], tail) if cell_len(head) >= cell_len(tail) else (head, tail[1:])
    return f"{head}…{tail}"
