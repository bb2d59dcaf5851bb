"""One fault of a scenario: which, how strong, and when it is there."""

from dataclasses import dataclass, field, replace
from numbers import Real

import yaml

from sunset.errors import MALFORMED_YAML, ScenarioError
from sunset.scenarios._document import is_ambiguous
from sunset.scenarios.timing import RAMP, STEP, After, Profile, checked_seconds
from sunset.system import Adaptation, Fault, Value, get_fault
from sunset.texts import shown

SEVERITIES = range(1, 6)
"""The least severe is 1."""


@dataclass(frozen=True, slots=True)
class ScenarioFault:
    """One fault of a scenario, at the strength that it is injected with.

    Attributes:
        name: a fault of the catalogue.
        value: what its parameter is set to; None for the strength of the paper's suite, and with a severity.
        at: seconds after the measured time begins at which it comes.
        until: seconds after the measured time begins at which it heals by itself; None if it stays.
        profile: how its strength goes on after it has come.
        after: which other fault brings it; None if it comes by itself.
        severity: from 1 to 5, in place of a value: what the strength costs, which the model's card knows.

    Raises:
        ScenarioError: there is no such fault, the value is not one of its values, or what is said of its time
            contradicts itself.

    >>> ScenarioFault("image_shift").value
    10
    """

    name: str
    value: Value | None = None
    at: float = field(default=0.0, kw_only=True)
    until: float | None = field(default=None, kw_only=True)
    profile: Profile = field(default_factory=Profile, kw_only=True)
    after: After | None = field(default=None, kw_only=True)
    severity: int | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check the values, and put in the suite's strength where none is given."""
        if not isinstance(self.name, str) or not isinstance(self.value, Real | str | None):
            raise ScenarioError(
                f"A fault of a scenario must be a name and a strength, got {shown(self.name)} and {shown(self.value)}."
            )
        fault = get_fault(self.name)
        if self.severity is None:
            object.__setattr__(
                self, "value", fault.value if self.value is None else fault.checked(self.value)
            )
        else:
            self._check_severity(fault)
        self._check_time(fault)

    def _check_severity(self, fault: Fault) -> None:
        if type(self.severity) is not int or self.severity not in SEVERITIES:
            raise ScenarioError(
                f"The severity of the fault {self.name} must be a whole number from {SEVERITIES[0]} to "
                f"{SEVERITIES[-1]}, got {shown(self.severity)}."
            )
        if self.value is not None:
            raise ScenarioError(
                f"The fault {self.name} has a severity and a value: give one of them, since either says how strong it "
                "is."
            )
        if fault.limits is None:
            raise ScenarioError(
                f"The fault {self.name} has no strength, and so no severity: leave the severity out."
            )

    def _check_time(self, fault: Fault) -> None:
        object.__setattr__(self, "at", checked_seconds(f"The onset (at) of the fault {self.name}", self.at))
        if self.until is not None:
            end = checked_seconds(f"The end (until) of the fault {self.name}", self.until)
            object.__setattr__(self, "until", end)
        if not isinstance(self.profile, Profile) or not isinstance(self.after, After | None):
            raise ScenarioError(
                f"The fault {self.name} must have a Profile and an After or None, got {shown(self.profile)} and "
                f"{shown(self.after)}."
            )
        if self.after is not None and self.at:
            raise ScenarioError(
                f"The fault {self.name} has an onset (at) and comes after {self.after.fault}: give one of them, since "
                "either says when it comes."
            )
        if self.profile.kind == RAMP and fault.limits is None:
            raise ScenarioError(f"The fault {self.name} has no strength that could grow: leave the ramp out.")

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

    def to_mapping(self) -> dict[str, object]:
        """Return it as a scenario's file has it."""
        content: dict[str, object] = {"name": self.name}
        if self.severity is None:
            content["value"] = self.value
        else:
            content["severity"] = self.severity
        if self.at:
            content["at"] = self.at
        if self.after is not None:
            content["after"] = self.after.to_mapping()
        if self.until is not None:
            content["until"] = self.until
        if self.profile.kind != STEP:
            content["profile"] = self.profile.to_mapping()
        return content


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
