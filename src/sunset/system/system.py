"""The managed system as one value: its parts, and what follows from them."""

from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from types import MappingProxyType
from typing import Any, Protocol, TypeVar

from sunset.errors import ExtensionError, ScenarioError
from sunset.system.checks import (
    check_adaptation,
    check_effect,
    check_failures,
    check_fault,
    check_node_classes,
    check_nodes,
    check_scenarios,
    check_signals,
    check_topics,
    check_views,
)
from sunset.system.description import (
    Adaptation,
    AdaptationKind,
    Failure,
    Fault,
    FaultKind,
    ImageFunction,
    NodeDescription,
    Signal,
    Topic,
    View,
    redeploy,
    restart,
)
from sunset.system.extension import Extension
from sunset.system.harness import (
    COMMANDS_TOPIC,
    DIAGNOSTICS_TOPIC,
    HARNESS,
    OFF_LIMITS_TOPICS,
    PARAMETER_EVENTS_TOPIC,
    SENSOR_TOPICS,
)
from sunset.system.names import FAULT_ACCESS, full_name
from sunset.system.suites import Suite
from sunset.texts import suggestion


class _Named(Protocol):
    @property
    def name(self) -> str: ...


NamedT = TypeVar("NamedT", bound=_Named)


class System:
    """A managed system.

    Args:
        *parts: what it is made of; a later part may refer to an earlier one.

    Raises:
        ExtensionError: a name is taken, or a part refers to what is not there.
    """

    def __init__(self, *parts: Extension) -> None:
        self.parts = parts
        check_nodes(self.nodes, self.publishers)
        for part in parts:
            check_node_classes(part.node_classes, self.nodes)
        published = {*self.publishers, *SENSOR_TOPICS}
        check_topics(map(full_name, self.topics), published)
        for adaptation in self.adaptations:
            check_adaptation(adaptation, self.nodes, published)
        check_views(self.views, self.nodes, self.upstream)  # raises if there is a cycle
        check_signals(self.signals.values(), self.nodes)
        active = {topic for topic, node in self.publishers.items() if self.initial_states[node] == "active"}
        stopping = active.intersection(map(full_name, self.topics))
        check_failures(self.failures.values(), self.signals, stopping)
        for fault in self.faults.values():
            check_fault(fault, self.nodes, self.failures)
            check_effect(fault, self.faults, self.signals.get(self.failures[fault.failure].signal))
        check_scenarios(self.suites, self.exclusive, self.faults)

    @cached_property
    def nodes(self) -> Mapping[str, NodeDescription]:
        """The managed nodes, by name."""
        return _by_name("node", (node for part in self.parts for node in part.nodes))

    @cached_property
    def topics(self) -> Mapping[str, Topic]:
        """The topics that the monitor watches, by name."""
        return _by_name("topic", (topic for part in self.parts for topic in part.topics))

    @cached_property
    def signals(self) -> Mapping[str, Signal]:
        """The signals, by name."""
        return _by_name("signal", (signal for part in self.parts for signal in part.signals))

    @cached_property
    def failures(self) -> Mapping[str, Failure]:
        """The failures, by name."""
        return _by_name("failure", (failure for part in self.parts for failure in part.failures))

    @cached_property
    def faults(self) -> Mapping[str, Fault]:
        """The faults, by name."""
        return _by_name("fault", (fault for part in self.parts for fault in part.faults))

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
        """Return what an adaptation costs, in frames; any other lifecycle transition costs what an activation does."""
        return self._prices.get(kind, self._prices[AdaptationKind.ACTIVATE])

    @cached_property
    def _prices(self) -> Mapping[str, float]:
        return {kind: price for part in self.parts for kind, price in part.prices.items()}

    @cached_property
    def exclusive(self) -> tuple[tuple[str, str], ...]:
        """Pairs of faults that cannot be there at the same time: each would be the other's cure."""
        return tuple(pair for part in self.parts for pair in part.exclusive)

    @cached_property
    def views(self) -> tuple[View, ...]:
        """The values of the parameter that chooses the sensors which the pipeline works with."""
        return tuple(view for part in self.parts for view in part.views)

    @cached_property
    def suites(self) -> Mapping[str, Suite]:
        """Name → its scenarios, each the faults that are injected together; or a YAML text."""
        suites: dict[str, Suite] = {}
        for part in self.parts:
            for name, scenarios in part.suites.items():
                if name in suites:
                    raise _taken_error("suite", name)
                suites[name] = scenarios if isinstance(scenarios, str) else tuple(map(tuple, scenarios))
        return MappingProxyType(suites)

    @cached_property
    def publishers(self) -> Mapping[str, str]:
        """Full name of a topic → the managed node that publishes on it."""
        publishers: dict[str, str] = {}
        for node in self.nodes.values():
            for topic in map(full_name, node.outputs):
                if topic in publishers or topic in _RESERVED_TOPICS:
                    raise _taken_error("topic", topic)
                publishers[topic] = node.name
        return MappingProxyType(publishers)

    @cached_property
    def inputs(self) -> Mapping[str, frozenset[str]]:
        """Node → full names of the topics that it may subscribe to, by whatever adaptation."""
        inputs = {node.name: {*map(full_name, node.inputs)} for node in self.nodes.values()}
        for adaptation in self.adaptations:
            if adaptation.kind is AdaptationKind.CHANGE_TOPIC:
                inputs[adaptation.node].add(full_name(str(adaptation.value)))
        return MappingProxyType({node: frozenset(topics) for node, topics in inputs.items()})

    @cached_property
    def upstream(self) -> Mapping[str, frozenset[str]]:
        """Node → the nodes that its input may come from, however far up.

        Raises:
            ExtensionError: the wiring has a cycle.
        """
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
        return MappingProxyType(upstream)

    @cached_property
    def failing_nodes(self) -> Mapping[str, str]:
        """Failure → the node that fails: it publishes the topic, or reports the signal."""
        return MappingProxyType(
            {
                failure.name: self.publishers[full_name(failure.topic)]
                if failure.topic
                else self.signals[failure.signal].node
                for failure in self.failures.values()
            }
        )

    @cached_property
    def outages(self) -> frozenset[str]:
        """The failures that are a topic that has stopped."""
        return frozenset(failure.name for failure in self.failures.values() if failure.topic)

    @cached_property
    def initial_states(self) -> Mapping[str, str]:
        """Node → its lifecycle state when all is well."""
        return MappingProxyType({node.name: node.initial_state for node in self.nodes.values()})

    @cached_property
    def managed_nodes(self) -> frozenset[str]:
        """The full names of the managed nodes."""
        return frozenset(map(full_name, self.nodes))

    @cached_property
    def all_nodes(self) -> frozenset[str]:
        """The full names of all nodes that are not the managing system's."""
        return self.managed_nodes | {f"/{name}" for name in HARNESS}

    @cached_property
    def own_topics(self) -> frozenset[str]:
        """Full names of topics on which only the managed system and the experiment publish, as all below them."""
        return frozenset({DIAGNOSTICS_TOPIC, *_HARNESS_TOPICS, *self.publishers})

    @cached_property
    def sensors(self) -> Mapping[str, frozenset[str]]:
        """Sensor topic → full names of the nodes that may subscribe to it; others would bypass the sensors' faults."""
        return MappingProxyType(
            {
                topic: frozenset(full_name(node) for node, inputs in self.inputs.items() if topic in inputs)
                for topic in SENSOR_TOPICS
            }
        )

    @cached_property
    def topic_parameters(self) -> frozenset[tuple[str, str]]:
        """The parameters that name a topic which a node subscribes to, as (node, parameter)."""
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

    @cached_property
    def compute_s(self) -> Mapping[str, float]:
        """Node → time that a callback of an input takes in the simulation [s]."""
        return MappingProxyType({node.name: node.compute_s for node in self.nodes.values() if node.compute_s})

    def fault(self, name: str) -> Fault:
        """Return the fault of that name.

        Raises:
            ScenarioError: there is none; the message lists those that there are.
        """
        try:
            return self.faults[name]
        except KeyError:
            raise ScenarioError(
                f"There is no fault {name!r}: {suggestion(name, self.faults)}choose one of {', '.join(self.faults)}."
            ) from None

    def node_class(self, name: str) -> type:
        """Return the class of a managed node, or of one of the harness that a process runs.

        Of those that extensions put in the place of each other it is the last subclass.

        Raises:
            ExtensionError: it cannot be imported.
        """
        replaced = [part.node_classes[name] for part in self.parts if name in part.node_classes]
        if replaced:
            return max(replaced, key=lambda node_class: len(node_class.__mro__))
        found = (self.nodes.get(name) or HARNESS[name]).node_class
        if isinstance(found, type):
            return found
        imported: type = _imported(found, f"The class {found} of the node {name}")
        return imported

    def image_function(self, function: ImageFunction) -> Callable[..., Any]:
        """Return a function of a fault's effect.

        Raises:
            ExtensionError: it cannot be imported.
        """
        if not isinstance(function, str):
            return function
        imported: Callable[..., Any] = _imported(function, f"The function {function} of a fault's effect")
        return imported


def _imported(where: str, what: str) -> Any:
    """Return what stands at `module:name`."""
    module, _, attribute = where.partition(":")
    try:
        return getattr(import_module(module), attribute)
    except (ImportError, AttributeError, ValueError) as error:
        raise ExtensionError(f"{what} cannot be imported: {error}.") from error


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
