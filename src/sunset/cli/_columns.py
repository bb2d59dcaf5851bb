"""Lists in columns."""

from collections.abc import Iterable, Sequence

from sunset.tables import aligned


def print_columns(header: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print rows of cells below a header, each column as wide as its widest cell."""
    for line in aligned([header, *rows], left=range(len(header))):
        print(line)
