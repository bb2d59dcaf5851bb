"""The managed system as a value: its parts, as an extension adds them, and the tables that follow from them."""

from collections.abc import Callable, Iterable, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from types import MappingProxyType
from typing import Annotated, Any, Protocol, TypeAlias, TypeVar, get_args, get_origin

from msgspec import Meta

from sunset.errors import ExtensionError
from sunset.files.schemas import convert, fields_of
from sunset.system.description import (
    Adaptation,
    AdaptationKind,
    Failure,
    Fault,
    FaultKind,
    ImageFunction,
    KindOfAdaptation,
    Name,
    NodeDescription,
    Signal,
    Topic,
    View,
    redeploy,
    restart,
)
from sunset.system.harness import (
    COMMANDS_TOPIC,
    DIAGNOSTICS_TOPIC,
    HARNESS,
    OFF_LIMITS_TOPICS,
    PARAMETER_EVENTS_TOPIC,
    SENSOR_TOPICS,
)
from sunset.system.names import FAULT_ACCESS, full_name
from sunset_ros.texts import shorten

Suite: TypeAlias = Annotated[
    tuple[tuple[str, ...], ...] | str, Meta(description="tuples of faults or a YAML text")
]
"""Scenarios, each the faults that are injected together, as `fault` or `fault=value`; or a YAML list of scenarios."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Extension:
    """A part of a managed system, such as the parts that a file adds to the paper's.

    Attributes:
        nodes: managed nodes.
        node_classes: node of another part → the class that runs in place of its own, a subclass of it.
        topics: topics that the monitor watches.
        signals: numbers that nodes report.
        failures: how faults show.
        faults: causes of failures.
        adaptations: adaptations to offer besides the restart and the redeploy of every node and the steps of cures.
        exclusive: pairs of faults that cannot be there at the same time: each would be the other's cure.
        views: the values of the parameter that chooses the sensors of the pipeline; the first has all of them.
        suites: name → its scenarios, each the faults that are injected together, as `fault` or `fault=value`; or a YAML
            text, a list of scenarios as in scenario files, whose names lack the suite's name.
        prices: kind of adaptation → its price in `utility`, in frames of healthy output.
    """

    nodes: tuple[NodeDescription, ...] = ()
    node_classes: Mapping[str, type] = field(default_factory=dict)
    topics: tuple[Topic, ...] = ()
    signals: tuple[Signal, ...] = ()
    failures: tuple[Failure, ...] = ()
    faults: tuple[Fault, ...] = ()
    adaptations: tuple[Adaptation, ...] = ()
    exclusive: tuple[tuple[str, str], ...] = ()
    views: tuple[View, ...] = ()
    suites: Mapping[Name, Suite] = field(default_factory=dict)
    prices: Mapping[KindOfAdaptation, Annotated[float, Meta(ge=0, le=100_000)]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, kind in fields_of(Extension).items():
            values, item = getattr(self, name), get_args(kind)[0]
            if get_origin(kind) is not tuple:
                where = f"the {name} of an extension"
                convert(values, kind, where, ExtensionError, remedy="change it there")
                continue
            item = get_origin(item) or item
            if not isinstance(values, tuple | list) or not all(isinstance(value, item) for value in values):
                raise ExtensionError(
                    f"The {name} of an extension must be a tuple of {item.__name__}, got {shorten(repr(values), 100)}."
                )

        for name, scenarios in self.suites.items():
            if any(isinstance(scenario, AbstractSet) for scenario in (scenarios, *scenarios)):
                raise ExtensionError(
                    f"The suite {name} must be tuples of faults: a set does not have an order."
                )

    @property
    def named_adaptations(self) -> tuple[Adaptation, ...]:
        """The adaptations that it offers, of its views, and of its faults' injections and cures."""
        steps = (step for fault in self.faults for steps in (fault.injection, *fault.cures) for step in steps)
        return (*self.adaptations, *(view.setting for view in self.views), *steps)


class _Named(Protocol):
    @property
    def name(self) -> str: ...


NamedT = TypeVar("NamedT", bound=_Named)


class System:
    """A managed system.

    Args:
        *parts: the paper's part and extensions of it.

    Raises:
        ExtensionError: parts contradict each other. Other attributes raise it, too; `check_system` reads all of them.
    """

    def __init__(self, *parts: Extension) -> None:
        self.parts = parts
        self.nodes = _by_name("node", (node for part in parts for node in part.nodes))
        """The managed nodes, by name."""
        self.topics = _by_name("topic", (topic for part in parts for topic in part.topics))
        """The topics that the monitor watches, by name."""
        self.signals = _by_name("signal", (signal for part in parts for signal in part.signals))
        """The signals, by name."""
        self.failures = _by_name("failure", (failure for part in parts for failure in part.failures))
        """The failures, by name."""
        self.faults = _by_name("fault", (fault for part in parts for fault in part.faults))
        """The faults, by name."""
        self.exclusive = tuple(pair for part in parts for pair in part.exclusive)
        """Pairs of faults that cannot be there at the same time: each would be the other's cure."""
        self.views = tuple(view for part in parts for view in part.views)
        """The values of the parameter that chooses the sensors of the pipeline."""
        self.outages = frozenset(failure.name for failure in self.failures.values() if failure.topic)
        """The failures in which a topic stops."""
        self.initial_states = {node.name: node.initial_state for node in self.nodes.values()}
        """Node → its lifecycle state in a healthy system."""
        self.managed_nodes = frozenset(map(full_name, self.nodes))
        """The full names of the managed nodes."""
        self.all_nodes = self.managed_nodes | {f"/{name}" for name in HARNESS}
        """The full names of the managed nodes and of the experiment's own."""
        self.compute_s = {node.name: node.compute_s for node in self.nodes.values() if node.compute_s}
        """Node → time that a callback of an input takes in the simulation [s]."""

    @cached_property
    def adaptations(self) -> tuple[Adaptation, ...]:
        """Every adaptation that the system offers, each once."""
        steps = (step for fault in self.faults.values() for cure in fault.cures for step in cure)
        offered = [
            *(restart(node) for node in self.nodes),
            *(redeploy(node) for node in self.nodes),
            *(adaptation for part in self.parts for adaptation in part.adaptations),
            *(view.setting for view in self.views),
            *steps,
        ]
        return tuple(dict.fromkeys(offered))

    def price(self, kind: str) -> float:
        """Return the price of an adaptation in frames; other lifecycle transitions cost as much as an activation."""
        prices = {str(kind): price for part in self.parts for kind, price in part.prices.items()}
        return prices.get(kind, prices[AdaptationKind.ACTIVATE])

    @cached_property
    def suites(self) -> Mapping[str, Suite]:
        """Name → its scenarios, each the faults that are injected together; or a YAML text."""
        suites: dict[str, Suite] = {}
        for part in self.parts:
            for name, scenarios in part.suites.items():
                if name in suites:
                    raise _taken_error("suite", name)
                suites[name] = scenarios if isinstance(scenarios, str) else tuple(map(tuple, scenarios))
        return suites

    @cached_property
    def publishers(self) -> Mapping[str, str]:
        """Full name of a topic → the managed node that publishes on it."""
        publishers: dict[str, str] = {}
        for node in self.nodes.values():
            for topic in map(full_name, node.outputs):
                if topic in publishers or topic in _RESERVED_TOPICS:
                    raise _taken_error("topic", topic)
                publishers[topic] = node.name
        return publishers

    @cached_property
    def inputs(self) -> Mapping[str, frozenset[str]]:
        """Node → full names of the topics that it may subscribe to, before or after an adaptation."""
        inputs = {node.name: {*map(full_name, node.inputs)} for node in self.nodes.values()}
        for adaptation in self.adaptations:
            if adaptation.kind is AdaptationKind.CHANGE_TOPIC:
                inputs[adaptation.node].add(full_name(str(adaptation.value)))
        return {node: frozenset(topics) for node, topics in inputs.items()}

    @cached_property
    def upstream(self) -> Mapping[str, frozenset[str]]:
        """Node → the nodes that its input may come from, directly or through other nodes."""
        direct = {
            node: {self.publishers[topic] for topic in topics if topic in self.publishers}
            for node, topics in self.inputs.items()
        }
        try:
            order = tuple(TopologicalSorter(direct).static_order())
        except CycleError as error:
            raise ExtensionError(
                f"The wiring of the nodes has a cycle: {' feeds '.join(error.args[1])}."
            ) from error
        upstream: dict[str, frozenset[str]] = {}
        for node in order:
            upstream[node] = frozenset(direct[node]).union(*(upstream[other] for other in direct[node]))
        return upstream

    @cached_property
    def failing_nodes(self) -> Mapping[str, str]:
        """Failure → the node that publishes its topic or reports its signal."""
        return {
            failure.name: self.publishers[full_name(failure.topic)]
            if failure.topic
            else self.signals[failure.signal].node
            for failure in self.failures.values()
        }

    @cached_property
    def own_topics(self) -> frozenset[str]:
        """Full names of the topics on which only the managed system and the experiment publish."""
        return frozenset({DIAGNOSTICS_TOPIC, *_HARNESS_TOPICS, *self.publishers})

    @cached_property
    def sensors(self) -> Mapping[str, frozenset[str]]:
        """Sensor topic → full names of the nodes that may subscribe to it; others would bypass the sensors' faults."""
        return {
            topic: frozenset(full_name(node) for node, inputs in self.inputs.items() if topic in inputs)
            for topic in SENSOR_TOPICS
        }

    @cached_property
    def topic_parameters(self) -> frozenset[tuple[str, str]]:
        """The parameters that name a topic to subscribe to, as (node, parameter)."""
        return frozenset(
            (adaptation.node, adaptation.parameter)
            for adaptation in self.adaptations
            if adaptation.kind is AdaptationKind.CHANGE_TOPIC
        )

    @cached_property
    def fault_parameters(self) -> frozenset[tuple[str, str]]:
        """The parameters that exist only for injecting faults, as (full node name, parameter)."""
        return frozenset(
            (full_name(step.node), step.parameter)
            for fault in self.faults.values()
            if fault.kind is not FaultKind.CONFIGURATION
            for step in fault.injection
            if step.parameter
        ).union((full_name(node), FAULT_ACCESS) for node in self.nodes)

    def node_class(self, name: str) -> type:
        """Return the class of a managed node, or of a node of the harness that has a process.

        If several extensions replace the class of a node, it is the last subclass.
        """
        replaced = [part.node_classes[name] for part in self.parts if name in part.node_classes]
        if replaced:
            return max(replaced, key=lambda node_class: len(node_class.__mro__))
        place = (self.nodes.get(name) or HARNESS[name]).node_class
        node_class: type = _imported(place, f"The class {place} of the node {name}")
        return node_class

    def image_function(self, function: ImageFunction) -> Callable[..., Any]:
        """Return a function of a fault's effect."""
        imported: Callable[..., Any] = _imported(function, f"The function {function} of a fault's effect")
        return imported


def _imported(place: object, label: str) -> Any:
    """Return the class or function at `module:name`, or one that is given as such."""
    if not isinstance(place, str):
        return place
    module, _, name = place.partition(":")
    try:
        return getattr(import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ExtensionError(f"{label} cannot be imported: {error}.") from error


_HARNESS_TOPICS = frozenset(topic for node in HARNESS.values() for topic in node.outputs)
_SHARED_TOPICS = {DIAGNOSTICS_TOPIC, PARAMETER_EVENTS_TOPIC, "/rosout"}
_RESERVED_TOPICS = _HARNESS_TOPICS | _SHARED_TOPICS | {*OFF_LIMITS_TOPICS, COMMANDS_TOPIC}


def _by_name(kind: str, values: Iterable[NamedT]) -> Mapping[str, NamedT]:
    named: dict[str, NamedT] = {}
    for value in values:
        if value.name in named:
            raise _taken_error(kind, value.name)
        named[value.name] = value
    return MappingProxyType(named)


def _taken_error(kind: str, name: str) -> ExtensionError:
    return ExtensionError(f"The name of the {kind} {name!r} is taken: choose another.")
