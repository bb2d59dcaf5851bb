"""The times of a scenario's fault, and the course of its strength."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Annotated, Final, TypeAlias

from msgspec import Meta

from sunset.errors import ScenarioError
from sunset.schemas import check_fields
from sunset.system import PERIOD_S
from sunset.texts import shown, suggestion

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

    Raises:
        ScenarioError: the kind is unknown, or does not have these times.

    >>> Profile(kind="ramp", rise=5).to_mapping()
    {'kind': 'ramp', 'rise': 5.0}
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

    def to_mapping(self) -> dict[str, str | float]:
        """Return it as in a scenario file."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in values.items() if value is not None}

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

    Raises:
        ScenarioError: the delay is out of range.
    """

    fault: str
    delay: Seconds

    def __post_init__(self) -> None:
        check_fields(self, ScenarioError)
        to_floats(self, "delay")

    def to_mapping(self) -> dict[str, str | float]:
        """Return it as in a scenario file."""
        return {"fault": self.fault, "delay": self.delay}
