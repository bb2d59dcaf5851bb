"""When a fault of a scenario is there, and how its strength goes on."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import isfinite
from types import MappingProxyType
from typing import Final

from sunset.errors import ScenarioError
from sunset.system import PERIOD_S
from sunset.texts import shown, suggestion

STEP: Final = "step"
RAMP: Final = "ramp"
INTERMITTENT: Final = "intermittent"

PROFILES: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {STEP: (), RAMP: ("rise",), INTERMITTENT: ("on", "off")}
)
"""Kind of a profile → the times that it has."""

LONGEST_S: Final = 3600.0
"""No time of a scenario is longer, in seconds."""

_SHORTEST_S: Final = PERIOD_S
"""A frame's: nothing would be seen of a shorter time."""


def checked_seconds(what: str, seconds: object, *, least: float = 0.0) -> float:
    """Return a time of a scenario, a number of seconds from `least` to `LONGEST_S`.

    Raises:
        ScenarioError: it is not one; `what` says of what.
    """
    if isinstance(seconds, int | float) and not isinstance(seconds, bool):
        number = float(seconds) if abs(seconds) <= LONGEST_S else float("nan")
        if isfinite(number) and number >= least:
            return number
    raise ScenarioError(f"{what} must be seconds from {least:g} to {LONGEST_S:g}, got {shown(seconds)}.")


@dataclass(frozen=True, slots=True, kw_only=True)
class Profile:
    """How the strength of a fault goes on after its onset.

    Attributes:
        kind: `step`, all of it at once; `ramp`, it grows from nothing; or `intermittent`, it comes and goes.
        rise: how long a ramp grows [s].
        on: how long an intermittent fault is there each time [s].
        off: how long it is away after that [s].

    Raises:
        ScenarioError: there is no such kind, or its times are not those of the kind.

    >>> Profile(kind="ramp", rise=5).to_mapping()
    {'kind': 'ramp', 'rise': 5.0}
    """

    kind: str = STEP
    rise: float | None = None
    on: float | None = None
    off: float | None = None

    def __post_init__(self) -> None:
        """Check that it has the times of its kind, and no other."""
        if not isinstance(self.kind, str) or self.kind not in PROFILES:
            raise ScenarioError(
                f"There is no profile {shown(self.kind)}: {suggestion(self.kind, PROFILES)}choose one of "
                f"{', '.join(PROFILES)}."
            )
        for name in ("rise", "on", "off"):
            value = getattr(self, name)
            if name not in PROFILES[self.kind]:
                if value is not None:
                    raise ScenarioError(
                        f"The profile {self.kind} has no {name}: leave it out, or choose another profile."
                    )
                continue
            if value is None:
                raise ScenarioError(f"The profile {self.kind} needs {name}, in seconds.")
            seconds = checked_seconds(f"The {name} of the profile {self.kind}", value, least=_SHORTEST_S)
            object.__setattr__(self, name, seconds)

    def to_mapping(self) -> dict[str, str | float]:
        """Return it as a scenario's file has it."""
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
    """That a fault follows another one, unless that is over by then.

    Attributes:
        fault: the other fault's name.
        delay: seconds from the other's onset to this one's.

    Raises:
        ScenarioError: the name is not a text, or the delay is out of range.
    """

    fault: str
    delay: float

    def __post_init__(self) -> None:
        """Check both."""
        if not isinstance(self.fault, str):
            raise ScenarioError(
                f"The fault that another one comes after must be a name, got {shown(self.fault)}."
            )
        delay = checked_seconds(f"The delay after {self.fault}", self.delay, least=_SHORTEST_S)
        object.__setattr__(self, "delay", delay)

    def to_mapping(self) -> dict[str, str | float]:
        """Return it as a scenario's file has it."""
        return {"fault": self.fault, "delay": self.delay}
