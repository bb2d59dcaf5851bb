"""What `run.json` says of a run, checked where it is used."""

import math
import reprlib
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from sunset.errors import RecordError
from sunset.metrics import RunMetrics

__all__ = ["check_entries", "check_entry", "check_number", "differing_figures", "stored_figures"]

_TYPES: Final = MappingProxyType(
    {
        "scenario": str,
        "suite": str,
        "manager": str,
        "seed": int,
        "model": str,
        "model_checksums": dict,
        "middleware": str,
        "digest": str,
        "valid": bool,
        "reason": str,
    }
)
"""What every run has."""
_SHARES: Final = frozenset({"availability", "iou", "iou_all", "miou"})
_MOST: Final = 1e6
"""No figure or number of a run is larger; twelve days, of those that are times."""


def check_entries(run: Mapping[str, Any], where: Path) -> dict[str, Any]:
    """Return the entries of `run.json` that say which run it is and whether it counts; `where` is that file.

    Raises:
        RecordError: one is missing, or of another type.
    """
    return {key: check_entry(run, key, kind, where) for key, kind in _TYPES.items()}


def check_entry(run: Mapping[str, Any], key: str, kind: type, where: Path) -> Any:
    """Return an entry of `run.json`; `where` is that file.

    Raises:
        RecordError: it is missing, or of another type.
    """
    value = run.get(key)
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise RecordError(f"The {key} in {where} must be of type {kind.__name__}, got {reprlib.repr(value)}.")
    return value


def check_number(run: Mapping[str, Any], key: str, where: Path) -> float:
    """Return an entry of `run.json` that must be a number above 0; `where` is that file.

    Raises:
        RecordError: it is not, or out of all proportion.
    """
    value = run.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value <= _MOST:
        raise RecordError(
            f"The {key} in {where} must be a number above 0 and at most {_MOST:g}, got {reprlib.repr(value)}."
        )
    return value


def stored_figures(run: Mapping[str, Any], where: Path) -> Mapping[str, float | None]:
    """Return the figures that `run.json` gives; `where` is that file.

    Raises:
        RecordError: one is missing, or is none that a run can have.
    """
    stored = check_entry(run, "metrics", dict, where)
    return MappingProxyType({name: _figure(stored, name, where) for name in RunMetrics.names()})


def differing_figures(stored: object, computed: Mapping[str, float | None]) -> tuple[str, ...]:
    """Return the names of the figures that are stored otherwise than they were computed from the messages."""
    known = stored if isinstance(stored, Mapping) else {}
    return tuple(
        name for name in RunMetrics.names() if name in known and not _same(known[name], computed[name])
    )


def _figure(stored: Mapping[str, Any], name: str, where: Path) -> float | None:
    """Return one stored figure: a number that a run can have, or None."""
    if name not in stored:
        raise RecordError(f"The metrics in {where} lack {name}; run it again, or use --recompute.")
    value = stored[name]
    if value is None:
        return None
    low, high = (-_MOST, _MOST) if name == "t_decide_s" else (0, 1 if name in _SHARES else _MOST)
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise RecordError(
            f"The metric {name} in {where} must be a number from {low:g} to {high:g} or null, got "
            f"{reprlib.repr(value)}."
        )
    return value


def _same(one: object, other: object) -> bool:
    """Return whether two figures are equal, but for the last digits that another computer may give."""
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-9)
    return one == other
