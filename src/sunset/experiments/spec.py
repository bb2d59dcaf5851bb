"""What is run: the full specification of one experiment, as it is stored with its result."""

from dataclasses import dataclass, field, fields
from math import ceil, floor, isclose
from pathlib import Path
from typing import Annotated, Final

from msgspec import Meta

from sunset.errors import InvalidInputError, ScenarioError
from sunset.flights import FlightSpec
from sunset.managing import EXTERNAL, split_label
from sunset.rmw.backends import BACKENDS, LIVE, SIMULATED
from sunset.scenarios import Scenario, problems, suite_of
from sunset.schemas import check_fields
from sunset.seeding import check_seed, generator
from sunset.system import (
    PERIOD_S,
    REPAIR,
    TASKS,
    LoadedExtension,
    is_topic_name,
    load_extension,
    loaded_extensions,
)
from sunset.texts import shown

MIDDLEWARES: Final = tuple(BACKENDS)

_LONGEST_LIMIT_S: Final = 1_000_000
"""Twelve days, which a timer of the operating system can hold."""

_DURATIONS_S: Final = (1, 3600)
"""From the second without messages that makes an outage, to what a record's messages fit in memory."""

DEFAULT_SCENARIO: Final = "camera_driver_issue+image_degradation"
"""What is run where no scenario is named: an outage with its ripples, and a degradation that looks like three others.

The baseline repairs the one at a high price and guesses wrong about the other. `reactive` cures both.
"""

CHECK_SCENARIO: Final = "paper/cuda_out_of_memory+image_shift+autofocus_needed"
"""What a managing system is checked in: an outage and two degradations, each with another symptom."""


_WARM_UP_S: Final = (3.0, 6.0)
"""Least and greatest length of the warm-up that a seed draws."""


@dataclass(frozen=True, kw_only=True)
class Timing:
    """The clockwork of experiments; every duration in seconds, of virtual time in the simulation."""

    duration_s: float | None = None
    """How long is measured; as long as the scenario says if it is None."""
    warm_up_s: Annotated[float, Meta(ge=0, le=3600)] | None = None
    """Healthy operation before the measured time, not counted; drawn from the seed if it is None."""
    period_s: Annotated[float, Meta(gt=0, le=10)] = PERIOD_S
    """Time between two frames of the bag."""
    latency_s: Annotated[float, Meta(ge=0, le=10)] = 0.0005
    """Time that a message or a service request is on its way."""
    jitter: Annotated[float, Meta(ge=0, lt=1)] = 0.1
    """Relative half-width of the uniform jitter of the compute times, in [0, 1)."""
    bring_up_limit_s: Annotated[float, Meta(gt=0, le=3600)] = 60.0
    """How long all nodes may take until they are active."""

    def __post_init__(self) -> None:
        """Check how long is measured.

        Raises:
            InvalidInputError: it is out of range, or no whole number of frames; or another value is out of range.
        """
        if self.duration_s is not None and type(self.duration_s) not in {int, float}:
            raise InvalidInputError(f"The duration must be a number, got {shown(self.duration_s)}.")
        check_fields(self)
        if self.duration_s is None:
            return
        shortest, longest = _DURATIONS_S
        whole = shortest <= self.duration_s <= longest and isclose(
            self.duration_s, round(self.duration_s / self.period_s) * self.period_s
        )
        if not whole:
            raise InvalidInputError(
                f"The duration that is measured must be from {shortest} to {longest} s and a multiple of "
                f"{self.period_s:g} s, in which a frame comes, got {self.duration_s:g} s."
            )

    def of_run(self, scenario: Scenario, seed: int) -> "RunTiming":
        """Return the clockwork of a run, in which the scenario and the seed say what is open here.

        The length of the warm-up is drawn uniformly and independent of the frames, so that a managing system cannot
        act on time instead of on symptoms.

        Raises:
            InvalidInputError: the scenario's duration is no whole number of frames.
        """
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        if self.duration_s is None:
            given["duration_s"] = scenario.duration_s
        if self.warm_up_s is None:
            given["warm_up_s"] = float(generator(seed, "onset").uniform(*_WARM_UP_S))
        return RunTiming(**given)


@dataclass(frozen=True, kw_only=True)
class RunTiming(Timing):
    """The clockwork of one run, in which no value is open any more."""

    duration_s: float
    warm_up_s: Annotated[float, Meta(ge=0, le=3600)]

    @property
    def frames(self) -> int:
        """How many frames the bag player can publish.

        For a drawn warm-up it is the number for the longest one, so that it reveals nothing about the seed.
        """
        shortest_s, longest_s = _WARM_UP_S
        if not shortest_s <= self.warm_up_s <= longest_s:
            longest_s = self.warm_up_s
        return ceil(round(longest_s / self.period_s, 6)) + self.expected_frames

    @property
    def least_frames(self) -> int:
        """How many frames it publishes at least until the end of the run."""
        return floor(round((self.warm_up_s + self.duration_s) / self.period_s, 6))

    @property
    def expected_frames(self) -> int:
        """How many frames a system without any fault segments while it is measured."""
        return round(self.duration_s / self.period_s)


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How an experiment is run, whatever its scenario and managing system."""

    model: Annotated[str, Meta(min_length=1)] = "lite"
    """A shipped model's name, or the folder of one's own."""
    bag: Path | None = None
    """A rosbag2 folder or file; if it is None, `flight`."""
    flight: FlightSpec | None = None
    """What is flown whatever the scenario says; if it is None, the scenario's flight, or else the default one."""
    loop: bool = False
    """Whether a bag that is too short begins again at its first frame after its last."""
    timing: Timing = field(default_factory=Timing)
    device: str = "cpu"
    """What networks run on: `cpu`, `cuda` or `auto`. Records of different devices may differ."""
    cache: bool = True
    """Whether results of inference are looked up and kept in the user's cache folder."""
    images: bool = False
    """Whether records keep images, which changes nothing else in them."""
    manager_limit_s: Annotated[
        float, Meta(gt=0, le=_LONGEST_LIMIT_S, title="managing system's time limit [s]")
    ] = 30.0
    """Processor time that one callback of the managing system may take before its process is ended."""
    manager_env: tuple[str, ...] = ()
    """Names of the user's environment variables that the managing system gets; their values are stored nowhere."""
    thinking_s: Annotated[float, Meta(ge=0, le=_DURATIONS_S[1], title="time to think [s]")] = 0.0
    """Time of the experiment that passes between a decision of the managing system and its adaptations."""
    task: str = REPAIR
    """One of `TASKS`."""
    middleware: str = SIMULATED
    """One of `BACKENDS`."""
    speed: Annotated[float, Meta(ge=0.01, le=100, title="rate of a live run")] = 1.0
    """Seconds of `/clock` in a second; live."""
    viewers: tuple[str, ...] = ()
    """Full names of nodes that only watch, and may read everything; live."""

    def __post_init__(self) -> None:
        """Check what can be checked without loading anything.

        Raises:
            InvalidInputError: a value is of another type or out of range, or two contradict each other.
        """
        check_fields(self)
        if self.middleware not in MIDDLEWARES:
            known = " or ".join(MIDDLEWARES)
            raise InvalidInputError(f"The middleware must be {known}, got {self.middleware!r}.")
        if self.task not in TASKS:
            raise InvalidInputError(f"The task must be {' or '.join(TASKS)}, got {shown(self.task)}.")
        if self.bag is not None and self.flight is not None:
            raise InvalidInputError(
                f"A run has one flight, got the bag {self.bag} and the flight {self.flight.name}: leave one out."
            )
        if self.speed != 1 and not self.live:
            raise InvalidInputError(
                f"The rate applies to live runs only, --middleware {LIVE}; simulated ones are as fast as can be."
            )

        for viewer in self.viewers:
            if not (viewer.startswith("/") and is_topic_name(viewer)):
                raise InvalidInputError(
                    f"A viewer must be the full name of a node, such as /rosbag2_recorder, got {shown(viewer)}."
                )
        if self.viewers and not self.live:
            raise InvalidInputError(f"Viewers watch live runs only, --middleware {LIVE}.")

    @property
    def live(self) -> bool:
        """Whether nodes are processes of the operating system, and time is real."""
        return BACKENDS[self.middleware].load is not None


@dataclass(frozen=True, kw_only=True)
class RunSpec:
    """One experiment: who manages what, under which faults, from which seed.

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
    """What the managed system is extended by: what is loaded when this is made."""
    suite_size: int = 0
    """How many scenarios the suite of a campaign has; used where the system does not know the suite."""

    def __post_init__(self) -> None:
        """Check what can be checked without loading anything.

        Raises:
            InvalidInputError: a value is of another type or out of range, or two contradict each other.
            ManagerError: the managing system's label is not valid.
            ScenarioError: a fault comes after the end of the run.
        """
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
        """The clockwork, with what the scenario and the seed say of it."""
        return self.settings.timing.of_run(self.scenario, self.seed)

    def load_extensions(self) -> None:
        """Make the managed system of this process, which may be a new one, what it was when this was made.

        Raises:
            ExtensionError: an extension cannot be loaded, or has changed meanwhile.
        """
        for extension in self.extensions:
            load_extension(extension.where, checksum=extension.checksum)

    @property
    def flight(self) -> FlightSpec:
        """What is flown: what the settings say, or the scenario, or else the default flight."""
        if self.settings.bag is not None:
            return FlightSpec(bag=self.settings.bag)
        return self.settings.flight or self.scenario.flight or FlightSpec()

    @property
    def manager_name(self) -> str:
        """What the managing system is called in tables, records and campaigns."""
        return self.label or self.manager

    @property
    def suite(self) -> str:
        """The suite that the scenario is of; empty for a scenario of one's own."""
        return suite_of(self.scenario)
