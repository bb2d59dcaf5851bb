"""Stored runs: read, checked and, on request, computed again."""

import hashlib
import json
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from msgspec import to_builtins

from sunset.errors import RecordError
from sunset.evaluation.intervals import Cluster
from sunset.metrics import Evidence, FaultOutcome, RunMetrics, score
from sunset.processes.workers import Progress
from sunset.recording import SETTINGS, differences, read_run, read_timeline, stored_figures
from sunset.system import DURATION_S
from sunset.texts.names import PLAN_FILE, RUN_FILE

FIGURES: Final = RunMetrics.names()
"""The names of a run's figures, as in `RunMetrics`."""

_CHECKSUM: Final = 8  # digits of a short checksum
_SAME: Final = (
    *("scenario", "suite", "manager", "seed", "model", "middleware", "digest", "valid", "reason", "evidence"),
    *("settings", "is_empty"),
)
"""The fields of a row that `run.json` has, too."""


@dataclass(frozen=True, slots=True, order=True)
class Flight:
    """The flight of a run."""

    duration_s: float  # the measured time
    looped: bool = False  # whether the bag is repeated after its end
    bag: str = ""  # the bag's checksum; empty if it is unknown
    name: str = ""  # empty if it is unknown

    @property
    def short_bag(self) -> str:
        """The first digits of the bag's checksum."""
        return self.bag[:_CHECKSUM] or "unknown"

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        flight = {"flight": self.name, "bag_checksum": self.bag}
        return {"duration_s": self.duration_s, "bag_looped": self.looped, **flight}

    def label(self, *, bag: bool = False) -> str:
        """Return the suffix for a name: differences from the paper's flight and, if `bag`, the flight.

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
    """A stored run."""

    folder: Path
    scenario: str  # with `faults` where scenarios with this name differ
    suite: str  # empty for a user's own scenario
    manager: str  # with `sources` where managing systems with this name differ
    seed: int
    model: str  # with `setting` where models with this name differ
    setting: str  # a short checksum of the model's networks, and of its thresholds on the flight
    middleware: str
    digest: str
    metrics: Mapping[str, float | None]  # the figures by name; None where a figure is not applicable
    flight: Flight
    outcomes: tuple[FaultOutcome, ...] = ()
    frames: int = 200  # the number of frames of the measured time
    evidence: Evidence = "symptoms"
    sources: str = ""  # a short checksum of the managing system's files; empty if it is unknown
    faults: str = ""  # a short checksum of the scenario's faults
    alike: str = ""  # the degradations by which runs are clustered, else the outages
    suite_size: int = 0  # the number of scenarios in its suite; 0 if it is unknown
    settings: Mapping[str, float | str] = field(default_factory=lambda: SETTINGS)  # on which results depend
    version: str = ""  # of SUNSET and of extensions; empty if it is unknown
    others: Mapping[str, str] = field(default_factory=dict)  # package → version, as in `run.json`
    valid: bool = True
    reason: str = ""  # why it is invalid
    failed: str = ""  # how its managing system failed, in a sentence; empty if it did not
    missing_walls: tuple[str, ...] = ()  # around a user's own managing system
    warning: str = ""  # a sentence about the flight with this model
    is_empty: bool = False  # whether the whole run failed, so that record and figures are missing
    models_asked: tuple[str, ...] = ()  # the language models that its managing system named in its costs
    differing: tuple[str, ...] = ()  # the figures whose stored value differs from the computed value

    @property
    def cluster(self) -> Cluster:
        """Its levels for confidence intervals."""
        return Cluster(self.alike or self.scenario, self.flight, self.seed)

    @property
    def task(self) -> str:
        """The task of its managing system, `repair` or `diagnose`."""
        return str(self.settings["task"])

    @property
    def amounts(self) -> dict[str, str]:
        """The settings that are numbers, in words, by name, such as `thinking 0.05 s`."""
        numbers = {name: value for name, value in self.settings.items() if not isinstance(value, str)}
        return {
            name: f"{name.removesuffix('_s')} {value:g}{' s' if name.endswith('_s') else ''}"
            for name, value in numbers.items()
        }

    @property
    def conditions(self) -> tuple[object, ...]:
        """The common properties of the runs of a row."""
        return (self.model, self.flight, *self.settings.values(), self.middleware, self.version)

    @property
    def experiment(self) -> tuple[object, ...]:
        """The common properties of the runs of a pair: all but the managing system. The last is the seed."""
        return (self.suite, self.scenario, self.setting, *self.conditions, self.seed)


def load_results(folder: Path, *, again: bool = False, progress: Progress | None = None) -> list[RunRow]:
    """Return every run below a folder, in order of its path in its campaign.

    So the shards of a campaign in different folders give the same order as the whole. Two copies of a run are returned
    once. Hidden folders have unfinished runs, and are skipped.

    Args:
        folder: of a run, of a campaign, or of several campaigns.
        again: compute the figures from the recorded messages instead of reading them.
        progress: called with (runs that are read, runs in all).

    Raises:
        RecordError: the folder is missing or without runs, or a run is damaged.
    """
    folders = _run_folders(folder)
    rows: dict[tuple[object, ...], RunRow] = {}
    for done, place in enumerate(folders, 1):
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
        rows.setdefault((*setup, *messages), row)
        if progress is not None:
            progress(done, len(folders))
    runs = list(rows.values())
    for name, checksum in (("model", "setting"), ("manager", "sources"), ("scenario", "faults")):
        runs = _with_checksums(runs, name, checksum)
    return runs


def _run_folders(folder: Path) -> list[Path]:
    if folder.is_file():
        raise RecordError(
            f"{folder} is a file, not a folder of runs: check a bundle with 'sunset verify', or unpack it and name "
            "that folder."
        )
    if not folder.is_dir():
        raise RecordError(f"There is no folder {folder}; name the one that 'sunset bench --out' wrote.")
    folders = [
        file.parent
        for file in sorted(folder.rglob(RUN_FILE), key=_place)
        if not any(part.startswith(".") for part in file.relative_to(folder).parts)
    ]
    if not folders:
        raise RecordError(f"There is no finished run below {folder}: no folder with a {RUN_FILE} in it.")
    return folders


def _place(file: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the key of runs' order: the path in the campaign's folder, and the whole path."""
    parts = file.parts
    start = len(parts) - parts[::-1].index("runs") if "runs" in parts else 0
    return parts[start:], parts


def _with_checksums(rows: Sequence[RunRow], name: str, checksum: str) -> list[RunRow]:
    """Return the rows, with the checksum behind ambiguous names; models have different thresholds on each flight."""
    known: defaultdict[tuple[str, Flight | None], set[str]] = defaultdict(set)
    for row in rows:
        known[getattr(row, name), row.flight if name == "model" else None].add(getattr(row, checksum))
    several = {key[0] for key, checksums in known.items() if len(checksums) > 1}
    rows = list(rows)
    for place, row in enumerate(rows):
        if getattr(row, name) in several:
            changed: dict[str, Any] = {name: f"{getattr(row, name)} {getattr(row, checksum) or 'unknown'}"}
            rows[place] = replace(row, **changed)
    return rows


def _read(folder: Path, *, again: bool) -> RunRow:
    run = read_run(folder)
    computed = score(read_timeline(folder)) if again and not run.is_empty else None
    extended = [f"{name} {sha[:_CHECKSUM]}" for name, sha in sorted((run.extensions or {}).items())]
    others = {name: version for name, version in run.versions.items() if name != "sunset"}
    return RunRow(
        **{name: getattr(run, name) for name in _SAME},
        folder=folder,
        metrics=computed.to_json() if computed else stored_figures(run, folder / RUN_FILE),
        outcomes=computed.outcomes if computed else run.fault_outcomes,
        models_asked=computed.models_asked if computed else run.models_asked or (),
        frames=run.expected_frames,
        differing=differences(run, computed) if computed else (),
        version=run.versions.get("sunset", "") + (f" with {' and '.join(extended)}" if extended else ""),
        others=others | (run.manager_versions or {}),
        setting=_checksum({"model_checksums": run.model_checksums, **run.thresholds}),
        flight=Flight(run.duration_s, run.bag_looped, run.bag_checksum, run.flight),
        sources=run.manager_checksum[:_CHECKSUM],
        faults=_checksum({"faults": to_builtins(run.faults)}),
        alike=run.alike or "",
        suite_size=run.suite_size or 0,
        failed=run.manager_failed or "",
        missing_walls=run.missing_walls or (),
        warning=run.flight_warning or "",
    )


def _checksum(values: Mapping[str, object]) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:_CHECKSUM]
