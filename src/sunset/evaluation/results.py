"""Stored runs: found, read, checked, and computed again where that is asked for."""

import hashlib
import json
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from msgspec import UNSET, to_builtins

from sunset.errors import RecordError
from sunset.evaluation.intervals import Cluster
from sunset.metrics import Evidence, FaultOutcome, RunMetrics, score
from sunset.processes.workers import Progress
from sunset.recording import (
    PLAN_FILE,
    RUN_FILE,
    differences,
    read_run,
    read_timeline,
    stored_figures,
)
from sunset.system import DURATION_S, REPAIR, degradations_of, suite_size

FIGURES: Final = RunMetrics.names()
"""The names of a run's figures, as `RunMetrics` has them."""

_CHECKSUM: Final = 8
"""Digits of a short checksum."""


@dataclass(frozen=True, slots=True, order=True)
class Flight:
    """What a run is measured on.

    Attributes:
        duration_s: how long is measured [s].
        looped: whether the bag begins anew where it ends.
        bag: the bag's checksum; empty if it is not known.
        name: what the flight is called; empty if it is not known.
    """

    duration_s: float
    looped: bool = False
    bag: str = ""
    name: str = ""

    @property
    def short_bag(self) -> str:
        """The first digits of the bag's checksum."""
        return self.bag[:_CHECKSUM] or "unknown"

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        return {
            "duration_s": self.duration_s,
            "bag_looped": self.looped,
            "flight": self.name,
            "bag_checksum": self.bag,
        }

    def label(self, *, bag: bool = False) -> str:
        """Return what a name must say of it: what is unlike the paper's and, if that is asked for, the bag.

        >>> Flight(20.0, bag="3c").label(), Flight(4.0, looped=True, bag="3c").label(bag=True)
        ('', ' [4 s] [looped] [flight 3c]')
        """
        return (
            ("" if self.duration_s == DURATION_S else f" [{self.duration_s:g} s]")
            + (" [looped]" if self.looped else "")
            + (f" [flight {self.name or self.short_bag}]" if bag else "")
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRow:
    """One stored run.

    Attributes:
        scenario: where scenarios with one name differ in their faults, with `faults`.
        suite: empty for a scenario of one's own.
        manager: where managing systems with one name differ in their files, with `sources`.
        model: where models with one name differ, with `setting`.
        setting: a short checksum of the model's networks, and of its thresholds on the flight.
        sources: a short checksum of the files that the managing system is written in; empty if it is unknown.
        faults: a short checksum of the scenario's faults.
        alike: the degradations by which runs are clustered; the outages, if there are none.
        suite_size: how many scenarios its suite has; 0 if that is not known.
        digest: of the record's messages.
        metrics: the figures by name; None where there is none to take.
        outcomes: what became of its faults.
        frames: how many the measured time has.
        evidence: what its managing system looked at.
        version: of the package that it was run with, and of its extensions; empty if it is unknown.
        others: the versions of other packages, those that its managing system imported included, by name.
        valid: whether the run counts.
        reason: why it does not; empty if it does.
        task: of its managing system, `repair` or `diagnose`.
        thinking_s: what every decision of its managing system took of the experiment's time [s].
        failed: how its managing system failed, in a sentence; empty if it did not.
        missing_walls: which walls around a user's own managing system were missing.
        warning: what a reader must know of the flight with this model, in a sentence; empty if nothing.
        is_empty: whether it failed as a whole, so that there is no record and no figure.
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
    flight: Flight
    outcomes: tuple[FaultOutcome, ...] = ()
    frames: int = 200
    evidence: Evidence = "symptoms"
    sources: str = ""
    faults: str = ""
    alike: str = ""
    suite_size: int = 0
    task: str = REPAIR
    thinking_s: float = 0.0
    version: str = ""
    others: Mapping[str, str] = field(default_factory=dict)
    valid: bool = True
    reason: str = ""
    failed: str = ""
    missing_walls: tuple[str, ...] = ()
    warning: str = ""
    is_empty: bool = False
    differing: tuple[str, ...] = ()

    @property
    def cluster(self) -> Cluster:
        """What the run has in common with others."""
        return Cluster(self.alike or self.scenario, self.flight, self.seed)

    @property
    def conditions(self) -> tuple[str, Flight, str, float, str, str]:
        """What the runs of a row have in common: model, flight, task, thinking time, middleware and version."""
        return (self.model, self.flight, self.task, self.thinking_s, self.middleware, self.version)

    @property
    def experiment(self) -> tuple[object, ...]:
        """What makes runs of two managing systems a pair.

        The same scenario, model, flight, middleware, task, thinking time and version; and the seed, which is the last.
        """
        return (self.suite, self.scenario, self.setting, *self.conditions, self.seed)


def load_results(folder: Path, *, again: bool = False, progress: Progress | None = None) -> list[RunRow]:
    """Return every run below a folder, in order of its path in its campaign.

    So the shards of a campaign give, from folders of their own, the rows of the whole in the same order. A run that
    lies there twice, with the same messages, is returned once.

    Args:
        folder: of one run, of a campaign, or of several; hidden folders in it are not looked at, since
            unfinished runs are kept in such.
        again: compute the figures from the recorded messages instead of reading the stored ones.
        progress: called after each run.

    Raises:
        RecordError: there is no such folder, no run in it, one that is damaged, or two with the same messages that
            differ in what is stored beside them.
    """
    if folder.is_file():
        raise RecordError(
            f"{folder} is a file, not a folder of runs: check a bundle with 'sunset verify', or unpack it and name "
            "that folder."
        )
    if not folder.is_dir():
        raise RecordError(f"There is no folder {folder}; name the one that 'sunset bench --out' wrote.")
    found = [
        file.parent
        for file in sorted(folder.rglob(RUN_FILE), key=_place)
        if not any(part.startswith(".") for part in file.relative_to(folder).parts)
    ]
    if not found:
        raise RecordError(f"There is no finished run below {folder}: no folder with a {RUN_FILE} in it.")
    rows: dict[tuple[object, ...], RunRow] = {}
    for done, place in enumerate(found, 1):
        try:
            row = _read(place, again=again)
        except RecordError as error:
            if any((parent / PLAN_FILE).is_file() for parent in place.parents):
                raise RecordError(
                    f"{error} Remove its folder, and the campaign's command runs it again."
                ) from error
            raise
        setup = (row.suite, row.manager, row.sources, row.setting, row.flight, row.middleware, row.version)
        messages = (row.scenario, row.faults, row.seed) if row.is_empty else (row.digest,)
        _check_copy(row, rows.setdefault((*setup, *messages), row))
        if progress is not None:
            progress(done, len(found))
    runs = list(rows.values())
    for name, checksum in (("model", "setting"), ("manager", "sources"), ("scenario", "faults")):
        runs = _tell_apart(runs, name, checksum)
    return runs


def _place(file: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return where a run stands among others: its path from its campaign's folder on, and its whole path."""
    parts = file.parts
    start = len(parts) - parts[::-1].index("runs") if "runs" in parts else 0
    return parts[start:], parts


def _check_copy(row: RunRow, known: RunRow) -> None:
    """Refuse a run with the messages of another one, unless it is the same.

    Raises:
        RecordError: something else is stored beside them, so that one of the two was edited.
    """
    for name in ("scenario", "faults", "model", "seed", "valid", "metrics"):
        values = getattr(row, name), getattr(known, name)
        if values[0] != values[1] and None not in values:
            raise RecordError(
                f"The runs {known.folder} and {row.folder} have the same messages and must be the same run, but differ "
                f"in their {name}: one of them was edited; remove that one."
            )


def _tell_apart(rows: Sequence[RunRow], name: str, checksum: str) -> list[RunRow]:
    """Return the rows, with the checksum behind each name that stands for several things.

    Thresholds of a model belong to the flight, so that a model is one thing if it is one on each flight.
    """
    found: defaultdict[tuple[str, Flight | None], set[str]] = defaultdict(set)
    for row in rows:
        found[getattr(row, name), row.flight if name == "model" else None].add(getattr(row, checksum))
    several = {key[0] for key, checksums in found.items() if len(checksums) > 1}
    rows = list(rows)
    for place, row in enumerate(rows):
        if getattr(row, name) in several:
            changed: dict[str, Any] = {name: f"{getattr(row, name)} {getattr(row, checksum) or 'unknown'}"}
            rows[place] = replace(row, **changed)
    return rows


def _read(folder: Path, *, again: bool) -> RunRow:
    """Read one run's `run.json` and check what the table needs of it."""
    run = read_run(folder)
    computed = score(read_timeline(folder)) if again and not run.is_empty else None
    extensions = " and ".join(
        f"{name} {sha[:_CHECKSUM]}" for name, sha in sorted((run.extensions or {}).items())
    )
    return RunRow(
        folder=folder,
        scenario=run.scenario,
        suite=run.suite,
        manager=run.manager,
        seed=run.seed,
        model=run.model,
        middleware=run.middleware,
        digest=run.digest,
        valid=run.valid,
        reason=run.reason,
        metrics=computed.to_json() if computed else stored_figures(run, folder / RUN_FILE),
        outcomes=computed.outcomes if computed else run.fault_outcomes,
        frames=run.expected_frames,
        evidence=run.evidence,
        differing=differences(run, computed) if computed else (),
        version=run.versions.get("sunset", "") + (f" with {extensions}" if extensions else ""),
        others={name: value for name, value in run.versions.items() if name != "sunset"}
        | (run.manager_versions or {}),
        setting=_checksum({"model_checksums": run.model_checksums, **run.thresholds}),
        flight=Flight(run.duration_s, run.bag_looped, run.bag_checksum, run.flight),
        sources=run.manager_checksum[:_CHECKSUM],
        task=run.task,
        thinking_s=run.thinking_s or 0.0,
        faults=_checksum({"faults": to_builtins(run.faults)}),
        alike=degradations_of(fault.name for fault in run.faults) if run.alike is UNSET else run.alike,
        suite_size=suite_size(run.suite, run.scenario) if run.suite_size is UNSET else run.suite_size,
        failed=run.manager_failed or "",
        missing_walls=run.missing_walls or (),
        warning=run.flight_warning or "",
        is_empty=run.is_empty,
    )


def _checksum(values: Mapping[str, object]) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:_CHECKSUM]
