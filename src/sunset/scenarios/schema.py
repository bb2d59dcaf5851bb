"""Scenarios: their faults with strength and times, and when these come and heal if they are not cured."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import combinations
from math import inf
from types import MappingProxyType
from typing import Annotated, Final, TypeAlias

import yaml
from msgspec import Meta

from sunset.errors import MALFORMED_YAML, ScenarioError
from sunset.files.schemas import check_fields
from sunset.flights import FlightSpec
from sunset.system import DURATION_S, PERIOD_S, Adaptation, Fault, Value, excluding_pairs, get_fault
from sunset.texts.sentences import listed
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

_MOST: Final = 1000
"""Faults of a scenario: each is compared with every other."""

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


@dataclass(frozen=True, slots=True)
class Scenario:
    """The faults of a run.

    Attributes:
        name: its name in results, such as `paper/gpu_failure+image_shift+autofocus_needed`.
        faults: the faults; none for a healthy run. A fault may not overlap itself or a fault that it excludes.
        description: one sentence for a reader; may be empty.
        duration: the measured time, unless the run overrides it [s].
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
    duration: Annotated[float, Meta(ge=1, le=LONGEST_S, title="duration of a scenario [s]")] = DURATION_S
    flight: FlightSpec | None = None

    def __post_init__(self) -> None:
        check_fields(self, ScenarioError)
        if not self.name.strip() or not self.name.isprintable():
            raise ScenarioError(f"A scenario needs a name of printable characters, got {shown(self.name)}.")
        to_floats(self, "duration")
        object.__setattr__(self, "faults", tuple(self.faults))
        for _, problem in problems(self.faults, self.duration):
            raise ScenarioError(problem)

    def to_yaml(self) -> str:
        """Return the scenario as a file that `load_scenario` reads."""
        content: dict[str, object] = {"name": self.name}
        if self.description:
            content["description"] = self.description
        if self.duration != DURATION_S:
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


def onsets(faults: Sequence[ScenarioFault]) -> tuple[float, ...]:
    """Return when each fault of a scenario comes if none is cured [s], also if it follows another fault."""
    return tuple(_onset(fault, faults) for fault in faults)


def _onset(fault: ScenarioFault, faults: Sequence[ScenarioFault]) -> float:
    if fault.after is None:
        return fault.at
    return _onset(_causes(fault, faults)[0], faults) + fault.after.delay


def _causes(fault: ScenarioFault, faults: Sequence[ScenarioFault]) -> list[ScenarioFault]:
    """Return the faults with the name that a fault follows; none if it comes at a time of its own."""
    return [cause for cause in faults if fault.after and cause.name == fault.after.fault]


def problems(faults: Sequence[ScenarioFault], duration_s: float) -> Iterator[tuple[int, str]]:
    """Yield why faults cannot make a scenario: the position of the fault in question, and a sentence.

    Args:
        faults: the faults of the scenario.
        duration_s: the length of the scenario [s].
    """
    if len(faults) > _MOST:
        yield _MOST, f"A scenario has at most {_MOST} faults, got {len(faults)}: leave some out."
        return
    links = [(number, _link_problem(fault, faults)) for number, fault in enumerate(faults)]
    broken = [(number, problem) for number, problem in links if problem]
    if broken:
        yield from broken
        return
    begun = onsets(faults)
    for number, (fault, onset) in enumerate(zip(faults, begun, strict=True)):
        problem = _time_problem(fault, onset, faults, duration_s)
        if problem:
            yield number, problem
    yield from _conflicts(faults, begun)


def _link_problem(fault: ScenarioFault, faults: Sequence[ScenarioFault]) -> str:
    """Return why a fault cannot follow the fault of its `after`; nothing if it can."""
    if fault.after is None:
        return ""
    causes = _causes(fault, faults)
    if len(causes) != 1:
        there = "is there more than once" if causes else "is not in the scenario"
        return f"The fault {fault.name} comes after {fault.after.fault}, which {there}: name one that is there once."
    names = [fault.name]
    while causes and causes[0].name not in names:
        names.append(causes[0].name)
        causes = _causes(causes[0], faults)
    if not causes or causes[0].name != fault.name:
        return ""
    way = f", by way of {' and '.join(names[1:])}" if names[1:] else ""
    return f"The fault {fault.name} comes after itself{way}: one fault must come at a time of its own (at)."


def _time_problem(
    fault: ScenarioFault, onset: float, faults: Sequence[ScenarioFault], duration_s: float
) -> str:
    """Return why a fault cannot come or end at its time; nothing if it can."""
    if onset >= duration_s:
        return (
            f"The fault {fault.name} comes at {onset:g} s, and the run ends at {duration_s:g} s: let it come earlier, "
            "or give the scenario a longer duration."
        )
    if fault.until is not None and fault.until <= onset:
        return f"The fault {fault.name} ends (until) at {fault.until:g} s and comes at {onset:g} s: let it end later."
    for cause in _causes(fault, faults):
        if cause.until is not None and cause.until <= onset:
            return (
                f"The fault {fault.name} never comes: {cause.name}, which it follows after "
                f"{onset - _onset(cause, faults):g} s, heals at {cause.until:g} s already."
            )
    return ""


def _conflicts(faults: Sequence[ScenarioFault], begun: Sequence[float]) -> Iterator[tuple[int, str]]:
    """Yield faults that overlap themselves, or a fault that they exclude."""
    spans = [
        (onset, inf if fault.until is None else fault.until)
        for fault, onset in zip(faults, begun, strict=True)
    ]
    excluding = {frozenset(pair): " and ".join(pair) for pair in excluding_pairs()}
    for place, other in combinations(range(len(faults)), 2):
        first, second = sorted((spans[place], spans[other]))
        name, are_same = faults[place].name, faults[place].name == faults[other].name
        pair = excluding.get(frozenset({name, faults[other].name}))
        if second[0] > first[1] or (second[0] == first[1] and not are_same):
            continue
        if are_same and first == second:
            yield other, f"The scenario has the fault {name} twice; name each once."
        elif are_same:
            until = "on" if first[1] == inf else f"to {first[1]:g} s"
            yield (
                other,
                f"The fault {name} comes at {second[0]:g} s, and is there from {first[0]:g} s {until}.",
            )
        elif pair:
            yield other, f"The scenario has both {pair} at a time, of which each cures the other."
