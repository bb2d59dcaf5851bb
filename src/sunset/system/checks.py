"""What the parts of a managed system must be, so that they fit each other; one sentence for each mistake."""

from collections.abc import Collection, Iterable, Mapping
from math import isfinite
from typing import Final, TypeVar, get_args

from sunset.errors import ExtensionError, ScenarioError
from sunset.system.class_checks import check_class, check_parameter
from sunset.system.description import (
    Adaptation,
    AdaptationKind,
    Effect,
    Failure,
    Fault,
    FaultKind,
    NodeDescription,
    Sensor,
    Signal,
    View,
    redeploy,
)
from sunset.system.harness import RESERVED_NAMES, SENSOR_TOPICS
from sunset.system.names import full_name, is_topic_name
from sunset.system.suites import Suite
from sunset.texts import suggestion

LONGEST_DELAY_S: Final = 3600.0
"""The longest time from a node's start until it activates itself [s]."""
_PAIR: Final = 2


def check_nodes(nodes: Mapping[str, NodeDescription], published: Collection[str]) -> None:
    """Check every node's name, class and inputs.

    Args:
        nodes: all of them, by name.
        published: full names of the topics that they publish on.

    Raises:
        ExtensionError: one is not as it must be.
    """
    for node in nodes.values():
        _check_name("node", node.name)
        if node.name in RESERVED_NAMES:
            raise ExtensionError(f"The node name {node.name!r} is the experiment's own: choose another.")
        is_reference = isinstance(node.node_class, str) and ":" in node.node_class
        if not is_reference and not isinstance(node.node_class, type):
            raise ExtensionError(
                f"The node {node.name} needs a class, or where that is as module:Class, got {node.node_class!r}."
            )
        if isinstance(node.node_class, type):
            check_class(node.name, node.node_class)
        for topic in node.outputs:
            if not is_topic_name(topic):
                raise ExtensionError(
                    f"The node {node.name} publishes on {topic!r}, which is not a topic's name such as rgb_camera."
                )
        check_topics(map(full_name, node.inputs), {*published, *SENSOR_TOPICS})
        if not -1 <= node.activation_delay_s <= LONGEST_DELAY_S or not 0 <= node.compute_s < 1:
            raise ExtensionError(
                f"The node {node.name} needs an activation_delay_s from 0 to {LONGEST_DELAY_S:g} s, or -1 for none, "
                f"and a compute_s from 0 to less than 1 s, got {node.activation_delay_s} and {node.compute_s}."
            )


def check_node_classes(node_classes: Mapping[str, type], nodes: Mapping[str, NodeDescription]) -> None:
    """Check the classes that run in place of nodes' own.

    Raises:
        ExtensionError: one is of a node that is not there, or of another node.
    """
    for name, node_class in node_classes.items():
        _known("node", name, nodes, "A class in node_classes")
        check_class(name, node_class)


def check_topics(named: Iterable[str], published: Collection[str]) -> None:
    """Check that topics are published.

    Args:
        named: full names of those that something refers to.
        published: full names of those that a node publishes on.

    Raises:
        ExtensionError: one is not.
    """
    for topic in named:
        if topic not in published:
            raise ExtensionError(
                f"No node publishes on the topic {topic}: {suggestion(topic, published)}"
                f"add {topic} to the outputs of a node."
            )


def check_adaptation(
    adaptation: Adaptation, nodes: Mapping[str, NodeDescription], published: Collection[str]
) -> None:
    """Check that a node can be adapted so.

    Raises:
        ExtensionError: it cannot.
    """
    what = f"The adaptation {str(adaptation)!r}"
    node = _known("node", adaptation.node, nodes, what)
    sets = adaptation.kind in {AdaptationKind.SET_PARAMETER, AdaptationKind.CHANGE_TOPIC}
    if sets != bool(adaptation.parameter):
        raise ExtensionError(
            f"{what} must {'' if sets else 'not '}name a parameter, got {adaptation.parameter!r}."
        )
    if isinstance(node.node_class, type):
        check_parameter(adaptation, node.node_class)
    if adaptation.kind is AdaptationKind.CHANGE_TOPIC:
        check_topics([full_name(str(adaptation.value))], published)


def check_views(
    views: Iterable[View], nodes: Mapping[str, NodeDescription], upstream: Mapping[str, Collection[str]]
) -> None:
    """Check that views are different values of one parameter, and of sensors that there are.

    Args:
        views: all of them.
        nodes: all of them, by name.
        upstream: node → the nodes that its input may come from.

    Raises:
        ExtensionError: a view is not.
    """
    parameters = {f"{view.setting.node}.{view.setting.parameter}": view for view in views}
    if len(parameters) > 1:
        raise ExtensionError(f"All views must be values of one parameter, got {' and '.join(parameters)}.")
    values = [view.setting.value for view in views]
    if None in values or len({*values}) < len(values):
        raise ExtensionError(f"Each view must have a value of its own, got {', '.join(map(str, values))}.")
    for view in views:
        for sensor in sorted(view.sensors):
            what = f"The view {str(view.setting)!r}"
            if not _known("node", sensor, nodes, what).outputs or upstream[sensor]:
                sensors = [name for name, node in nodes.items() if node.outputs and not upstream[name]]
                raise ExtensionError(
                    f"{what} names {sensor}, which is no sensor: name some of {', '.join(sensors)}."
                )


def check_signals(signals: Iterable[Signal], nodes: Mapping[str, NodeDescription]) -> None:
    """Check that nodes report signals under names that are not taken.

    Raises:
        ExtensionError: one does not.
    """
    names: dict[str, str] = {}
    for signal in signals:
        _check_name("signal", signal.key)
        _known("node", signal.node, nodes, f"The signal {signal.name}")
        if signal.threshold is not None and not isfinite(signal.threshold):
            raise ExtensionError(f"The threshold of {signal.name} must be finite, got {signal.threshold}.")
        if signal.has_threshold and names.setdefault(signal.threshold_name, signal.name) != signal.name:
            raise ExtensionError(
                f"The signals {names[signal.threshold_name]} and {signal.name} have thresholds of the same name, "
                f"{signal.threshold_name}: choose another key."
            )


def check_added_signals(signals: Iterable[Signal]) -> None:
    """Check that signals of an extension have thresholds of their own, if any: no model's card has one.

    Raises:
        ExtensionError: one has not.
    """
    for signal in signals:
        if signal.calibrated:
            raise ExtensionError(
                f"The signal {signal.name} needs a threshold of its own: a model's card has none of it."
            )


def check_failures(
    failures: Iterable[Failure], signals: Mapping[str, Signal], stopping: Collection[str]
) -> None:
    """Check that failures can be observed.

    Args:
        failures: the failures.
        signals: all of them, by name.
        stopping: full names of the topics that are watched and stop only if something is wrong.

    Raises:
        ExtensionError: one cannot.
    """
    for failure in failures:
        _check_name("failure", failure.name)
        what = f"The failure {failure.name}"
        if bool(failure.topic) == bool(failure.signal):
            raise ExtensionError(
                f"{what} must name either a topic that stops or a signal that is off, got "
                f"{failure.topic!r} and {failure.signal!r}."
            )
        if failure.topic and full_name(failure.topic) not in stopping:
            raise ExtensionError(
                f"{what} is of the topic {failure.topic}: add it to the topics that are watched, and to the outputs "
                "of a node that is active at first."
            )
        if failure.signal and not _known("signal", failure.signal, signals, what).has_threshold:
            raise ExtensionError(f"{what} needs a threshold of the signal {failure.signal}, which has none.")


def check_fault(fault: Fault, nodes: Mapping[str, NodeDescription], failures: Mapping[str, Failure]) -> None:
    """Check that a fault can be injected.

    Raises:
        ExtensionError: it cannot.
    """
    _check_name("fault", fault.name)
    what = f"The fault {fault.name}"
    _known("failure", fault.failure, failures, what)
    for step in fault.injection:
        node = _known("node", step.node, nodes, what)
        if isinstance(node.node_class, type):
            check_parameter(step, node.node_class)
        if not step.parameter and step.kind is not AdaptationKind.ACTIVATE:
            raise ExtensionError(
                f"{what} cannot be injected by {str(step)!r}: set a parameter, or activate a node."
            )
    _known("node", fault.node, nodes, what)
    if type(fault.healthy) is not type(fault.value) or fault.healthy == fault.value:
        raise ExtensionError(
            f"{what} needs a value and another one of the same type when healthy, got {fault.value!r} and "
            f"{fault.healthy!r}."
        )
    if isinstance(fault.value, bool | str):
        if fault.limits is not None:
            raise ExtensionError(
                f"{what} must have no limits, since its value {fault.value!r} is not a number, got {fault.limits}."
            )
    elif fault.limits is None:
        raise ExtensionError(f"{what} needs limits, since its value {fault.value!r} is a number.")
    elif not fault.limits[0] <= fault.value <= fault.limits[1]:
        raise ExtensionError(f"{what} needs a value within its limits {fault.limits}, got {fault.value!r}.")
    if fault.kind is FaultKind.INTERNAL and (redeploy(fault.node),) not in fault.cures:
        raise ExtensionError(
            f"{what} is internal to {fault.node}, so that a redeploy of it ends it: add that to the cures, or say "
            "another kind."
        )


def check_effect(fault: Fault, faults: Mapping[str, Fault], signal: Signal | None) -> None:
    """Check that what a fault does to images can be measured.

    Args:
        fault: the fault.
        faults: all of them, by name.
        signal: that it shows in; None if it shows as an outage.

    Raises:
        ExtensionError: it cannot.
    """
    effect = fault.effect
    if effect is None:
        return
    what = f"The effect of the fault {fault.name}"
    if signal is None or not signal.calibrated:
        raise ExtensionError(
            f"{what} can be measured only if its failure is of a signal whose threshold the model's card has."
        )
    if effect.sensor not in get_args(Sensor):
        raise ExtensionError(
            f"{what} must be on the sensor {' or '.join(get_args(Sensor))}, got {effect.sensor!r}."
        )
    for function in (effect.degrade, effect.restore or effect.degrade):
        if not callable(function) and not (isinstance(function, str) and ":" in function):
            raise ExtensionError(
                f"{what} must be a function, or where that is as module:function, got {function!r}."
            )
    if (effect.suite is None) != (fault.limits is not None):
        raise ExtensionError(
            f"{what} needs the strength in the suites if the fault's value is not a number, and only then, got "
            f"{effect.suite!r}."
        )
    _check_strengths(effect, fault.limits or (0.0, effect.largest), what)
    if isinstance(effect.suite, str):
        other = _known("fault", effect.suite, faults, what).effect
        if other is None or isinstance(other.suite, str):
            raise ExtensionError(f"{what} has the strength of {effect.suite}, which has none of its own.")


def check_scenarios(
    suites: Mapping[str, Suite],
    exclusive: Iterable[tuple[str, str]],
    faults: Mapping[str, Fault],
) -> None:
    """Check that suites and exclusive pairs are of faults that are there.

    Raises:
        ExtensionError: one is not.
    """
    for pair in exclusive:
        if len(pair) != len(set(pair)) or len(pair) != _PAIR:
            raise ExtensionError(f"Exclusive faults come in pairs of two names, got {pair!r}.")
        for name in pair:
            _known("fault", name, faults, f"The pair of exclusive faults {pair}")
    for suite, scenarios in suites.items():
        _check_name("suite", suite)
        if not scenarios:
            raise ExtensionError(f"The suite {suite} has no scenario.")
        # what stands in a text is checked when it is read, which takes a while
        for scenario in () if isinstance(scenarios, str) else scenarios:
            names = {_checked_name(text, faults, f"The suite {suite}") for text in scenario}
            for pair in exclusive:
                if names.issuperset(pair):
                    raise ExtensionError(
                        f"The suite {suite} has {' with '.join(pair)}, which exclude each other."
                    )


def _checked_name(text: str, faults: Mapping[str, Fault], what: str) -> str:
    """Check a fault of a scenario, `fault` or `fault=value`, and return its name."""
    name, separator, strength = text.partition("=")
    fault = _known("fault", name, faults, what)
    try:
        if separator:
            fault.checked(float(strength))
    except ValueError:
        raise ExtensionError(f"{what} gives {name} a strength that is not a number: {strength!r}.") from None
    except ScenarioError as error:
        raise ExtensionError(f"{what} has a strength that cannot be: {error}") from error
    return name


def _check_name(kind: str, name: str) -> None:
    if not (isinstance(name, str) and name.isascii() and name.isidentifier()):
        raise ExtensionError(
            f"The name of a {kind} must be of letters, digits and _, and not begin with a digit, got {name!r}."
        )


ThingT = TypeVar("ThingT")


def _known(kind: str, name: str, things: Mapping[str, ThingT], what: str) -> ThingT:
    if name not in things:
        raise ExtensionError(
            f"{what} refers to the {kind} {name!r}, which is not there: {suggestion(name, things)}name one of "
            f"{', '.join(things) or 'none'}."
        )
    return things[name]


def _check_strengths(effect: Effect, limits: tuple[float, float], what: str) -> None:
    low, high = limits
    for strength in (*effect.strengths, *([] if isinstance(effect.suite, str | None) else [effect.suite])):
        is_number = isinstance(strength, int | float) and not isinstance(strength, bool)
        if not is_number or not low < strength <= high:
            raise ExtensionError(
                f"{what} needs strengths that are numbers greater than {low:g} and at most {high:g}, got {strength!r}."
            )
