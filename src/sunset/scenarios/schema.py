"""Scenarios, checked when they are made."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import yaml
from msgspec import Meta

from sunset.errors import ScenarioError
from sunset.files.schemas import check_fields
from sunset.flights import FlightSpec
from sunset.scenarios.courses import problems
from sunset.scenarios.fault import LONGEST_S, ScenarioFault, to_floats
from sunset.system import DURATION_S
from sunset.texts.sentences import listed
from sunset_ros.texts import shown


@dataclass(frozen=True, slots=True)
class Scenario:
    """The faults of a run.

    Attributes:
        name: its name in results, such as `paper/gpu_failure+image_shift+autofocus_needed`.
        faults: the faults; none for a healthy run. A fault may not overlap itself or a fault that it excludes.
        description: one sentence for a reader; may be empty.
        duration: the measured time [s]; None for the paper's 20 s.
        flight: the flight; None for the default flight.

    Raises:
        ScenarioError: faults overlap or exclude each other, a fault never comes, or the name is empty.
    """

    name: str
    faults: Annotated[
        tuple[ScenarioFault, ...],
        Meta(description="a tuple of ScenarioFault, as in sunset.make_scenario('gpu_failure').faults"),
    ] = ()
    description: str = ""
    duration: Annotated[float, Meta(ge=1, le=LONGEST_S, title="duration of a scenario [s]")] | None = None
    flight: FlightSpec | None = None

    def __post_init__(self) -> None:
        check_fields(self, ScenarioError)
        if not self.name.strip() or not self.name.isprintable():
            raise ScenarioError(f"A scenario needs a name of printable characters, got {shown(self.name)}.")
        to_floats(self, "duration")
        object.__setattr__(self, "faults", tuple(self.faults))
        for _, problem in problems(self.faults, self.duration_s):
            raise ScenarioError(problem)

    @property
    def duration_s(self) -> float:
        """The measured time, unless the run overrides it [s]."""
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


def with_strengths(
    scenario: Scenario, strengths: Mapping[str, Sequence[float | None]], model: str
) -> Scenario:
    """Return a scenario in which strengths replace the severities.

    Args:
        scenario: the scenario.
        strengths: of the model: fault → a strength for each severity; None if no strength costs so much.
        model: the model's name.

    Raises:
        ScenarioError: no strength of a fault is so severe for the model, or the model's strengths are unknown.
    """

    def strong(fault: ScenarioFault) -> ScenarioFault:
        if fault.severity is None:
            return fault
        known = strengths.get(fault.name)
        if known is None:
            raise ScenarioError(
                f"The scenario {scenario.name} gives {fault.name} a severity, and the model {model} does not know its "
                "strengths: give a value, or let 'sunset models curves' measure them."
            )
        value = known[fault.severity - 1]
        if value is None:
            reached = [str(number) for number, strength in enumerate(known, 1) if strength is not None]
            levels = f"the severities {listed(reached)} can" if reached else "no severity can"
            raise ScenarioError(
                f"The scenario {scenario.name} gives {fault.name} the severity {fault.severity}, which no strength "
                f"reaches with the model {model}; {levels}."
            )
        return replace(fault, value=value, severity=None)

    return replace(scenario, faults=tuple(map(strong, scenario.faults)))
