"""Sentences, counts, lists and CSV cells; text from elsewhere is printed without effect on a terminal."""

import csv
import io
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from sunset_ros.texts import printable, shorten


def printable_json(value: object) -> object:
    """Return a value of JSON with every text in it, names included, made printable."""
    match value:
        case str():
            return printable(value)
        case list():
            return [printable_json(item) for item in value]
        case dict():
            return {printable(key): printable_json(item) for key, item in value.items()}
    return value


def counted(number: int, noun: str) -> str:
    """Return a number with its noun.

    >>> counted(1, "run"), counted(2, "run")
    ('1 run', '2 runs')
    """
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def tallied(sentences: Iterable[str]) -> list[str]:
    """Return each sentence once, with its count if it is there several times.

    >>> tallied(["it failed", "it hung", "it failed"])
    ['it failed (2 times)', 'it hung']
    """
    counts = Counter(sentences)
    return [f"{sentence} ({count} times)" if count > 1 else sentence for sentence, count in counts.items()]


def listed(names: Sequence[str]) -> str:
    """Return names as a sentence lists them.

    >>> listed(["F1"]), listed(["F1", "F2", "F3"])
    ('F1', 'F1, F2 and F3')
    """
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last


def described_error(error: BaseException) -> str:
    """Return an exception's class and text without the full stop, such as `KeyError: 'x'`."""
    parts = (_safe_text(lambda: type(error).__name__) or "an exception", _safe_text(lambda: str(error)))
    return ": ".join(filter(None, parts))


def _safe_text(describe: Callable[[], str]) -> str:
    """Return a description of a user's exception; empty if its own methods raise."""
    try:
        return shorten(describe().rstrip("."))
    except BaseException:  # noqa: BLE001  a user's method may raise anything
        return ""


def line_text(file: str | Path, line: int, function: str) -> str:
    """Return a line of a file for the end of a sentence, such as ` (mine.py, line 7, in adapt)`."""
    return f" ({Path(file).name}, line {line}, in {function})"


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    r"""Return rows as CSV.

    >>> csv_text([["-0.5", None, True]])
    '-0.5,,true\n'
    """
    out = io.StringIO()
    cells = ([str(cell).lower() if isinstance(cell, bool) else cell for cell in row] for row in rows)
    csv.writer(out, lineterminator="\n").writerows(cells)
    return out.getvalue()
