"""Stored runs: found, read, checked, and computed again where that is asked for."""

import hashlib
import json
import math
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
        valid: whether the run counts.
        reason: why it does not; empty if it does.
        failed: whether its managing system failed, so that there is no record and no figure.
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
    valid: bool = True
    reason: str = ""
    failed: bool = False


def load_results(folder: Path, *, again: bool = False, progress: Progress | None = None) -> list[RunRow]:
    """Return every run below a folder, in order of its path.

    A run that lies there twice, with the same specification and the same messages, is returned once.

    Args:
        folder: of one run, of a campaign, or of several; hidden folders in it are not looked at, since
            unfinished runs are kept in such.
        again: compute the figures from the recorded messages instead of reading the stored ones.
        progress: called after each run.

    Raises:
        RecordError: there is no such folder, no run in it, or one that is damaged.
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
        what = (row.suite, row.scenario, row.faults, row.manager, row.sources, row.setting)
        rows.setdefault((*what, row.seed, row.middleware, row.digest), row)
        if progress is not None:
            progress(done, len(found))
    told = list(rows.values())
    for name, checksum in (("model", "setting"), ("manager", "sources"), ("scenario", "faults")):
        told = _tell_apart(told, name, checksum)
    return told


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
    return RunRow(
        folder=folder,
        seed=_checked(run, "seed", int, where),
        metrics=recompute(folder) if again and not failed else _stored(run, where),
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
    if not isinstance(value, kind):
        raise RecordError(f"The {key} in {where} must be of type {kind.__name__}, got {value!r}.")
    return value


def _checksum(values: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:_CHECKSUM]


def _stored(run: Mapping[str, Any], where: Path) -> Mapping[str, float | None]:
    stored = _checked(run, "metrics", dict, where)
    return MappingProxyType({name: _figure(stored, name, where) for name in FIGURES})


def _figure(stored: Mapping[str, Any], name: str, where: Path) -> float | None:
    """Return one stored figure: a finite number, or None."""
    if name not in stored:
        raise RecordError(f"The metrics in {where} lack {name}; run it again, or use --recompute.")
    value = stored[name]
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise RecordError(f"The metric {name} in {where} must be a finite number or null, got {value!r}.")
    return value
