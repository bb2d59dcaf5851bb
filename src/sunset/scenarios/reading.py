"""Reading scenarios from YAML, in our format and in the published exemplar's; errors name the line."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Final, TypeVar

import yaml

from sunset.errors import MALFORMED_YAML, InvalidInputError, ScenarioError
from sunset.flights import KEYS, FlightSpec
from sunset.scenarios.schema import After, Profile, Scenario, ScenarioFault, problems
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

_T = TypeVar("_T")


@dataclass(frozen=True)
class Item:
    """A part of a YAML document, with its line and its key in a mapping."""

    source: str
    loader: yaml.SafeLoader
    node: yaml.Node
    key: str = ""

    @property
    def is_scalar(self) -> bool:
        """Whether it is a single value."""
        return isinstance(self.node, yaml.ScalarNode)

    def error(self, problem: str) -> ScenarioError:
        """Return an exception that names the file and the line."""
        return ScenarioError(f"{self.source}, line {self.node.start_mark.line + 1}: {problem}")

    def make(self, kind: Callable[..., _T], /, **values: object) -> _T:
        """Return `kind(**values)`, whose errors get the file and the line."""
        try:
            return kind(**values)
        except InvalidInputError as error:
            raise self.error(str(error)) from error

    def items(self) -> list["Item"]:
        """Return the entries of a list."""
        if not isinstance(self.node, yaml.SequenceNode):
            raise self._type_error("a list")
        return [replace(self, node=node, key="") for node in self.node.value]

    def mapping(self, required: tuple[str, ...], optional: tuple[str, ...] = ()) -> dict[str, "Item"]:
        """Return the entries of a mapping that must have the `required` keys and may have the others."""
        if not isinstance(self.node, yaml.MappingNode):
            raise self._type_error(f"a mapping with {', '.join(required or optional)}")
        fields: dict[str, Item] = {}
        for key_node, node in self.node.value:
            key = replace(self, node=key_node)
            # the text of the file, since YAML takes the key on for a truth value
            name = key_node.value if key.is_scalar else str(key.value())
            if name not in (*required, *optional):
                allowed = ", ".join((*required, *optional))
                raise key.error(f"the key {name!r} is not known here; there are {allowed}.")
            if name in fields:
                raise key.error(f"the key {name!r} is given twice.")
            fields[name] = replace(self, node=node, key=name)
        for name in required:
            if name not in fields:
                raise self.error(f"the key {name!r} is missing.")
        return fields

    def read(
        self,
        kind: Callable[..., _T],
        required: tuple[str, ...],
        optional: tuple[str, ...] = (),
        **parts: Callable[["Item"], object],
    ) -> _T:
        """Return a value that is made of the entries of a mapping; `parts` read entries that are not single values."""
        fields = self.mapping(required, optional)
        return self.make(kind, **{key: parts.get(key, Item.value)(field) for key, field in fields.items()})

    def value(self) -> object:
        """Return a single value, such as a number or a text."""
        if not isinstance(self.node, yaml.ScalarNode):
            raise self._type_error("a truth value, a number or a text")
        try:
            value: object = self.loader.construct_object(self.node)
        except (yaml.YAMLError, *MALFORMED_YAML) as error:
            raise self.error(f"{self.node.value!r} is not a value that a fault can have.") from error
        return value

    def _type_error(self, expected: str) -> ScenarioError:
        kinds: dict[type[yaml.Node], str] = {yaml.MappingNode: "a mapping", yaml.SequenceNode: "a list"}
        got = kinds.get(type(self.node)) or (repr(self.node.value) if self.node.value else "nothing")
        place = f"for {self.key!r}" if self.key else "here"
        return self.error(f"{expected} is expected {place}, got {got}.")


def parse_yaml(text: str, source: str) -> Item:
    """Parse a YAML text of exactly one document with the safe loader.

    Args:
        text: the YAML text.
        source: the file's name, for messages.
    """
    try:
        loader = yaml.SafeLoader(text)
        node = loader.get_single_node()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f", line {mark.line + 1}" if mark else ""
        problem = error.problem or error.context or "it cannot be parsed"
        raise ScenarioError(f"{source}{line}: this is not valid YAML: {problem}.") from error
    except yaml.YAMLError as error:
        raise ScenarioError(f"{source}: this is not valid YAML: {str(error).splitlines()[0]}.") from error
    except RecursionError as error:
        raise ScenarioError(f"{source}: this is not a scenario: it is nested too deeply.") from error
    if node is None:
        raise ScenarioError(f"{source} is empty; a scenario has a name and a list of faults.")
    return Item(source, loader, node)


def parse_scenario(text: str, source: str) -> Scenario:
    """Parse a scenario in our format or in the published exemplar's.

    Args:
        text: the YAML text.
        source: its file, for messages; its stem names a scenario of the published format.

    Raises:
        ScenarioError: it is not valid YAML or not a scenario; the message names source and line.
    """
    root = parse_yaml(text, source)
    return _published(root, source) if isinstance(root.node, yaml.SequenceNode) else _ours(root)


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
    fields = root.mapping(("name", "faults"), ("description", "duration", "flight"))
    items = fields["faults"].items()
    faults = tuple(map(_fault, items))
    values = {key: fields[key].value() for key in ("name", "description") if key in fields}
    flight = _flight(fields["flight"]) if "flight" in fields else None
    scenario = root.make(Scenario, **values, flight=flight)
    if duration := fields.get("duration"):
        scenario = duration.make(partial(replace, scenario), duration=duration.value())
    for number, problem in problems(faults, scenario.duration):
        raise items[number].error(problem)
    return replace(scenario, faults=faults)


def _fault(item: Item) -> ScenarioFault:
    if item.is_scalar:
        return item.make(ScenarioFault, name=item.value())
    optional = ("value", "at", "until", "profile", "after", "severity")
    return item.read(ScenarioFault, ("name",), optional, profile=_profile, after=_after)


def _profile(item: Item) -> Profile:
    if item.is_scalar:
        return item.make(Profile, kind=item.value())
    return item.read(Profile, ("kind",), ("rise", "on", "off"))


def _after(item: Item) -> After:
    return item.read(After, ("fault", "delay"))


def _flight(item: Item) -> FlightSpec:
    values = {key: field.value() for key, field in item.mapping((), KEYS).items()}
    if isinstance(bag := values.get("bag"), str):
        values["bag"] = str(Path(item.source).parent / bag)
    return item.make(FlightSpec.of, conditions=values)


def _translate(name: str, target: str, kind: str, value: Value) -> ScenarioFault:
    """Return the fault of an entry of a published file.

    Strengths are scaled so that the published suite's become the strengths of our suites, since image size, noise and
    network differ.

    >>> _translate("image_shift", "/managed_subsystem/sensor_fusion", "parameter_adaptation", 150).value
    5
    """
    if kind != "parameter_adaptation":
        raise ScenarioError(f"The type of {name} must be parameter_adaptation, got {kind!r}.")
    fault = get_fault(_RENAMED.get(name, name))
    if base_name(target) != fault.node:
        raise ScenarioError(
            f"The fault {name} must have the target_node /managed_subsystem/{fault.node}, got {target!r}."
        )
    published, ours = _PUBLISHED_STRENGTHS.get(fault.name), fault.value
    if published is None or isinstance(value, bool | str) or isinstance(ours, bool | str):
        return ScenarioFault(fault.name, value)
    if 0 <= value <= _LARGEST:  # of another value, the error quotes the file's number
        scaled = ours * value / published
        value = round(scaled) if isinstance(ours, int) else scaled
    return ScenarioFault(fault.name, value)


def _published(root: Item, source: str) -> Scenario:
    faults = []
    for item in root.items():
        fields = item.mapping(_REQUIRED_KEYS, _IGNORED_KEYS)
        texts = [str(fields[key].value()) for key in ("name", "target_node", "type")]
        faults.append(item.make(partial(_translate, *texts), value=fields["value"].value()))
    return root.make(Scenario, name=Path(source).stem, faults=tuple(faults))
