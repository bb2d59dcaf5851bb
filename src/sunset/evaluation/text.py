"""The report as text for a terminal of 100 columns."""

import textwrap
from typing import Final
from unicodedata import combining, east_asian_width

from sunset.evaluation.layout import Block, Line, Report, plain

__all__ = ["as_text"]

WIDTH: Final = 100
_GAP: Final = "  "
_RUNS: Final = "runs"
_SYSTEM: Final = "system"
_LEAST: Final = 16  # so wide is the first column at least


def as_text(report: Report) -> str:
    """Return a report as text; a name that is too long for its column has a line of its own."""
    parts = [_table(block) for block in (report.main, report.more) if block.groups]
    parts.append("\n".join(_note(note) for note in report.notes))
    return "\n\n".join(parts) + "\n"


def _note(note: str) -> str:
    return textwrap.fill(note, WIDTH, subsequent_indent="  ", break_on_hyphens=False)


def _table(block: Block) -> str:
    lines = [line for group in block.groups for line in group]
    columns = [
        [column.text, *(plain(line.cells[place]) for line in lines)]
        for place, column in enumerate(block.columns)
    ]
    widths = [max(map(_width, column)) for column in columns]
    runs = max(len(_RUNS), *(len(line.runs) for line in lines))
    others = runs + sum(widths) + len(_GAP) * (len(widths) + 1)
    first = min(max(len(_SYSTEM), *(_width(line.label) for line in lines)), max(WIDTH - others, _LEAST))
    rule = "─" * (first + others)

    def put(label: str, number: str, cells: list[str]) -> str:
        above = ""
        if _width(label) > first:  # a line of its own
            above, label = _shortened(label, len(rule)) + "\n", ""
        padded = [_pad(cell, width) for cell, width in zip(cells, widths, strict=True)]
        return above + _GAP.join([_pad(label, first), f"{number:>{runs}}", *padded]).rstrip()

    out = [f"{block.title}\n", put(_SYSTEM, _RUNS, [column.text for column in block.columns]), rule]
    for group in block.groups:
        out += [put(line.label, line.runs, _texts(line)) for line in group]
        out.append(rule)
    return "\n".join(out)


def _texts(line: Line) -> list[str]:
    return [plain(cell) for cell in line.cells]


def _width(text: str) -> int:
    """Return how many columns of a terminal a text takes."""
    return sum(2 if east_asian_width(c) in "WF" else 1 for c in text if not combining(c))


def _pad(text: str, width: int) -> str:
    return text + " " * (width - _width(text))


def _shortened(text: str, width: int) -> str:
    """Cut out the middle of a text that is too wide."""
    if _width(text) <= width:
        return text
    middle = len(text) // 2
    head, tail = text[: min(middle, width)], text[max(middle, len(text) - width) :]
    while _width(head) + _width(tail) + 1 > width:
        head, tail = (head[:-1], tail) if _width(head) >= _width(tail) else (head, tail[1:])
    return f"{head}…{tail}"
