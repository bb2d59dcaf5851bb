"""Arguments of calls: paths, numbers, names and flags, as Python's own types whatever library they come from."""

import operator
import re
from collections.abc import Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from decimal import Decimal
from numbers import Real
from pathlib import Path
from typing import Any, Final, TypeAlias

from sunset.errors import InvalidInputError
from sunset.system import System, extended_system
from sunset_ros.texts import shown, suggestion

Extensions: TypeAlias = str | Path | Sequence[str | Path]
"""Extensions of the managed system: one or several Python files, or names of installed extensions."""

_ITEMS: Final = re.compile(r"""(?:[^,'"\\]|\\.|'[^']*'|"(?:\\.|[^"\\])*"|['"\\])+""")
"""Items that commas separate, except commas in quotes or behind a backslash, as in the command of a program."""


def extended(extensions: Extensions) -> AbstractContextManager[System]:
    """Return a context in which the managed system has these extensions.

    Raises:
        InvalidInputError: they are neither paths nor names.
        ExtensionError: an extension cannot be loaded, which is noticed when the context is entered.
    """
    named = [extensions] if isinstance(extensions, str | Path) else extensions
    if not isinstance(named, list | tuple):
        raise InvalidInputError(
            f"The extensions must be a path, a name, or a list of them, got {shown(named)}."
        )
    return extended_system([str(as_path(extension, "extension")) for extension in named])


def as_path(path: str | Path, name: str) -> Path:
    """Return a path that was given as a text or a path; messages call it `name`.

    Raises:
        InvalidInputError: it is neither, or empty.
    """
    if not isinstance(path, str | Path) or not str(path):
        raise InvalidInputError(f"The {name} must be a path, got {shown(path)}.")
    return Path(path)


def optional_path(path: str | Path | None, name: str) -> Path | None:
    """Return a path as `as_path` does, or None."""
    return None if path is None else as_path(path, name)


def whole_of(value: Any) -> Any:
    """Return a whole number as Python's own; any other value is returned as it is, for a later check."""
    try:
        return value if isinstance(value, bool) else operator.index(value)
    except TypeError:
        return value


def number_of(value: Any) -> Any:
    """Return a number as Python's own; any other value is returned as it is, for a later check."""
    return value if isinstance(value, bool) or not isinstance(value, Real | Decimal) else float(value)


def count_of(number: int | None, name: str) -> int | None:
    """Return a count, such as `jobs`, as Python's own number; or None.

    Raises:
        InvalidInputError: it is not a whole number from 1 on.
    """
    count: int | None = whole_of(number)
    if count is not None and (isinstance(count, bool) or not isinstance(count, int) or count < 1):
        raise InvalidInputError(f"The number of {name} must be a whole one from 1 on, got {shown(number)}.")
    return count


def check_names(options: Mapping[str, object], known: Collection[str]) -> None:
    """Check that options are known.

    Raises:
        InvalidInputError: an option is unknown.
    """
    for name in options:
        if name not in known:
            raise InvalidInputError(
                f"There is no option {name!r}: {suggestion(name, known)}choose among {', '.join(known)}."
            )


def names_of(names: str | Path | Sequence[str | Path], kind: str) -> tuple[str, ...]:
    """Return names or paths of a kind, given as a list, or as a text in which commas outside quotes separate them.

    Raises:
        InvalidInputError: they are anything else.
    """
    listed: object = [names] if isinstance(names, Path) else names  # a path may have commas in it
    listed = _ITEMS.findall(listed) if isinstance(listed, str) else listed
    if not isinstance(listed, list | tuple) or not all(isinstance(name, str | Path) for name in listed):
        raise InvalidInputError(f"The {kind} must be a list of names, got {shown(names)}.")
    return tuple(name for name in (str(each).strip() for each in listed) if name)


def chosen_names(
    names: str | Path | Sequence[str | Path], kind: str, *, values: str, default: str
) -> tuple[str, ...]:
    """Return names as `names_of` does; an empty tuple stands for the default.

    Raises:
        InvalidInputError: they are not names, or an empty text, which is less than the default.
    """
    chosen = names_of(names, kind)
    if not chosen and names not in ((), []):
        raise InvalidInputError(
            f"The {kind} must be {values}, got {shown(names)}; leave them out for {default}."
        )
    return chosen


def chosen_flights(names: str | Path | Sequence[str | Path]) -> tuple[str, ...]:
    """Return the flights of a campaign; an empty tuple stands for each scenario's own flight."""
    return chosen_names(names, "flights", values="names or bags", default="each scenario's own")
