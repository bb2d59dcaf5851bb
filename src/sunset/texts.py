"""Text that others wrote, such that it does nothing but stand where it is printed."""

import csv
import io
from collections.abc import Iterable
from typing import Any

__all__ = ["csv_text", "printable", "printable_json"]


def printable(text: str) -> str:
    r"""Return `text` with escapes for what a terminal obeys instead of showing it; lines and tabs stay.

    >>> printable("\x1b[2JFlight ü\u202e")
    '\\x1b[2JFlight ü\\u202e'
    """
    if text.isprintable():
        return text
    return "".join(
        character
        if character.isprintable() or character in "\n\t"
        else character.encode("unicode_escape").decode()
        for character in text
    )


def printable_json(value: Any) -> Any:
    """Return a value of JSON with every text in it, names included, made printable.

    Raises:
        RecursionError: it is nested too deeply.
    """
    match value:
        case str():
            return printable(value)
        case list():
            return [printable_json(item) for item in value]
        case dict():
            return {printable(key): printable_json(item) for key, item in value.items()}
    return value


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    r"""Return rows as CSV; a text that a spreadsheet would compute has an apostrophe before it.

    >>> csv_text([["=1+1", "-0.5", None, 2]])
    "'=1+1,-0.5,,2\n"
    """
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([_inert(cell) for cell in row] for row in rows)
    return out.getvalue()


def _inert(cell: object) -> object:
    return (
        f"'{cell}"
        if isinstance(cell, str) and cell.startswith(tuple("=@+-")) and not _is_number(cell)
        else cell
    )


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
