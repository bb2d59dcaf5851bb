"""What `run.json` and `bench.json` hold: the schema of a stored run and of a campaign's plan.

The version of a schema changes when an older reader would misread a newer file. What was added since is optional.
"""

import dataclasses
import math
import reprlib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Final

import msgspec
from msgspec import UNSET, Meta, UnsetType

from sunset.errors import RecordError
from sunset.metrics import Evidence, FaultOutcome, RunMetrics
from sunset.metrics.limits import MOST, Amount, Count, Positive, Share
from sunset.schemas import convert, fields_of, read_json
from sunset.system import REPAIR, TASKS

RECORD_VERSION: Final = 1
"""The version of the layout of records."""
PLAN_VERSION: Final = 1
"""The version of the layout of campaigns' folders."""

RUN_FILE: Final = "run.json"
"""The file of a run's folder that is there only when the run is complete."""
PLAN_FILE: Final = "bench.json"
"""The file of a campaign's folder that says what is run in it."""

TABLE_REFERENCES: Final = (("nofault", "none"), ("degraded", "none"))
"""The suites and managing systems of the first two rows of the paper's table."""
SCORE_REFERENCES: Final = ("none", "oracle")
"""The managing systems that scores are measured between: 0 is the first, 1 the second."""

_REMEDY: Final = "run it again, or use --recompute"
_Period = Annotated[float, Meta(gt=0.001, le=MOST)]
_Task = Annotated[str, Meta(pattern=f"^({'|'.join(TASKS)})$")]
_Size = Annotated[list[Annotated[int, Meta(gt=0, le=MOST)]], Meta(min_length=2, max_length=2)]


class StoredFault(msgspec.Struct, frozen=True, omit_defaults=True):
    """A fault of a scenario.

    Attributes:
        name: its name.
        value: its strength; True where it has none.
        at: seconds after the measured time began at which it was to come.
        until: likewise, at which it was to heal.
        profile: how its strength went on.
        after: which fault it was to follow, and how much later.
        severity: what the strength was to cost, from 1 to 5.
    """

    name: str
    value: bool | int | float | str | None = None
    at: float = 0.0
    until: float | None = None
    profile: dict[str, str | float] | None = None
    after: dict[str, str | float] | None = None
    severity: int | None = None

    def __str__(self) -> str:
        """Return it in words, such as `sync_issue (4 to 6 s)`."""
        begin = f"{self.after['delay']:g} s after {self.after['fault']}" if self.after else f"{self.at:g}"
        if self.until is not None:
            when = f"{begin}, until {self.until:g} s" if self.after else f"{begin} to {self.until:g} s"
        else:
            when = begin if self.after else (f"from {begin} s on" if self.at else "")
        kind = str((self.profile or {}).get("kind", ""))
        said = ", ".join(filter(None, (when, kind)))
        return f"{self.name} ({said})" if said else self.name


class RunRecord(msgspec.Struct, frozen=True, kw_only=True):
    """What `run.json` says: what was run, with what, and what came out.

    Attributes:
        suite: empty for a scenario of one's own.
        suite_size: how many scenarios it has, or the campaign's folder of scenarios; 0 if that is not known.
        alike: the degradations by which runs are clustered; the failures, if there are none.
        manager_spec: what the managing system was loaded as, where that is not its name.
        manager_checksum: of the files that it is written in; empty if it has none.
        manager_versions: of the distributions that it imported when it was loaded, by name; where there are any.
        manager_failed: how the managing system failed, after which the run went on without one; or why a run has
            neither messages nor figures: `is_empty`. None if neither is so.
        missing_walls: which walls around a user's own managing system were missing.
        evidence: what the managing system looked at.
        flight: what the flight is called.
        flight_conditions: under which it was rendered, where they are not those of the default flight.
        flight_warning: what a reader must know of it, in one sentence; where there is something.
        bag_size: height and width of the recorded images, in pixels.
        bag_dropped: how many images have no partner.
        frame_size: height and width of what the networks take, in pixels.
        compute_s: the modelled compute time of each node [s]; in the simulation.
        jitter: the relative half-width of their jitter; in the simulation.
        latency_s: how long a message is on its way [s]; in the simulation.
        speed: seconds of `/clock` in a second; live.
        viewers: nodes that were said to only watch, and could read the truth; where there were any.
        warm_up_s: healthy operation before the injection [s].
        duration_s: how long is measured [s].
        period_s: the time between two frames [s].
        expected_frames: how many frames are measured if none is lost.
        task: of the managing system: `repair`, or `diagnose`, in which adaptations are refused.
        thinking_s: what every decision of the managing system took of the experiment's time [s]; where it did.
        entropy_threshold: F4 holds above it.
        sharpness_threshold: F5 holds below it.
        extensions: of the system's description: name → checksum; where there are any.
        versions: of everything that the record's bytes may depend on.
        start_ns: when faults were injected, in nanoseconds of the experiment's clock.
        metrics: the figures by name; `stored_figures` checks them.
        fault_outcomes: what became of each fault.
        computer_kept_up: whether the computer was fast enough; of a live run.
        frames_lost: how many frames were lost before anything was wrong; of a live run, in which one, or 2 %, may be.
        valid: whether the run counts.
        reason: why it does not; empty if it does.
        digest: SHA-256 of the messages; the record's writer sets it.
        record_version: of this schema.
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
    computer_kept_up: bool | UnsetType = UNSET
    frames_lost: Count | UnsetType = UNSET
    valid: bool
    reason: str
    digest: str = ""
    record_version: int = RECORD_VERSION

    @property
    def is_empty(self) -> bool:
        """Whether it stands in the place of a run that failed as a whole, with neither messages nor figures."""
        return self.manager_failed is not None and self.start_ns is UNSET

    @property
    def thresholds(self) -> dict[str, float]:
        """The thresholds of the model's signals, by name."""
        return {"entropy_threshold": self.entropy_threshold, "sharpness_threshold": self.sharpness_threshold}


_Figures = msgspec.defstruct(
    "_Figures", [(name, fields_of(RunMetrics)[name] | None) for name in RunMetrics.names()]
)


def read_run(folder: Path) -> RunRecord:
    """Return what `run.json` of a record says.

    Raises:
        RecordError: the folder is not a complete record, or `run.json` is damaged, does not fit the schema, or is of
            another version.
    """
    file = Path(folder) / RUN_FILE
    content = read_json(file, "The file", RecordError, missing=_missing_text(Path(folder)))
    _check_version(f"The record {folder}", content, "record_version", RECORD_VERSION, "run it again")
    return convert(content, RunRecord, str(file), RecordError, remedy="restore the file, or run it again")


def _missing_text(folder: Path) -> str:
    """Return why a folder without `run.json` is not a record, and what was perhaps meant."""
    reason = f"{RUN_FILE} is missing"
    if not folder.exists():
        reason = "there is no such folder"
    elif (folder / PLAN_FILE).is_file():
        reason = "it is a campaign; name the folder of one of its runs, which are in its folder runs"
    return f"{folder} is not a complete record: {reason}."


def stored_figures(run: RunRecord, file: Path) -> dict[str, float | None]:
    """Return the figures that the `run.json` of a run gives.

    Raises:
        RecordError: one is missing, or is not one that a run can have.
    """
    figures = convert(run.metrics, _Figures, str(file), RecordError, remedy=_REMEDY, path=("metrics",))
    return {name: getattr(figures, name) for name in RunMetrics.names()}


def differences(run: RunRecord, computed: RunMetrics) -> tuple[str, ...]:
    """Return the names of what a run's `run.json` says otherwise than it was computed from the messages."""
    known = run.metrics
    figures = [
        name for name, value in computed.to_json().items() if name in known and not _same(known[name], value)
    ]
    stored, found = (
        [value for one in outcomes for value in dataclasses.astuple(one)]
        for outcomes in (run.fault_outcomes, computed.outcomes)
    )
    same = len(stored) == len(found) and all(map(_same, stored, found))
    return (*figures, *([] if same else ["fault_outcomes"]))


def _same(one: object, other: object) -> bool:
    """Return whether two figures are equal, but for the last digits that another computer may give."""
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-9)
    return one == other


class StoredFlight(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What a campaign's results depend on of a flight.

    Attributes:
        conditions: under which it was rendered; none for a bag.
        entropy_threshold: F4 holds above it there.
        sharpness_threshold: F5 holds below it there.
        warning: what a reader must know of it, in one sentence; empty if nothing.
    """

    bag_checksum: str
    conditions: dict[str, int | float | str] | UnsetType = UNSET
    entropy_threshold: Positive
    sharpness_threshold: Positive
    warning: str = ""


class CampaignPlan(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What `bench.json` says: whatever a campaign's results may depend on, by name and by content.

    Attributes:
        suite: the suite's name or folder.
        scenarios: those of it that are run; all if there is none.
        scenarios_checksum: of all scenarios that are run.
        split: the hash that pins the split in the suite's folder; empty if it has none.
        references: whether the paper's two reference rows are run too.
        score: whether the managing systems that scores are measured between are run too.
        manager_checksums: of the files that they are written in, by name.
        seed: of the first repetition.
        runs: how many there are in all.
        model_checksum: of the model's card.
        bag: the bag's path; None for the default flight.
        flights: those that every scenario is run on, as they were named; each on its own if there is none.
        flight_facts: what results depend on of each flight but the default one, by its name.
        speed: seconds of `/clock` in a second; live.
        task: of the managing systems: `repair` or `diagnose`.
        thinking_s: what every decision of a managing system takes of the experiment's time [s].
        versions: of everything that a record's bytes may depend on.
        extensions: of the system's description: name → checksum.
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


def read_plan(folder: Path) -> CampaignPlan:
    """Return what `bench.json` of a campaign's folder says.

    Raises:
        RecordError: it is missing or damaged, does not fit the schema, or is of another version.
    """
    file = folder / PLAN_FILE
    content = read_json(file, "The campaign's plan", RecordError)
    _check_version(f"The campaign in {folder}", content, "plan_version", PLAN_VERSION, "name a new folder")
    return convert(content, CampaignPlan, str(file), RecordError, remedy="restore it, or name a new folder")


def _check_version(what: str, content: object, key: str, expected: int, remedy: str) -> None:
    """Raise if a document is of another version; one that is not an object is refused later."""
    version = content.get(key) if isinstance(content, dict) else expected
    if version != expected:
        raise RecordError(
            f"{what} is of version {reprlib.repr(version)}, expected {expected}; read it with the SUNSET that wrote "
            f"it, or {remedy}."
        )
