"""The full specification of an experiment, as it is stored with its result."""

from dataclasses import dataclass, field
from typing import Final

from sunset.errors import InvalidInputError, ScenarioError
from sunset.experiments.settings import RunTiming, Settings
from sunset.files.schemas import check_fields
from sunset.flights import FlightSpec
from sunset.managing import EXTERNAL, split_label
from sunset.recording import RunRecord, StoredFault
from sunset.scenarios import After, Profile, Scenario, ScenarioFault, problems, suite_of
from sunset.system import LoadedExtension, load_extension, loaded_extensions
from sunset_ros.rmw.backends import LIVE
from sunset_ros.seeding import check_seed

DEFAULT_SCENARIO: Final = "camera_driver_issue+image_degradation"
"""The scenario of a run that names none: an outage with its ripples, and a degradation that looks like three others.

The baseline repairs the outage at a high price and guesses wrong about the degradation. `reactive` cures both.
"""

CHECK_SCENARIO: Final = "paper/cuda_out_of_memory+image_shift+autofocus_needed"
"""The scenario of checks of managing systems: an outage and two degradations, each with another symptom."""


@dataclass(frozen=True, kw_only=True)
class RunSpec:
    """An experiment: scenario, managing system, seed and settings.

    In the simulation the same specification gives a byte-identical record, in any process and with any number of
    workers.
    """

    scenario: Scenario
    manager: str = "baseline"
    """`none`, `baseline`, `module:Class`, `path/to/file.py:Class` or `exec:COMMAND`; live, `external` too.

    With `LABEL=` before it, the label is kept in `label`.
    """
    seed: int = 1
    settings: Settings = field(default_factory=Settings)
    label: str = ""
    """The managing system's name in tables, records and campaigns, if that is not `manager`."""
    extensions: tuple[LoadedExtension, ...] = field(default_factory=loaded_extensions)
    """Extensions of the managed system: those that are loaded when this is made."""
    suite_size: int = 0
    """How many scenarios the suite of a campaign has; used where the system does not know the suite."""

    def __post_init__(self) -> None:
        check_seed(self.seed)
        check_fields(self)
        label, manager = split_label(self.manager)
        object.__setattr__(self, "label", label or self.label)
        object.__setattr__(self, "manager", manager)
        if self.manager == EXTERNAL and not self.settings.live:
            raise InvalidInputError(
                f"A managing system of another process can manage a live run only: --middleware {LIVE}."
            )
        thinking_s, duration_s = self.settings.thinking_s, self.timing.duration_s
        if thinking_s > duration_s:
            raise InvalidInputError(
                f"The time to think must be at most the duration that is measured, {duration_s:g} s, got "
                f"{thinking_s:g} s."
            )
        for _, problem in problems(self.scenario.faults, duration_s):
            raise ScenarioError(problem)

    @property
    def timing(self) -> RunTiming:
        """The timing, with the values that the scenario and the seed give."""
        return self.settings.timing.of_run(self.scenario, self.seed)

    def load_extensions(self) -> None:
        """Load the extensions into this process, which may be a new worker."""
        for extension in self.extensions:
            load_extension(extension.where, checksum=extension.checksum)

    @property
    def flight(self) -> FlightSpec:
        """The flight: of the settings, or the scenario, or else the default flight."""
        if self.settings.bag is not None:
            return FlightSpec(bag=self.settings.bag)
        return self.settings.flight or self.scenario.flight or FlightSpec()

    @property
    def manager_name(self) -> str:
        """The managing system's name in tables, records and campaigns."""
        return self.label or self.manager

    @property
    def suite(self) -> str:
        """The suite that the scenario is of; empty for a user's own scenario."""
        return suite_of(self.scenario)


def stored_faults(scenario: Scenario, asked: Scenario) -> list[StoredFault]:
    """Return the faults of a scenario for a record.

    `asked` is the same scenario with severities in place of the model's strengths.
    """
    return [
        StoredFault(**fault.to_mapping(), severity=wanted.severity)  # type: ignore[arg-type]  # as it checks itself
        for fault, wanted in zip(scenario.faults, asked.faults, strict=True)
    ]


def scenario_of(run: RunRecord) -> Scenario:
    """Return the scenario of a stored run."""
    faults = tuple(
        ScenarioFault(
            fault.name,
            fault.value if fault.severity is None else None,
            severity=fault.severity,
            at=fault.at,
            until=fault.until,
            profile=Profile(**fault.profile) if fault.profile else Profile(),  # type: ignore[arg-type]  # it checks itself
            after=After(**fault.after) if fault.after else None,  # type: ignore[arg-type]  # it checks itself
        )
        for fault in run.faults
    )
    return Scenario(run.scenario, faults, duration=run.duration_s)
