"""What a scenario is: a name and the faults of a run, checked when it is made."""

from dataclasses import dataclass

import yaml

from sunset.errors import ScenarioError
from sunset.flights import FlightSpec
from sunset.scenarios.courses import problems
from sunset.scenarios.fault import ScenarioFault, parse_fault
from sunset.scenarios.timing import checked_seconds
from sunset.system import DURATION_S
from sunset.texts import shown

__all__ = ["Scenario", "ScenarioFault", "parse_fault"]


@dataclass(frozen=True, slots=True)
class Scenario:
    """The faults of one run.

    Attributes:
        name: its name in results, such as `paper/gpu_failure+image_shift+autofocus_needed`.
        faults: the faults; none for a healthy run. At no time is one there twice, or two that exclude each other.
        description: one sentence for a reader; may be empty.
        duration: how long is measured [s]; None for the paper's 20 s.
        flight: what is flown; None for the default flight.

    Raises:
        ScenarioError: a fault is there twice at some time, two exclude each other, one never comes, or the name is
            empty.
    """

    name: str
    faults: tuple[ScenarioFault, ...] = ()
    description: str = ""
    duration: float | None = None
    flight: FlightSpec | None = None

    def __post_init__(self) -> None:
        """Check that the faults can be there together."""
        if not isinstance(self.name, str) or not self.name.strip() or not self.name.isprintable():
            raise ScenarioError(f"A scenario needs a name of printable characters, got {shown(self.name)}.")
        if not isinstance(self.faults, tuple | list) or not all(
            isinstance(fault, ScenarioFault) for fault in self.faults
        ):
            raise ScenarioError(
                f"The faults of the scenario {self.name} must be a tuple of ScenarioFault, got {shown(self.faults)}; "
                'sunset.make_scenario("gpu_failure") makes a scenario of names.'
            )
        if self.duration is not None:
            seconds = checked_seconds("The duration of a scenario", self.duration, least=1.0)
            object.__setattr__(self, "duration", seconds)
        if not isinstance(self.flight, FlightSpec | None):
            raise ScenarioError(
                f"The flight of the scenario {self.name} must be a FlightSpec or None, got {shown(self.flight)}."
            )
        object.__setattr__(self, "faults", tuple(self.faults))
        for _, problem in problems(self.faults, self.duration_s):
            raise ScenarioError(problem)

    @property
    def duration_s(self) -> float:
        """How long is measured, unless the run says otherwise [s]."""
        return DURATION_S if self.duration is None else self.duration

    def to_yaml(self) -> str:
        """Return the scenario as a file that `load_scenario` reads."""
        content: dict[str, object] = {"name": self.name}
        if self.description:
            content["description"] = self.description
        if self.duration is not None:
            content["duration"] = self.duration
        if self.flight is not None:
            content["flight"] = self.flight.conditions()
        content["faults"] = [fault.to_mapping() for fault in self.faults]
        text: str = yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=100)
        return text
