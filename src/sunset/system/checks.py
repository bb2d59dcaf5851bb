"""Checks that the parts of a managed system fit each other; each mistake is an `ExtensionError` of one sentence."""

from collections.abc import Iterable, Mapping
from itertools import chain
from math import inf
from typing import Final, TypeVar

from sunset.errors import ExtensionError
from sunset.system.description import (
    Adaptation,
    AdaptationKind,
    Fault,
    FaultKind,
    redeploy,
    restart,
)
from sunset.system.harness import RESERVED_NAMES, SENSOR_TOPICS
from sunset.system.names import full_name
from sunset.system.system import Extension, System
from sunset_ros.texts import suggestion

_PAIR: Final = 2

ItemT = TypeVar("ItemT")


def check_system(system: System) -> None:
    """Check that the parts of a system refer to parts that are there, and do not contradict each other."""
    _check_nodes(system)
    for adaptation in system.adaptations:
        _check_adaptation(adaptation, system)
    _check_views(system)
    _check_signals(system)
    _check_failures(system)
    for fault in system.faults.values():
        _check_fault(fault, system)
        _check_effect(fault, system)
    _check_suites(system)


def check_extension(part: Extension, system: System, before: System) -> None:
    """Check the classes, functions and signals of a system's new part.

    Args:
        part: the extension.
        system: the system with it.
        before: the system without it.
    """
    for signal in part.signals:
        if signal.calibrated:
            raise ExtensionError(
                f"The signal {signal.name} needs a threshold of its own: model cards lack it."
            )
    _check_classes(part, system, before)
    for fault in part.faults:
        if fault.effect:
            system.image_function(fault.effect.degrade)
            system.image_function(fault.effect.restore or fault.effect.degrade)
    for adaptation in part.named_adaptations:
        _check_parameter(adaptation, system.node_class(adaptation.node))
    for fault in part.faults:
        _check_fault_parameter(fault, system.node_class(fault.node))


def _check_classes(part: Extension, system: System, before: System) -> None:
    for name, node_class in part.node_classes.items():
        _known("node", name, system.nodes, "A class in node_classes")
        present = before.node_class(name)
        if not issubclass(node_class, present):
            raise ExtensionError(
                f"The class of the node {name} is {present.__name__}: {node_class.__name__} must be a subclass of it, "
                "or be left out."
            )
    for node in part.nodes:
        node_name = getattr(system.node_class(node.name), "node_name", None)
        if node_name != node.name:
            raise ExtensionError(
                f"The class of the node {node.name} must have its node_name, got {node_name!r}."
            )


def _check_nodes(system: System) -> None:
    published = {*system.publishers, *SENSOR_TOPICS}
    for node in system.nodes.values():
        if node.name in RESERVED_NAMES:
            raise ExtensionError(f"The node name {node.name!r} is the experiment's own: choose another.")
        _check_published(node.inputs, published)
    _check_published(system.topics, published)


def _check_published(topics: Iterable[str], published: Iterable[str]) -> None:
    for topic in map(full_name, topics):
        if topic not in published:
            raise ExtensionError(
                f"No node publishes on the topic {topic}: {suggestion(topic, published)}"
                f"add {topic} to the outputs of a node."
            )


def _check_adaptation(adaptation: Adaptation, system: System) -> None:
    _known("node", adaptation.node, system.nodes, f"The adaptation {str(adaptation)!r}")
    sets = adaptation.kind in {AdaptationKind.SET_PARAMETER, AdaptationKind.CHANGE_TOPIC}
    if sets != bool(adaptation.parameter):
        raise ExtensionError(
            f"The adaptation {str(adaptation)!r} must {'' if sets else 'not '}name a parameter, got "
            f"{adaptation.parameter!r}."
        )
    if adaptation.kind is AdaptationKind.CHANGE_TOPIC:
        _check_published([str(adaptation.value)], {*system.publishers, *SENSOR_TOPICS})


def _check_views(system: System) -> None:
    sensors = {
        name: node for name, node in system.nodes.items() if node.outputs and not system.upstream[name]
    }
    parameters = {f"{view.setting.node}.{view.setting.parameter}": None for view in system.views}
    if len(parameters) > 1:
        raise ExtensionError(f"All views must be values of one parameter, got {' and '.join(parameters)}.")
    values = [view.setting.value for view in system.views]
    if None in values or len({*values}) < len(values):
        raise ExtensionError(f"Each view must have a value of its own, got {', '.join(map(str, values))}.")
    for view in system.views:
        for sensor in sorted(view.sensors):
            _known("sensor", sensor, sensors, f"The view {str(view.setting)!r}")


def _check_signals(system: System) -> None:
    names: dict[str, str] = {}
    for signal in system.signals.values():
        _known("node", signal.node, system.nodes, f"The signal {signal.name}")
        if signal.has_threshold and names.setdefault(signal.threshold_name, signal.name) != signal.name:
            raise ExtensionError(
                f"The signals {names[signal.threshold_name]} and {signal.name} have thresholds of the same name, "
                f"{signal.threshold_name}: choose another key."
            )


def _check_failures(system: System) -> None:
    active = {topic for topic, node in system.publishers.items() if system.initial_states[node] == "active"}
    stopping = active.intersection(map(full_name, system.topics))
    for failure in system.failures.values():
        label = f"The failure {failure.name}"
        if bool(failure.topic) == bool(failure.signal):
            raise ExtensionError(
                f"{label} must name either a topic that stops or a signal that is off, got "
                f"{failure.topic!r} and {failure.signal!r}."
            )
        if failure.topic and full_name(failure.topic) not in stopping:
            raise ExtensionError(
                f"{label} is of the topic {failure.topic}: add it to the topics that are watched, and to the outputs "
                "of a node that is active at first."
            )
        if failure.signal and not _known("signal", failure.signal, system.signals, label).has_threshold:
            raise ExtensionError(f"{label} needs a threshold of the signal {failure.signal}.")


def _check_fault(fault: Fault, system: System) -> None:
    label = f"The fault {fault.name}"
    _known("failure", fault.failure, system.failures, label)
    _known("node", fault.node, system.nodes, label)
    for step in fault.injection:
        _known("node", step.node, system.nodes, label)
        if not step.parameter and step.kind is not AdaptationKind.ACTIVATE:
            raise ExtensionError(
                f"{label} cannot be injected by {str(step)!r}: set a parameter, or activate a node."
            )
    if type(fault.healthy) is not type(fault.value) or fault.healthy == fault.value:
        raise ExtensionError(
            f"{label} needs a value and another value of the same type when healthy, got {fault.value!r} and "
            f"{fault.healthy!r}."
        )
    is_number = not isinstance(fault.value, bool | str)
    if is_number != (fault.limits is not None):
        raise ExtensionError(
            f"{label} needs limits if its value is a number, and only then, got {fault.value!r} and {fault.limits}."
        )
    if fault.limits and is_number and not fault.limits[0] <= float(fault.value) <= fault.limits[1]:
        raise ExtensionError(f"{label} needs a value within its limits {fault.limits}, got {fault.value!r}.")
    if fault.kind is FaultKind.INTERNAL and (redeploy(fault.node),) not in fault.cures:
        raise ExtensionError(
            f"{label} is internal to {fault.node}, so that a redeploy of it ends it: add that to the cures, or say "
            "another kind."
        )


def _check_effect(fault: Fault, system: System) -> None:
    effect = fault.effect
    if effect is None:
        return
    label = f"The effect of the fault {fault.name}"
    signal = system.signals.get(system.failures[fault.failure].signal)
    if signal is None or not signal.calibrated:
        raise ExtensionError(
            f"{label} can be measured only if its failure is of a signal whose threshold the model's card has."
        )
    if (effect.suite is None) != (fault.limits is not None):
        raise ExtensionError(
            f"{label} needs the strength in the suites if the fault's value is not a number, and only then, got "
            f"{effect.suite!r}."
        )
    if isinstance(effect.suite, str):
        _known("fault", effect.suite, system.faults, label)
    low, high = fault.limits or (0.0, effect.largest)
    for strength in effect.strengths:
        if not low < strength <= high:
            raise ExtensionError(
                f"{label} needs strengths greater than {low:g} and at most {high:g}, got {strength!r}."
            )


def _check_suites(system: System) -> None:
    for pair in system.exclusive:
        if len({*pair}) != _PAIR or len(pair) != _PAIR:
            raise ExtensionError(f"Exclusive faults come in pairs of two names, got {pair!r}.")
        for name in pair:
            _known("fault", name, system.faults, f"The pair of exclusive faults {pair}")
    for suite, scenarios in system.suites.items():
        if not scenarios:
            raise ExtensionError(f"The suite {suite} has no scenario.")
        if not isinstance(scenarios, str):  # a text is checked when it is read, which takes a while
            for text in chain(*scenarios):
                _known("fault", text.partition("=")[0], system.faults, f"The suite {suite}")


def _check_parameter(adaptation: Adaptation, node_class: type) -> None:
    """Check that a node's class has the parameter that an adaptation sets, if any, and takes the value."""
    if not adaptation.parameter:
        return
    label = f"the parameter {adaptation.parameter!r}"
    parameter: object = getattr(node_class, adaptation.parameter, None)
    default = getattr(parameter, "default", None)
    if default is None:
        raise ExtensionError(
            f"The class {node_class.__name__} of the node {adaptation.node} does not have {label}: "
            f"{suggestion(adaptation.parameter, vars(node_class))}add it there, or name another (a fault's parameter "
            "has the fault's name unless it says parameter=...)."
        )
    value = adaptation.value
    if type(value) is not type(default):
        raise ExtensionError(
            f"The class {node_class.__name__} has {label} of type {type(default).__name__}, got {value!r}: write a "
            f"value such as {default!r}."
        )
    low, high = (getattr(parameter, name, None) for name in ("minimum", "maximum"))
    at_least, at_most = -inf if low is None else low, inf if high is None else high
    if isinstance(value, int | float) and not at_least <= value <= at_most:
        raise ExtensionError(
            f"The class {node_class.__name__} takes for {label} values from {low} to {high}, got {value!r}: change "
            "either."
        )


def _check_fault_parameter(fault: Fault, node_class: type) -> None:
    """Check that the class of a fault's node takes all its strengths, starts healthy, and agrees on restarts."""
    if (fault.node, fault.parameter) not in [(step.node, step.parameter) for step in fault.injection]:
        return
    for value in fault.limits or ():
        strength = type(fault.value)(value)
        _check_parameter(
            Adaptation(AdaptationKind.SET_PARAMETER, fault.node, fault.parameter, strength), node_class
        )
    parameter = getattr(node_class, fault.parameter, None)
    default = getattr(parameter, "default", fault.healthy)
    if default != fault.healthy:
        raise ExtensionError(
            f"The fault {fault.name} is healthy at {fault.healthy!r}, and the parameter {fault.parameter!r} of the "
            f"class {node_class.__name__} begins with {default!r}: say healthy={default!r} in the Fault."
        )
    is_cure = (restart(fault.node),) in fault.cures
    if getattr(parameter, "cured_by_restart", is_cure) != is_cure:
        raise ExtensionError(
            f"A restart of {fault.node} {'is a' if is_cure else 'is not a'} cure of the fault {fault.name}: say "
            f"cured_by_restart={is_cure} for the parameter {fault.parameter!r} of the class {node_class.__name__}, "
            "or change the cures."
        )


def _known(kind: str, name: str, items: Mapping[str, ItemT], label: str) -> ItemT:
    if name not in items:
        raise ExtensionError(
            f"{label} refers to the {kind} {name!r}, which is not there: {suggestion(name, items)}name one of "
            f"{', '.join(items) or 'none'}."
        )
    return items[name]
