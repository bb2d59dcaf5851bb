"""A fault of a scenario, with its strength, its times, and the course of its strength."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Annotated, Final, TypeAlias

import yaml
from msgspec import Meta

from sunset.errors import MALFORMED_YAML, ScenarioError
from sunset.files.schemas import check_fields
from sunset.system import PERIOD_S, Adaptation, Fault, Value, get_fault
from sunset_ros.texts import shown, suggestion

STEP: Final = "step"
RAMP: Final = "ramp"
INTERMITTENT: Final = "intermittent"

PROFILES: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {STEP: (), RAMP: ("rise",), INTERMITTENT: ("on", "off")}
)
"""Kind of a profile → the times that it needs."""

LONGEST_S: Final = 3600.0
"""The longest time of a scenario [s]."""

Seconds: TypeAlias = Annotated[float, Meta(ge=PERIOD_S, le=LONGEST_S)]
"""A time of at least a frame's, since shorter times have no effect."""


def to_floats(instance: object, *names: str) -> None:
    """Make whole numbers of a frozen dataclass floating-point numbers, as files have them."""
    for name in names:
        value = getattr(instance, name)
        object.__setattr__(instance, name, None if value is None else float(value))


@dataclass(frozen=True, slots=True, kw_only=True)
class Profile:
    """The course of a fault's strength after its onset.

    Attributes:
        kind: `step`, full strength at once; `ramp`, growing from nothing; or `intermittent`, coming and going.
        rise: the time that a ramp grows [s].
        on: the time that an intermittent fault is there [s].
        off: the time that it is away after that [s].

    >>> str(Profile(kind="ramp", rise=5))
    'growing for 5 s'
    """

    kind: str = STEP
    rise: Seconds | None = None
    on: Seconds | None = None
    off: Seconds | None = None

    def __post_init__(self) -> None:
        check_fields(self, ScenarioError)
        if self.kind not in PROFILES:
            raise ScenarioError(
                f"There is no profile {shown(self.kind)}: {suggestion(self.kind, PROFILES)}choose one of "
                f"{', '.join(PROFILES)}."
            )
        given = tuple(name for name in ("rise", "on", "off") if getattr(self, name) is not None)
        if given != PROFILES[self.kind]:
            needed = ", ".join(PROFILES[self.kind]) or "no times"
            raise ScenarioError(
                f"The profile {self.kind} needs {needed}, got {', '.join(given) or 'none'}: change it, or choose "
                "another profile."
            )
        to_floats(self, "rise", "on", "off")

    def __str__(self) -> str:
        """Return it in words, such as `growing for 5 s`; empty for a step."""
        words = {
            STEP: "",
            RAMP: f"growing for {self.rise} s",
            INTERMITTENT: f"{self.on} s on and {self.off} s off",
        }
        return words[self.kind].replace(".0 s", " s")


@dataclass(frozen=True, slots=True, kw_only=True)
class After:
    """The onset of a fault that follows another fault, unless that is over by then.

    Attributes:
        fault: the other fault's name.
        delay: the time between the two onsets [s].
    """

    fault: str
    delay: Seconds

    def __post_init__(self) -> None:
        check_fields(self, ScenarioError)
        to_floats(self, "delay")


@dataclass(frozen=True, slots=True)
class ScenarioFault:
    """A fault of a scenario, at the strength that it is injected with.

    Attributes:
        name: its name in the catalogue.
        value: the value of its parameter; None for the strength of the paper's suite, and with a severity.
        severity: from 1 to 5, in place of a value: its cost, from which the model's card derives the strength.
        at: its onset, in seconds of the measured time.
        after: the fault that it follows; None if it has an onset of its own.
        until: when it heals, in seconds of the measured time; None if it stays.
        profile: the course of its strength after the onset.

    Raises:
        ScenarioError: the fault is unknown, or the attributes contradict it or each other.

    >>> ScenarioFault("image_shift").value
    10
    """

    name: str
    value: Value | None = None
    severity: Annotated[int, Meta(ge=1, le=5, title="severity of a fault")] | None = None
    at: Annotated[float, Meta(ge=0, le=LONGEST_S, title="onset (at) of a fault [s]")] = 0.0
    after: After | None = None
    until: Annotated[float, Meta(ge=0, le=LONGEST_S, title="end (until) of a fault [s]")] | None = None
    profile: Profile = Profile()

    def __post_init__(self) -> None:
        check_fields(self, ScenarioError)
        fault = get_fault(self.name)
        if self.severity is None:
            value = fault.value if self.value is None else fault.checked(self.value)
            object.__setattr__(self, "value", value)
        elif self.value is not None:
            raise ScenarioError(f"The fault {self.name} has a severity and a value: give one of them.")
        elif fault.limits is None:
            raise ScenarioError(
                f"The fault {self.name} has no strength, and so no severity: leave the severity out."
            )
        if self.after is not None and self.at:
            raise ScenarioError(
                f"The fault {self.name} has an onset (at) and comes after {self.after.fault}: give one of them."
            )
        if self.profile.kind == RAMP and fault.limits is None:
            raise ScenarioError(f"The fault {self.name} has no strength that could grow: leave the ramp out.")
        to_floats(self, "at", "until")

    @property
    def fault(self) -> Fault:
        """The entry of the catalogue."""
        return get_fault(self.name)

    @property
    def injection(self) -> tuple[Adaptation, ...]:
        """The adaptations that inject this fault at this strength."""
        fault = self.fault
        return tuple(
            replace(step, value=self.value) if step.parameter == fault.parameter else step
            for step in fault.injection
        )

    def to_mapping(self) -> dict[str, object]:
        """Return it as in a scenario file."""
        return _given(self)


def _given(part: ScenarioFault | Profile | After) -> dict[str, object]:
    """Return the values of a part that are not the default, by name."""
    values = ((field, getattr(part, field.name)) for field in fields(part))
    return {
        field.name: _given(value) if isinstance(value, Profile | After) else value
        for field, value in values
        if value != field.default
    }


def parse_fault(text: str) -> ScenarioFault:
    """Parse `name`, or `name=value` with a strength by YAML's rules.

    >>> parse_fault("image_shift=20").value
    20
    """
    name, separator, value = text.partition("=")
    return ScenarioFault(name, _value(value) if separator else None)


def _value(text: str) -> Value:
    try:
        value = yaml.safe_load(text)
        if isinstance(value, bool | int | float):
            return value
        return float(text)  # such as 1e-1, which is a text in YAML 1.1
    except (yaml.YAMLError, *MALFORMED_YAML):
        return text
