"""The schemas of `run.json`, a stored run, and of `bench.json`, a campaign's plan.

The version of a schema changes when an older reader would misread a newer file. Newer fields are optional.
"""

import math
import reprlib
from collections.abc import Mapping
from dataclasses import MISSING, astuple, fields
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Final

import msgspec
from msgspec import UNSET, Meta, UnsetType

from sunset.errors import RecordError
from sunset.files.schemas import convert, fields_of, read_json
from sunset.metrics import Evidence, FaultOutcome, RunMetrics
from sunset.metrics.timeline import MOST, Amount, Count, Positive, Share
from sunset.system import REPAIR, TASKS
from sunset.texts.names import PLAN_FILE, RUN_FILE

RECORD_VERSION: Final = 1
"""The version of the layout of records."""
PLAN_VERSION: Final = 1
"""The version of the layout of campaigns' folders."""


TABLE_REFERENCES: Final = (("nofault", "none"), ("degraded", "none"))
"""The suites and managing systems of the first two rows of the paper's table."""
SCORE_REFERENCES: Final = ("none", "oracle")
"""The managing systems with the scores 0 and 1."""

SETTINGS: Final[Mapping[str, float | str]] = MappingProxyType({"task": REPAIR, "thinking_s": 0.0})
"""The settings on which results depend: field of `RunRecord`, `CampaignPlan` and `Settings` → default.

Reports separate runs in which they differ. A record lacks a setting that is 0.
"""

_REMEDY: Final = "run it again, or use --recompute"
_Period = Annotated[float, Meta(gt=0.001, le=MOST)]
_Task = Annotated[str, Meta(pattern=f"^({'|'.join(TASKS)})$")]
_Size = Annotated[list[Annotated[int, Meta(gt=0, le=MOST)]], Meta(min_length=2, max_length=2)]


class StoredFault(msgspec.Struct, frozen=True, omit_defaults=True):
    """A fault of a scenario.

    Attributes:
        value: its strength; True for a fault without strengths.
        at: its onset, in seconds after the injection.
        until: when it heals, likewise.
        profile: the course of its strength.
        after: the fault that it follows, and the delay.
        severity: the severity that the scenario asks for, from 1 to 5.
    """

    name: str
    value: bool | int | float | str | None = None
    at: float = 0.0
    until: float | None = None
    profile: dict[str, str | float] | None = None
    after: dict[str, str | float] | None = None
    severity: int | None = None

    def __str__(self) -> str:
        """Return the fault in words, such as `sync_issue (4 to 6 s)`."""
        begin = f"{self.after['delay']:g} s after {self.after['fault']}" if self.after else f"{self.at:g}"
        if self.until is not None:
            when = f"{begin}, until {self.until:g} s" if self.after else f"{begin} to {self.until:g} s"
        else:
            when = begin if self.after else (f"from {begin} s on" if self.at else "")
        kind = str((self.profile or {}).get("kind", ""))
        course = ", ".join(filter(None, (when, kind)))
        return f"{self.name} ({course})" if course else self.name


class RunRecord(msgspec.Struct, frozen=True, kw_only=True):
    """The content of `run.json`: the run, its surroundings, and its results.

    Attributes:
        suite: empty for a scenario outside of suites; `suite_size` scenarios, 0 if unknown.
        alike: the degradations by which runs are clustered; without any, the failures.
        manager_spec: the name by which the managing system was loaded, unless it is `manager`.
        manager_versions: the distributions that the managing system imported, by name.
        manager_failed: how the managing system failed; with `is_empty`, why there are neither messages nor figures.
        missing_walls: the walls that a user's managing system lacked.
        flight_conditions: for rendering the flight, unless it is the default flight.
        flight_warning: a sentence for readers of the figures.
        bag_size: height and width of the recorded images [pixels]; of the networks' input, `frame_size`.
        bag_dropped: how many images lack a partner.
        compute_s: the modelled compute time of each node [s], and `jitter`, its relative half-width.
        latency_s: how long a message is on its way [s].
        speed: seconds of `/clock` in a second; live.
        viewers: nodes that only watch, and could read the truth.
        expected_frames: how many frames are measured if none is lost.
        thinking_s: the experiment's time for every decision of the managing system [s].
        entropy_threshold: F4 holds above it, and F5 below `sharpness_threshold`.
        versions: of everything that the record's bytes may depend on.
        start_ns: the time of the injection, in nanoseconds of the experiment's clock.
        metrics: the figures by name; `stored_figures` checks them.
        models_asked: the language models that the managing system named in its costs.
        frames_lost: how many frames were lost before the injection; live.
        valid: whether the run counts; if not, `reason` says why.
        digest: SHA-256 of the messages; `RecordWriter` sets it.
    """

    scenario: str
    faults: list[StoredFault]
    suite: str
    suite_size: Count | UnsetType = UNSET
    alike: str | UnsetType = UNSET
    manager: str
    manager_spec: str | UnsetType = UNSET
    manager_checksum: str = ""
    manager_versions: dict[str, str] | UnsetType = UNSET
    manager_failed: str | None = None
    missing_walls: tuple[str, ...] | UnsetType = UNSET
    evidence: Evidence = "symptoms"
    seed: int
    model: str
    model_checksums: dict[str, str]
    device: str = "cpu"
    middleware: str
    flight: str = ""
    flight_conditions: dict[str, int | float | str] | UnsetType = UNSET
    flight_warning: str | UnsetType = UNSET
    bag_frames: Count | UnsetType = UNSET
    bag_checksum: str = ""
    bag_looped: bool = False
    bag_size: _Size | UnsetType = UNSET
    bag_dropped: Count | UnsetType = UNSET
    frame_size: _Size | UnsetType = UNSET
    compute_s: dict[str, Amount] | UnsetType = UNSET
    jitter: Share | UnsetType = UNSET
    latency_s: Amount | UnsetType = UNSET
    speed: Positive | UnsetType = UNSET
    viewers: list[str] | UnsetType = UNSET
    warm_up_s: Amount | UnsetType = UNSET
    duration_s: Positive
    period_s: _Period
    expected_frames: Annotated[int, Meta(gt=0, le=MOST)]
    task: _Task = REPAIR
    thinking_s: Positive | UnsetType = UNSET
    entropy_threshold: Positive
    sharpness_threshold: Positive
    extensions: dict[str, str] | UnsetType = UNSET
    versions: dict[str, str] = {}
    start_ns: int | UnsetType = UNSET
    metrics: Mapping[str, object]
    fault_outcomes: tuple[FaultOutcome, ...] = ()
    models_asked: tuple[str, ...] | UnsetType = UNSET
    computer_kept_up: bool | UnsetType = UNSET
    frames_lost: Count | UnsetType = UNSET
    valid: bool
    reason: str
    digest: str = ""
    record_version: int = RECORD_VERSION

    @property
    def is_empty(self) -> bool:
        """Whether the run failed as a whole, and left neither messages nor figures."""
        return self.manager_failed is not None and self.start_ns is UNSET

    @property
    def settings(self) -> dict[str, float | str]:
        """The values of `SETTINGS`."""
        return {name: getattr(self, name) or default for name, default in SETTINGS.items()}

    @property
    def thresholds(self) -> dict[str, float]:
        """The thresholds of the model's signals, by name."""
        return {"entropy_threshold": self.entropy_threshold, "sharpness_threshold": self.sharpness_threshold}


_OPTIONAL: Final = {field.name for field in fields(RunMetrics) if field.default is not MISSING}
"""Figures that older records lack."""
_Figures = msgspec.defstruct(
    "_Figures",
    [
        (name, fields_of(RunMetrics)[name] | None, *((None,) if name in _OPTIONAL else ()))
        for name in RunMetrics.names()
    ],
    kw_only=True,
)


def read_run(folder: Path) -> RunRecord:
    """Return the content of a record's `run.json`.

    Raises:
        RecordError: the record is incomplete, damaged, or of another version.
    """
    if folder.is_file():
        raise RecordError(f"A record is a folder, got the file {folder}: name the folder that it is in.")
    file = folder / RUN_FILE
    content = read_json(file, "The file", RecordError, missing=_missing_text(folder))
    _check_version(f"The record {folder}", content, "record_version", RECORD_VERSION, "run it again")
    return convert(content, RunRecord, str(file), RecordError, remedy="restore the file, or run it again")


def _missing_text(folder: Path) -> str:
    reason = f"{RUN_FILE} is missing"
    if not folder.exists():
        reason = "there is no such folder"
    elif (folder / PLAN_FILE).is_file():
        reason = "it is a campaign; name the folder of one of its runs, which are in its folder runs"
    return f"{folder} is not a complete record: {reason}."


def stored_figures(run: RunRecord, file: Path) -> dict[str, float | None]:
    """Return the figures in a run's `run.json`, by name.

    Raises:
        RecordError: a figure is missing or out of range.
    """
    figures = convert(run.metrics, _Figures, str(file), RecordError, remedy=_REMEDY, path=("metrics",))
    return {name: getattr(figures, name) for name in RunMetrics.names()}


def differences(run: RunRecord, computed: RunMetrics) -> tuple[str, ...]:
    """Return the names of the figures in a run's `run.json` that differ from the computed figures."""
    stored = {**run.metrics, "fault_outcomes": list(map(astuple, run.fault_outcomes))}
    now = {**computed.to_json(), "fault_outcomes": list(map(astuple, computed.outcomes))}
    return tuple(name for name, value in now.items() if name in stored and not _same(stored[name], value))


def _same(stored: object, computed: object) -> bool:
    """Return whether two figures are equal, but for the last digits, which depend on the computer."""
    if isinstance(stored, float) and isinstance(computed, float):
        return math.isclose(stored, computed, rel_tol=1e-9, abs_tol=1e-9)
    if isinstance(stored, list | tuple) and isinstance(computed, list | tuple):
        return len(stored) == len(computed) and all(map(_same, stored, computed))
    return stored == computed


class StoredFlight(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The facts about a flight on which a campaign's results depend; a bag has no `conditions` for rendering."""

    bag_checksum: str
    conditions: dict[str, int | float | str] | UnsetType = UNSET
    entropy_threshold: Positive
    sharpness_threshold: Positive
    warning: str = ""


class CampaignPlan(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The content of `bench.json`: everything on which a campaign's results may depend, by name and by content.

    Attributes:
        suite: the suite's name or folder; of it, `scenarios` are run, or all.
        split: the hash of the split in the suite's folder; empty if there is none.
        references: whether the paper's two reference rows are run, too.
        score: whether the managing systems of `SCORE_REFERENCES` are run, too.
        manager_checksums: of the managing systems' files, by name.
        seed: of the first repetition.
        runs: the number of all runs.
        model_checksum: of the model's card.
        bag: the bag's path; None for the default flight.
        flights: the flights of every scenario, as they were named; if empty, each scenario has its own.
        flight_facts: of each flight but the default flight, by name.
        versions: of everything that a record's bytes may depend on.
    """

    plan_version: int
    suite: str
    scenarios: tuple[str, ...] = ()
    scenarios_checksum: str
    split: str = ""
    references: bool = True
    score: bool = False
    managers: tuple[str, ...]
    manager_checksums: dict[str, str]
    repetitions: int
    seed: int
    runs: int
    model: str
    model_checksum: str
    bag: str | None
    bag_checksum: str
    flights: tuple[str, ...] = ()
    flight_facts: dict[str, StoredFlight] = {}
    loop: bool = False
    device: str
    timing: dict[str, float]
    middleware: str = "sim"
    speed: float = 1.0
    task: _Task = REPAIR
    thinking_s: float = 0.0
    versions: dict[str, str]
    extensions: dict[str, str] = {}

    def is_of_suite(self, suite: str, manager: str) -> bool:
        """Return whether a run with these names is of the suite, and not of the paper's reference rows."""
        return suite == self.suite or not self.references or (suite, manager) not in TABLE_REFERENCES


def read_plan(folder: Path) -> CampaignPlan:
    """Return the plan of a campaign, the content of `bench.json` in its folder.

    Raises:
        RecordError: the file is missing, damaged, or of another version.
    """
    file = folder / PLAN_FILE
    content = read_json(file, "The campaign's plan", RecordError)
    _check_version(f"The campaign in {folder}", content, "plan_version", PLAN_VERSION, "name a new folder")
    return convert(content, CampaignPlan, str(file), RecordError, remedy="restore it, or name a new folder")


def count_runs(out: Path) -> tuple[int, int] | None:
    """Return the numbers of finished and of planned runs of a folder's campaigns; None if it holds no campaign.

    Campaigns in subfolders count, too. Shards of the same campaign, in folders of their own, are counted together.

    Raises:
        RecordError: a campaign's plan is damaged, or of another version.
    """
    campaigns: dict[bytes, tuple[int, set[Path]]] = {}
    for file in sorted([*out.glob(PLAN_FILE), *out.glob(f"*/{PLAN_FILE}")]):
        planned = read_plan(file.parent).runs
        runs = campaigns.setdefault(file.read_bytes(), (planned, set()))[1]
        runs.update(run.relative_to(file.parent) for run in file.parent.glob(f"runs/*/*/*/seed-*/{RUN_FILE}"))
    if not campaigns:
        return None
    return sum(len(runs) for _, runs in campaigns.values()), sum(planned for planned, _ in campaigns.values())


def _check_version(name: str, content: object, key: str, expected: int, remedy: str) -> None:
    """Raise if an object is of another version."""
    version = content.get(key) if isinstance(content, dict) else expected
    if version != expected:
        raise RecordError(
            f"{name} is of version {reprlib.repr(version)}, expected {expected}; read it with the SUNSET that wrote "
            f"it, or {remedy}."
        )
