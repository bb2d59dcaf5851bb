"""Reading scenarios from YAML, in our format and in the published exemplar's; errors name the line."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from sunset.errors import InvalidInputError, ScenarioError
from sunset.flights import KEYS, FlightSpec
from sunset.scenarios._document import Item, parse_yaml
from sunset.scenarios.courses import problems
from sunset.scenarios.fault import After, Profile, ScenarioFault
from sunset.scenarios.schema import Scenario
from sunset.system import Value, get_fault
from sunset.texts.names import base_name

_REQUIRED_KEYS: Final = ("name", "target_node", "type", "value")
_IGNORED_KEYS: Final = ("criticality_level", "is_gt_failure", "probability")
"""Keys of an entry that do not concern the injection."""

_RENAMED: Final[Mapping[str, str]] = MappingProxyType(
    {
        "do_drop_camera": "camera_driver_issue",
        "do_drop_rgb_camera": "camera_driver_issue",
        "do_drop_sensor_fusion": "sync_issue",
        "do_drop_segmentation": "cuda_out_of_memory",
        "do_hard_drop_camera": "hardware_disconnect",
        "do_hard_drop_rgb_camera": "hardware_disconnect",
        "do_hard_drop_sensor_fusion": "memory_leakage",
        "do_hard_drop_segmentation": "gpu_failure",
    }
)
"""Parameter of the older published files → fault: a drop ends with a restart, a hard drop does not."""

_PUBLISHED_STRENGTHS: Final[Mapping[str, float]] = MappingProxyType(
    {"image_degradation": 1.5, "depth_degradation": 2.0, "image_shift": 300.0}
)
"""The strengths of the published files, on full-size images and the published networks."""

_LARGEST: Final = 1e9
"""Far above every strength of a fault."""


def parse_scenario(text: str, source: str) -> Scenario:
    """Parse a scenario in our format or in the published exemplar's.

    Args:
        text: the YAML text.
        source: its file, for messages; its stem names a scenario of the published format.

    Raises:
        ScenarioError: it is not valid YAML or not a scenario; the message names source and line.
    """
    root = parse_yaml(text, source)
    return _published(root, source) if root.is_list else _ours(root)


def parse_suite(text: str, name: str) -> tuple[Scenario, ...]:
    """Parse a list of scenarios, and put the suite's name before theirs.

    >>> parse_suite("[{name: late, faults: [{name: gpu_failure, at: 9}]}]", "mine")[0].name
    'mine/late'
    """
    named: dict[str, Scenario] = {}
    for item in parse_yaml(text, f"The suite {name}").items():
        scenario = _ours(item)
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
    flight = _flight(fields["flight"]) if "flight" in fields else None
    with root.located():
        scenario = Scenario(name, description=description, flight=flight)
    if "duration" in fields:
        duration = fields["duration"].number()
        with fields["duration"].located():
            scenario = replace(scenario, duration=duration)
    for number, problem in problems(faults, scenario.duration_s):
        raise items[number].error(problem)
    return replace(scenario, faults=faults)


def _fault(item: Item) -> ScenarioFault:
    if item.is_scalar:
        name = item.text()
        with item.located():
            return ScenarioFault(name)
    fields = item.mapping(
        required=("name",), optional=("value", "at", "until", "profile", "after", "severity")
    )
    values: dict[str, Any] = {key: fields[key].value() for key in ("value", "severity") if key in fields}
    values |= {key: fields[key].number() for key in ("at", "until") if key in fields}
    if "profile" in fields:
        values["profile"] = _profile(fields["profile"])
    if "after" in fields:
        values["after"] = _after(fields["after"])
    name = fields["name"].text()
    with item.located():
        return ScenarioFault(name, **values)


def _profile(item: Item) -> Profile:
    fields = (
        {"kind": item} if item.is_scalar else item.mapping(required=("kind",), optional=("rise", "on", "off"))
    )
    kind = fields.pop("kind").text()
    times = {key: field.number() for key, field in fields.items()}
    with item.located():
        return Profile(kind=kind, **times)


def _after(item: Item) -> After:
    fields = item.mapping(required=("fault", "delay"), optional=())
    fault, delay = fields["fault"].text(), fields["delay"].number()
    with item.located():
        return After(fault=fault, delay=delay)


def _flight(item: Item) -> FlightSpec:
    fields = item.mapping(required=(), optional=KEYS)
    values: dict[str, object] = {key: field.value() for key, field in fields.items()}
    if "bag" in fields:
        values["bag"] = str(Path(item.source).parent / fields["bag"].text())
    try:
        return FlightSpec.of(values)
    except InvalidInputError as error:
        raise item.error(str(error)) from error


def _translate(name: str, target_node: str, kind: str, value: Value) -> tuple[str, Value]:
    """Return (fault, value) of an entry of a published file.

    Strengths are scaled so that the published suite's become the strengths of our suites, since image size, noise and
    network differ.

    >>> _translate("image_shift", "/managed_subsystem/sensor_fusion", "parameter_adaptation", 150)
    ('image_shift', 5)
    """
    if kind != "parameter_adaptation":
        raise ScenarioError(f"The type of {name} must be parameter_adaptation, got {kind!r}.")
    fault = get_fault(_RENAMED.get(name, name))
    if base_name(target_node) != fault.node:
        raise ScenarioError(
            f"The fault {name} must have the target_node /managed_subsystem/{fault.node}, "
            f"got {target_node!r}."
        )
    published, ours = _PUBLISHED_STRENGTHS.get(fault.name), fault.value
    if published is None or isinstance(value, bool | str) or isinstance(ours, bool | str):
        return fault.name, value
    if not 0 <= value <= _LARGEST:
        return fault.name, value  # the scenario refuses it, and quotes the file's number
    scaled = ours * value / published
    return fault.name, round(scaled) if isinstance(ours, int) else scaled


def _published(root: Item, source: str) -> Scenario:
    faults = []
    for item in root.items():
        fields = item.mapping(required=_REQUIRED_KEYS, optional=_IGNORED_KEYS)
        name, target, kind = (fields[key].text() for key in ("name", "target_node", "type"))
        value = fields["value"].value()
        with item.located():
            faults.append(ScenarioFault(*_translate(name, target, kind, value)))
    with root.located():
        return Scenario(name=Path(source).stem, faults=tuple(faults))
