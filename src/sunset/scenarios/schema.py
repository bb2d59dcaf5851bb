"""Scenarios; and when their faults come and heal if they are not cured, which is checked when they are made."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import inf
from typing import Annotated, Final

import yaml
from msgspec import Meta

from sunset.errors import ScenarioError
from sunset.files.schemas import check_fields
from sunset.flights import FlightSpec
from sunset.scenarios.fault import LONGEST_S, ScenarioFault, to_floats
from sunset.system import DURATION_S, excluding_pairs
from sunset.texts.sentences import listed
from sunset_ros.texts import shown

_MOST: Final = 1000
"""Faults of a scenario: each is compared with every other."""


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
