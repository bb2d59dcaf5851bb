"""A report before it has a format, as tables of cells and notes, and as text for a terminal of 100 columns."""

import textwrap
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

from rich.cells import cell_len

from sunset.texts.tables import aligned, table_width
from sunset_ros.texts import printable

_WIDTH: Final = 100
_GAP: Final = 2
_LEAST: Final = 11  # the least width of the first column

PAPER_LABEL: Final = "tab:sunset"
"""The label of the paper's table."""


class Quantity(NamedTuple):
    """A mean with a standard deviation, a confidence interval, or neither."""

    mean: float
    std: float | None = None
    interval: tuple[float, float] | None = None


Cell = Quantity | str | None
"""The content of a cell; None is N/A."""


def plain(cell: Cell) -> str:
    """Return a cell as text.

    >>> plain(Quantity(-0.0012, 0.02)), plain(Quantity(0.5, interval=(0.1, 1.234))), plain(None)
    ('0.00 ± 0.02', '0.50 [0.10, 1.23]', 'N/A')
    """
    match cell:
        case None:
            return "N/A"
        case Quantity(mean, std, interval):
            deviation = "" if std is None else f" ± {std:.2f}"
            low, high = interval or (mean, mean)
            return f"{mean:z.2f}{deviation}" + (f" [{low:z.2f}, {high:z.2f}]" if interval else "")
    return cell


class Column(NamedTuple):
    """A figure's column: its heading, in which `_` stands before an index, and its meaning."""

    text: str
    meaning: str


class Line(NamedTuple):
    """A line of a table; `runs` is empty where a number makes no sense."""

    label: str
    runs: str
    cells: Sequence[Cell]


class Block(NamedTuple):
    """A table: its title, columns and lines, and the label by which LaTeX refers to it."""

    title: str
    columns: Sequence[Column]
    lines: Sequence[Line]
    label: str

    @property
    def head(self) -> list[str]:
        """The headings of all columns."""
        return ["system", "runs", *(column.text for column in self.columns)]

    def rows(self, shown: Callable[[Cell], str] = plain) -> list[list[str]]:
        """Return the texts of all lines, with cells as `shown` returns them."""
        return [[line.label, line.runs, *map(shown, line.cells)] for line in self.lines]


class Report(NamedTuple):
    """The content of a report in any format: tables with lines, and notes."""

    blocks: Sequence[Block]
    notes: Sequence[str]


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
    above = ["" if cell_len(row[0]) <= room else f"{short_name(row[0], _WIDTH)}\n" for row in rows]
    rows = [["" if name else label, *others] for name, (label, *others) in zip(above, rows, strict=True)]
    head, *lines = (
        name + line
        for name, line in zip(above, aligned(rows, left={0, *range(2, len(block.head))}), strict=True)
    )
    rule = "─" * table_width(rows)
    return "\n".join([f"{block.title}\n", head, rule, *lines, rule])


def short_name(text: str, longest: int = 24) -> str:
    """Return a name without its middle if it has many characters.

    >>> short_name("a-managing-system-with-a-long-name")
    'a-managing-s…a-long-name'
    """
    text, half = printable(text), longest // 2
    return text if len(text) <= longest else f"{text[:half]}…{text[1 - half :]}"
