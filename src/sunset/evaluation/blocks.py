"""What a report is made of before it has a format: tables of cells, and notes."""

from dataclasses import dataclass
from enum import Enum
from typing import Final

from sunset.evaluation.estimates import Estimate

PAPER_LABEL: Final = "tab:sunset"
"""The label of the paper's table."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A mean and, where there is one, a standard deviation."""

    mean: float
    std: float | None


@dataclass(frozen=True, slots=True)
class Interval:
    """A confidence interval."""

    low: float
    high: float


Cell = Quantity | Interval | str | None
"""What stands in a cell; None is N/A, an empty string is nothing."""


def plain(cell: Cell) -> str:
    """Return a cell as text.

    >>> plain(Quantity(-0.0012, 0.02)), plain(Interval(0.1, 1.234)), plain(None)
    ('0.00 ± 0.02', '[0.10, 1.23]', 'N/A')
    """
    match cell:
        case None:
            return "N/A"
        case Quantity(mean, None):
            return f"{mean:z.2f}"
        case Quantity(mean, std):
            return f"{mean:z.2f} ± {std:.2f}"
        case Interval(low, high):
            return f"[{low:z.2f}, {high:z.2f}]"
    return cell


@dataclass(frozen=True, slots=True)
class Column:
    """A figure's column: its heading in plain text and in LaTeX, and what it says."""

    text: str
    latex: str
    meaning: str


class LineKind(Enum):
    """What a line of a table shows."""

    OURS = "ours"
    CONFIDENCE = "confidence"
    PUBLISHED = "published"


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a table; an empty `runs` where it makes no sense to give a number."""

    kind: LineKind
    label: str
    runs: str
    cells: tuple[Cell, ...]


@dataclass(frozen=True, slots=True)
class Block:
    """A table: a title, columns, groups of lines that belong together, and the label by which LaTeX refers to it."""

    title: str
    columns: tuple[Column, ...]
    groups: tuple[tuple[Line, ...], ...]
    label: str


@dataclass(frozen=True, slots=True)
class Report:
    """All that a report says, in any format: tables, none of them empty, and the notes beneath."""

    blocks: tuple[Block, ...]
    notes: tuple[str, ...]


def interval_cell(found: Estimate | None) -> Cell:
    """Return a figure's confidence interval; nothing where it has none."""
    if found is None or found.low is None or found.high is None:
        return ""
    return Interval(found.low, found.high)
