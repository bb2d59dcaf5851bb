"""Stored runs: found, read, checked, and computed again where that is asked for."""

import hashlib
import json
import math
import reprlib
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from sunset.errors import RecordError
from sunset.metrics import score
from sunset.recording import RUN_FILE, read_run, read_timeline

__all__ = ["FIGURES", "RunRow", "load_results", "recompute"]

FIGURES: Final = (
    "f_resolved_per_adaptation",
    "t_react_s",
    "t_detect_s",
    "t_decide_s",
    "t_repair_s",
    "redeploys_unnecessary",
    "t_down_s",
    "availability",
    "iou",
    "iou_all",
    "miou",
    "episodes",
    "episodes_resolved",
    "episodes_unresolved",
    "episodes_subsided",
    "adaptations",
)
"""The names of a run's figures, as `RunMetrics` has them."""

Progress = Callable[[int, int], None]
"""Called with (runs that are read, runs in all)."""
_CHECKSUM: Final = 8
"""Digits of a short checksum."""
_SHARES: Final = frozenset({"availability", "iou", "iou_all", "miou"})
_MOST: Final = 1e6
"""No figure of a run is larger; twelve days, of those that are times."""
_SETTING: Final = ("entropy_threshold", "sharpness_threshold", "bag_checksum", "bag_looped", "duration_s")


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRow:
    """One stored run.

    Attributes:
        folder: where its record is.
        scenario: the scenario's name; where scenarios with one name differ in their faults, with `faults`.
        suite: the suite that it was flown for; empty for a scenario of one's own.
        manager: the managing system; where those with one name differ in their files, with `sources`.
        seed: of the run.
        model: the segmentation's model, by its name; where runs with one model's name differ in it or in the flight,
            with `setting`.
        setting: a short checksum of the model's networks and thresholds, of the flight, and of how long is measured.
        sources: a short checksum of the files that the managing system is written in; empty if nobody knows.
        faults: a short checksum of the scenario's faults.
        middleware: `sim` or `cyclonedds`.
        digest: of the record's messages.
        metrics: the figures by name; None where there is none to take.
        version: of the package that flew it; empty if nobody knows.
        valid: whether the run counts.
        reason: why it does not; empty if it does.
        failed: whether its managing system failed, so that there is no record and no figure.
        differing: the figures that were computed again and are stored otherwise.
    """

    folder: Path
    scenario: str
    suite: str
    manager: str
    seed: int
    model: str
    setting: str
    middleware: str
    digest: str
    metrics: Mapping[str, float | None]
    sources: str = ""
    faults: str = ""
    version: str = ""
    valid: bool = True
    reason: str = ""
    failed: bool = False
    differing: tuple[str, ...] = ()


def load_results(folder: Path, *, again: bool = False, progress: Progress | None = None) -> list[RunRow]:
    """Return every run below a folder, in order of its path.

    A run that lies there twice, with the same messages, is returned once.

    Args:
        folder: of one run, of a campaign, or of several; hidden folders in it are not looked at, since
            unfinished runs are kept in such.
        again: compute the figures from the recorded messages instead of reading the stored ones.
        progress: called after each run.

    Raises:
        RecordError: there is no such folder, no run in it, one that is damaged, or two with the same messages that
            differ in what is stored beside them.
    """
    if not folder.is_dir():
        raise RecordError(f"There is no folder {folder}; name the one that 'sunset bench --out' wrote.")
    found = [
        file.parent
        for file in sorted(folder.rglob(RUN_FILE))
        if not any(part.startswith(".") for part in file.relative_to(folder).parts)
    ]
    if not found:
        raise RecordError(f"There is no finished run below {folder}: no folder with a {RUN_FILE} in it.")
    rows: dict[tuple[object, ...], RunRow] = {}
    for done, place in enumerate(found, 1):
        row = _read(place, again=again)
        flown = (row.suite, row.manager, row.sources, row.setting, row.middleware, row.version)
        messages = (row.scenario, row.faults, row.seed) if row.failed else (row.digest,)
        _check_copy(row, rows.setdefault((*flown, *messages), row))
        if progress is not None:
            progress(done, len(found))
    told = list(rows.values())
    for name, checksum in (("model", "setting"), ("manager", "sources"), ("scenario", "faults")):
        told = _tell_apart(told, name, checksum)
    return told


def _check_copy(row: RunRow, known: RunRow) -> None:
    """Refuse a run with the messages of another one, unless it is the same.

    Raises:
        RecordError: something else is stored beside them, so that one of the two was edited.
    """
    for name in ("scenario", "faults", "model", "seed", "valid", "metrics"):
        if getattr(row, name) != getattr(known, name):
            raise RecordError(
                f"The runs {known.folder} and {row.folder} have the same messages and must be the same run, but differ "
                f"in their {name}: one of them was edited; remove that one."
            )


def _tell_apart(rows: Sequence[RunRow], name: str, checksum: str) -> list[RunRow]:
    """Return the rows, with the checksum behind each name that stands for several things."""
    found: defaultdict[str, set[str]] = defaultdict(set)
    for row in rows:
        found[getattr(row, name)].add(getattr(row, checksum))
    several = {one for one, checksums in found.items() if len(checksums) > 1}

    def told(row: RunRow) -> RunRow:
        one = getattr(row, name)
        changed: dict[str, Any] = {name: f"{one} {getattr(row, checksum) or 'unknown'}"}
        return replace(row, **changed) if one in several else row

    return [told(row) for row in rows]


def recompute(folder: Path) -> Mapping[str, float | None]:
    """Return a run's figures, computed from its recorded messages.

    Raises:
        RecordError: the record is missing or damaged.
    """
    return MappingProxyType(score(read_timeline(folder)).to_json())


def _read(folder: Path, *, again: bool) -> RunRow:
    """Read one run's `run.json` and check what the table needs of it."""
    run = read_run(folder)
    where = folder / RUN_FILE
    text = {
        key: _checked(run, key, str, where)
        for key in ("scenario", "suite", "manager", "model", "middleware", "digest", "reason")
    }
    failed = run.get("manager_failed") is not None
    metrics = recompute(folder) if again and not failed else _stored(run, where)
    versions = run.get("versions")
    return RunRow(
        folder=folder,
        seed=_checked(run, "seed", int, where),
        metrics=metrics,
        differing=_differing(run.get("metrics"), metrics),
        version=str(versions.get("sunset", "")) if isinstance(versions, dict) else "",
        valid=_checked(run, "valid", bool, where),
        setting=_checksum(
            {
                "model_checksums": _checked(run, "model_checksums", dict, where),
                **{key: run.get(key) for key in _SETTING},
            }
        ),
        sources=str(run.get("manager_checksum", ""))[:_CHECKSUM],
        faults=_checksum({"faults": run.get("faults")}),
        failed=failed,
        **text,
    )


def _checked(run: Mapping[str, Any], key: str, kind: type, where: Path) -> Any:
    value = run.get(key)
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise RecordError(f"The {key} in {where} must be of type {kind.__name__}, got {reprlib.repr(value)}.")
    return value


def _checksum(values: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:_CHECKSUM]


def _stored(run: Mapping[str, Any], where: Path) -> Mapping[str, float | None]:
    stored = _checked(run, "metrics", dict, where)
    return MappingProxyType({name: _figure(stored, name, where) for name in FIGURES})


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


def _differing(stored: object, computed: Mapping[str, float | None]) -> tuple[str, ...]:
    """Return the names of the figures that are stored otherwise than they were computed."""
    known = stored if isinstance(stored, dict) else {}
    return tuple(name for name in FIGURES if name in known and not _same(known[name], computed[name]))


def _same(one: object, other: object) -> bool:
    """Return whether two figures are equal, but for the last digits that another computer may give."""
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-9)
    return one == other
