"""Run settings: a table of types, ranges, defaults and options, from which command line and Python calls are made."""

from collections.abc import Sequence
from dataclasses import Field, dataclass, field, fields
from math import ceil, floor, isclose
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Final, TypedDict

from msgspec import Meta

from sunset.errors import InvalidInputError
from sunset.files.schemas import check_fields
from sunset.flights import FlightSpec
from sunset.perception import DEVICES
from sunset.processes.workers import Stages
from sunset.scenarios import Scenario
from sunset.system import DURATION_S, PERIOD_S, REPAIR, TASKS, is_topic_name
from sunset_ros.rmw.backends import BACKENDS, LIVE, SIMULATED
from sunset_ros.seeding import generator
from sunset_ros.texts import shown

_LONGEST_LIMIT_S: Final = 1_000_000
"""Twelve days, which a timer of the operating system can hold."""

_DURATIONS_S: Final = (1, 3600)
"""From the second without messages that is an outage, to the run whose messages fit in memory."""

_WARM_UP_S: Final = (3.0, 6.0)
"""Least and greatest length of the warm-up that a seed draws."""


def _option(default: Any, name: str, text: str, **words: Any) -> Any:
    """Return a field that is an option: its name, a description, and arguments of `ArgumentParser.add_argument`.

    Its `flag` is derived from the name, and its `help` is the description, unless they are given.
    """
    return field(default=default, metadata={"option": name, "help": text, "words": words})


@dataclass(frozen=True, kw_only=True)
class Timing:
    """Durations of an experiment in seconds, of virtual time in the simulation."""

    duration_s: float | None = _option(
        None,
        "duration",
        f"seconds that are measured (default: those of the scenario, {DURATION_S:g} if it names none)",
        type=float,
        metavar="S",
    )
    warm_up_s: Annotated[float, Meta(ge=0, le=3600)] | None = None
    """Healthy operation before the measured time, not counted; drawn from the seed if it is None."""
    period_s: Annotated[float, Meta(gt=0, le=10)] = PERIOD_S
    """Time between two frames of the bag."""
    latency_s: Annotated[float, Meta(ge=0, le=10)] = 0.0005
    """Time that a message or a service request is on its way."""
    jitter: Annotated[float, Meta(ge=0, lt=1)] = 0.1
    """Relative half-width of the uniform jitter of the compute times, in [0, 1)."""
    bring_up_limit_s: Annotated[float, Meta(gt=0, le=3600)] = 60.0
    """Time until all nodes must be active."""

    def __post_init__(self) -> None:
        if self.duration_s is not None and type(self.duration_s) not in {int, float}:
            raise InvalidInputError(f"The duration must be a number, got {shown(self.duration_s)}.")
        check_fields(self)
        if self.duration_s is None:
            return
        shortest, longest = _DURATIONS_S
        is_whole = shortest <= self.duration_s <= longest and isclose(
            self.duration_s, round(self.duration_s / self.period_s) * self.period_s
        )
        if not is_whole:
            raise InvalidInputError(
                f"The duration that is measured must be from {shortest} to {longest} s and a multiple of "
                f"{self.period_s:g} s, in which a frame comes, got {self.duration_s:g} s."
            )

    def of_run(self, scenario: Scenario, seed: int) -> "RunTiming":
        """Return the timing of a run: the scenario and the seed give the values that are None here.

        The length of the warm-up is drawn uniformly and independent of the frames, so that a managing system cannot
        act on time instead of on symptoms.
        """
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        if self.duration_s is None:
            values["duration_s"] = scenario.duration
        if self.warm_up_s is None:
            values["warm_up_s"] = float(generator(seed, "onset").uniform(*_WARM_UP_S))
        return RunTiming(**values)


@dataclass(frozen=True, kw_only=True)
class RunTiming(Timing):
    """The timing of a single run, in which every value is known."""

    duration_s: float
    warm_up_s: Annotated[float, Meta(ge=0, le=3600)]

    @property
    def frames(self) -> int:
        """How many frames the bag player can publish.

        For a drawn warm-up it is the number for the longest warm-up, so that it reveals nothing about the seed.
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
        """How many frames a system without faults segments in the measured time."""
        return round(self.duration_s / self.period_s)


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How an experiment is run, whatever its scenario and managing system."""

    model: Annotated[str, Meta(min_length=1)] = _option(
        "lite", "model", "segmentation model", metavar="NAME|DIR"
    )
    bag: Path | None = _option(  # noqa: RUF009  it returns a field
        None, "bag", "a rosbag2 in place of the default flight", type=Path, metavar="PATH"
    )
    device: str = _option(
        "cpu", "device", "what networks run on; between devices, last digits may differ", choices=DEVICES
    )
    loop: bool = _option(False, "loop", "let a bag that is too short begin again at its first frame")
    timing: Timing = field(default_factory=Timing)
    cache: bool = _option(
        True,
        "cache",
        "simulation: look up what is computed from images in the user's cache folder, and keep it there",
        flag="--no-cache",
        help="simulation: compute everything from images again instead of looking it up",
    )
    manager_limit_s: Annotated[
        float, Meta(gt=0, le=_LONGEST_LIMIT_S, title="managing system's time limit [s]")
    ] = _option(
        30.0,
        "manager_limit",
        "processor time for loading the managing system and for each callback, or ten times as much wall time; "
        "live, it is wall time",
        metavar="S",
    )
    manager_env: tuple[str, ...] = _option(
        (),
        "manager_env",
        "let the managing system have this variable of your environment, such as the key of a service; no record "
        "has its value (repeatable)",
        metavar="NAME",
    )
    task: str = _option(
        REPAIR,
        "task",
        "what the managing system does: repair; or diagnose only, where all adaptations are refused",
        choices=TASKS,
    )
    thinking_s: Annotated[float, Meta(ge=0, le=_DURATIONS_S[1], title="time to think [s]")] = _option(
        0.0,
        "thinking",
        "seconds of the experiment that every decision of the managing system takes",
        metavar="S",
    )
    middleware: str = _option(
        SIMULATED,
        "middleware",
        "where the nodes run: "
        + "; ".join(f"{name} = {backend.where}" for name, backend in BACKENDS.items()),
        choices=tuple(BACKENDS),
    )
    speed: Annotated[float, Meta(ge=0.01, le=100, title="rate of a live run")] = _option(
        1.0, "rate", "live: seconds of /clock in a second", metavar="R"
    )
    viewers: tuple[str, ...] = _option(
        (),
        "viewers",
        "live: full name of a node that only watches and may read everything, such as /rosbag2_recorder (repeatable)",
        flag="--viewer",
        metavar="NODE",
    )
    images: bool = _option(False, "images", "keep all images in the record, losslessly: some 100 MB for 20 s")
    flight: FlightSpec | None = None
    """The flight, whatever the scenario says; if it is None, that of the scenario, or the default flight."""

    def __post_init__(self) -> None:
        check_fields(self)
        if self.middleware not in BACKENDS:
            raise InvalidInputError(
                f"The middleware must be {' or '.join(BACKENDS)}, got {self.middleware!r}."
            )
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
        return self.middleware != SIMULATED


OPTIONS: Final = MappingProxyType(
    {
        setting.metadata["option"]: setting
        for setting in (*fields(Settings), *fields(Timing))
        if "option" in setting.metadata
    }
)
"""The settings that are options: name of the option → field."""


class Options(TypedDict, total=False):
    """Options of every call that runs experiments; each can be left out.

    `extensions` extends the managed system until the call returns. `preparing` is called with (stage, frames done,
    all frames) while flights are rendered and measured. The command line has the other options, too:
    """

    model: str | Path
    bag: str | Path | None
    device: str
    loop: bool
    duration: float | None
    cache: bool
    manager_limit: float
    manager_env: str | Sequence[str]
    task: str
    thinking: float
    middleware: str
    rate: float
    viewers: list[str] | tuple[str, ...]
    images: bool
    extensions: str | Path | Sequence[str | Path]
    preparing: Stages | None


def _described(option: str, setting: Field[Any]) -> str:
    default = f" (default: {setting.default})" if "(default: " not in setting.metadata["help"] else ""
    return f"    - `{option}`: {setting.metadata['help']}{default}\n"


Options.__doc__ = f"{Options.__doc__}\n" + "".join(_described(*item) for item in OPTIONS.items())
