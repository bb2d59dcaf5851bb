"""Reading scenarios: YAML texts in our format and in the published exemplar's, with complaints that name the line."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from sunset.errors import InvalidInputError
from sunset.flights import KEYS, FlightSpec
from sunset.scenarios._document import Item, parse_yaml
from sunset.scenarios._published import IGNORED_KEYS, REQUIRED_KEYS, translate
from sunset.scenarios.courses import problems
from sunset.scenarios.fault import ScenarioFault
from sunset.scenarios.schema import Scenario
from sunset.scenarios.timing import After, Profile
from sunset.system import DURATION_S


def parse_scenario(text: str, source: str) -> Scenario:
    """Return the scenario that a YAML text describes, in our format or in the published exemplar's.

    Args:
        text: the YAML text.
        source: where it comes from, for messages; its stem names a scenario of the published format.

    Raises:
        ScenarioError: it is not valid YAML or not a scenario; the message names source and line.
    """
    root = parse_yaml(text, source)
    return _published(root, source) if root.is_list else _ours(root)


def parse_suite(text: str, name: str) -> tuple[Scenario, ...]:
    """Return the scenarios of a suite that a YAML text lists, each as in a scenario file.

    Args:
        text: the YAML text.
        name: the suite's, which goes before the scenarios' names.

    Raises:
        ScenarioError: it is not valid YAML or not such a list; the message names suite and line.

    >>> parse_suite("[{name: late, faults: [{name: gpu_failure, at: 9}]}]", "mine")[0].name
    'mine/late'
    """
    items = parse_yaml(text, f"The suite {name}").items()
    scenarios = [(item, _ours(item)) for item in items]
    named: dict[str, Scenario] = {}
    for item, scenario in scenarios:
        if scenario.name in named:
            raise item.error(f"The scenario {scenario.name} is there twice; rename one.")
        named[scenario.name] = replace(scenario, name=f"{name}/{scenario.name}")
    return tuple(named.values())


def _ours(root: Item) -> Scenario:
    fields = root.mapping(required=("name", "faults"), optional=("description", "duration", "flight"))
    items = fields["faults"].items()
    faults = tuple(map(_fault, items))
    name = fields["name"].text()
    description = fields["description"].text() if "description" in fields else ""
    duration = None
    if "duration" in fields:
        seconds = fields["duration"].number()
        with fields["duration"].located():
            duration = Scenario("duration", duration=seconds).duration
    for number, problem in problems(faults, DURATION_S if duration is None else duration):
        raise items[number].error(problem)
    flight = _flight(fields.get("flight"))
    with root.located():
        return Scenario(name, faults, description, duration, flight)


def _fault(item: Item) -> ScenarioFault:
    if item.is_scalar:
        name = item.text()
        with item.located():
            return ScenarioFault(name)
    fields = item.mapping(
        required=("name",), optional=("value", "at", "until", "profile", "after", "severity")
    )
    name = fields["name"].text()
    value = fields["value"].value() if "value" in fields else None
    severity: Any = fields["severity"].value() if "severity" in fields else None
    times = {key: fields[key].number() for key in ("at", "until") if key in fields}
    profile = _profile(fields["profile"]) if "profile" in fields else Profile()
    after = _after(fields["after"]) if "after" in fields else None
    with item.located():
        return ScenarioFault(name, value, profile=profile, after=after, severity=severity, **times)


def _profile(item: Item) -> Profile:
    fields = (
        {"kind": item} if item.is_scalar else item.mapping(required=("kind",), optional=("rise", "on", "off"))
    )
    kind = fields.pop("kind").text()
    times = {key: one.number() for key, one in fields.items()}
    with item.located():
        return Profile(kind=kind, **times)


def _after(item: Item) -> After:
    fields = item.mapping(required=("fault", "delay"), optional=())
    fault, delay = fields["fault"].text(), fields["delay"].number()
    with item.located():
        return After(fault=fault, delay=delay)


def _flight(item: Item | None) -> FlightSpec | None:
    if item is None:
        return None
    fields = item.mapping(required=(), optional=KEYS)
    values: dict[str, object] = {key: one.value() for key, one in fields.items()}
    if "bag" in fields:
        values["bag"] = str(Path(item.source).parent / fields["bag"].text())
    try:
        return FlightSpec.of(values)
    except InvalidInputError as error:
        raise item.error(str(error)) from error


def _published(root: Item, source: str) -> Scenario:
    faults = []
    for item in root.items():
        fields = item.mapping(required=REQUIRED_KEYS, optional=IGNORED_KEYS)
        name, target, kind = (fields[key].text() for key in ("name", "target_node", "type"))
        value = fields["value"].value()
        with item.located():
            faults.append(ScenarioFault(*translate(name, target, kind, value)))
    with root.located():
        return Scenario(name=Path(source).stem, faults=tuple(faults))
