"""Tables of text: in columns for a terminal, and in Markdown."""

from collections.abc import Collection, Iterator, Sequence

from rich.cells import cell_len

_GAP = 2
"""Spaces between two columns."""


def aligned(rows: Sequence[Sequence[str]], left: Collection[int] = (0,)) -> Iterator[str]:
    """Yield the lines of a table, each column as wide as its widest cell on a terminal.

    Args:
        rows: rows of the same number of cells, the head first.
        left: the columns that are aligned to the left, instead of the right.

    >>> list(aligned([("name", "frames"), ("lite", "7")]))
    ['name  frames', 'lite       7']
    """
    for cells in _padded(rows, left):
        yield (" " * _GAP).join(cells).rstrip()


def table_width(rows: Sequence[Sequence[str]]) -> int:
    """Return the width of a table's lines, in columns of a terminal."""
    widths = _widths(rows)
    return sum(widths) + _GAP * (len(widths) - 1)


def markdown_table(rows: Sequence[Sequence[str]]) -> str:
    """Return a table in Markdown, the head first; the first column is aligned to the left, the others to the right.

    >>> print(markdown_table([("name", "frames"), ("lite", "7")]))
    | name | frames |
    |------|-------:|
    | lite |      7 |
    """
    rule = "|".join("-" * (width + 1) + (":" if place else "-") for place, width in enumerate(_widths(rows)))
    head, *others = (f"| {' | '.join(cells)} |" for cells in _padded(rows, left=(0,)))
    return "\n".join([head, f"|{rule}|", *others])


def _widths(rows: Sequence[Sequence[str]]) -> list[int]:
    return [max(map(cell_len, column)) for column in zip(*rows, strict=True)]


def _padded(rows: Sequence[Sequence[str]], left: Collection[int]) -> Iterator[list[str]]:
    widths = _widths(rows)
    for row in rows:
        spaces = [" " * (width - cell_len(cell)) for width, cell in zip(widths, row, strict=True)]
        pairs = enumerate(zip(row, spaces, strict=True))
        yield [cell + space if place in left else space + cell for place, (cell, space) in pairs]
