"""What a scenario is: a name and the faults that are injected together, checked when it is made."""

from dataclasses import dataclass, replace
from numbers import Real

import yaml

from sunset.errors import MALFORMED_YAML, ScenarioError
from sunset.scenarios._document import is_ambiguous
from sunset.system import Adaptation, Fault, Value, current_system, get_fault
from sunset.texts import shown


@dataclass(frozen=True, slots=True)
class ScenarioFault:
    """One fault of a scenario, at the strength that it is injected with.

    Attributes:
        name: a fault of the catalogue.
        value: what its parameter is set to; None for the strength of the paper's suite.

    Raises:
        ScenarioError: there is no such fault, or the value is not one of its values.

    >>> ScenarioFault("image_shift").value
    10
    """

    name: str
    value: Value | None = None

    def __post_init__(self) -> None:
        """Check the value, and put in the suite's where none is given."""
        if not isinstance(self.name, str) or not isinstance(self.value, Real | str | None):
            raise ScenarioError(
                f"A fault of a scenario must be a name and a strength, got {shown(self.name)} and {shown(self.value)}."
            )
        fault = get_fault(self.name)
        object.__setattr__(self, "value", fault.value if self.value is None else fault.checked(self.value))

    @property
    def fault(self) -> Fault:
        """The entry of the catalogue."""
        return get_fault(self.name)

    @property
    def injection(self) -> tuple[Adaptation, ...]:
        """What is done to the managed system to inject this fault at this strength."""
        fault = self.fault
        return tuple(
            replace(step, value=self.value) if step.parameter == fault.parameter else step
            for step in fault.injection
        )


@dataclass(frozen=True, slots=True)
class Scenario:
    """The faults of one run; all are injected at once.

    Attributes:
        name: its name in results, such as `paper/gpu_failure+image_shift+autofocus_needed`.
        faults: the faults, each at most once, no two that exclude each other; none for a healthy run.
        description: one sentence for a reader; may be empty.

    Raises:
        ScenarioError: a fault is there twice, or two exclude each other, or the name is empty.
    """

    name: str
    faults: tuple[ScenarioFault, ...] = ()
    description: str = ""

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
        names = [fault.name for fault in self.faults]
        for index, name in enumerate(names):
            if name in names[:index]:
                raise ScenarioError(f"Scenario {self.name} has the fault {name} twice; name each once.")
        for one, other in current_system().exclusive:
            if one in names and other in names:
                raise ScenarioError(
                    f"Scenario {self.name} has both {one} and {other}, of which each cures the other."
                )

    def to_yaml(self) -> str:
        """Return the scenario as a file that `load_scenario` reads."""
        content: dict[str, object] = {"name": self.name}
        if self.description:
            content["description"] = self.description
        content["faults"] = [{"name": fault.name, "value": fault.value} for fault in self.faults]
        text: str = yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=100)
        return text


def parse_fault(text: str) -> ScenarioFault:
    """Return the fault that a text names: `name`, or `name=value` with a strength, by YAML's rules.

    Raises:
        ScenarioError: there is no such fault, or the value is not one of its values.

    >>> parse_fault("image_shift=20").value
    20
    """
    name, separator, value = text.partition("=")
    return ScenarioFault(name, _value(value) if separator else None)


def _value(text: str) -> Value:
    try:
        value = yaml.safe_load(text)
    except (yaml.YAMLError, *MALFORMED_YAML):
        return text
    if is_ambiguous(text, value):
        return text
    if isinstance(value, bool | int | float):
        return value
    try:
        return float(text)  # such as 1e-1, which is a text in YAML 1.1
    except ValueError:
        return text
