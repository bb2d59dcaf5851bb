"""What the class of a node must be, so that it fits the node's description; one sentence for each mistake."""

from math import inf

from sunset.errors import ExtensionError
from sunset.system.description import Adaptation, AdaptationKind, Fault, restart
from sunset.texts import suggestion


def check_class(node: str, node_class: object) -> None:
    """Check that a class is that of a node.

    Raises:
        ExtensionError: it is not.
    """
    named = getattr(node_class, "node_name", None)
    if not isinstance(node_class, type) or named != node:
        raise ExtensionError(f"The class of the node {node} must have its node_name, got {named!r}.")


def check_subclass(node: str, node_class: type, present: type) -> None:
    """Check that a class can run in place of a node's present one.

    Raises:
        ExtensionError: it is not a subclass of that, which faults and adaptations rely on.
    """
    if not issubclass(node_class, present):
        raise ExtensionError(
            f"The class of the node {node} is {present.__name__}: {node_class.__name__} must be a subclass of it, or "
            "be left out."
        )


def check_parameter(adaptation: Adaptation, node_class: type) -> None:
    """Check that a node's class has the parameter that an adaptation or an injection sets, if it sets one.

    Raises:
        ExtensionError: it has not, or the parameter is of another type or range.
    """
    if not adaptation.parameter:
        return
    parameter = getattr(node_class, adaptation.parameter, None)
    default = getattr(parameter, "default", None)
    what = f"the parameter {adaptation.parameter!r}"
    if default is None:
        raise ExtensionError(
            f"The class {node_class.__name__} of the node {adaptation.node} does not have {what}: "
            f"{suggestion(adaptation.parameter, vars(node_class))}add it there, or name another (a fault's parameter "
            "has the fault's name unless it says parameter=...)."
        )
    value, low, high = (
        adaptation.value,
        getattr(parameter, "minimum", None),
        getattr(parameter, "maximum", None),
    )
    if type(value) is not type(default):
        raise ExtensionError(
            f"The class {node_class.__name__} has {what} of type {type(default).__name__}, got {value!r}: write a "
            f"value such as {default!r}."
        )
    if isinstance(value, int | float) and not (-inf if low is None else low) <= value <= (
        inf if high is None else high
    ):
        raise ExtensionError(
            f"The class {node_class.__name__} takes for {what} values from {low} to {high}, got {value!r}: change one "
            "of the two."
        )


def check_fault_parameter(fault: Fault, node_class: type) -> None:
    """Check that the class of a fault's node takes all its strengths, is without the fault at first, and is cured so.

    Raises:
        ExtensionError: it does not, or is not.
    """
    if (fault.node, fault.parameter) not in [(step.node, step.parameter) for step in fault.injection]:
        return
    for value in fault.limits or ():
        strength = type(fault.value)(value)
        check_parameter(
            Adaptation(AdaptationKind.SET_PARAMETER, fault.node, fault.parameter, strength), node_class
        )
    parameter = getattr(node_class, fault.parameter, None)
    default = getattr(parameter, "default", fault.healthy)
    if default != fault.healthy:
        raise ExtensionError(
            f"The fault {fault.name} is healthy at {fault.healthy!r}, and the parameter {fault.parameter!r} of the "
            f"class {node_class.__name__} begins with {default!r}: say healthy={default!r} in the Fault."
        )
    action = getattr(parameter, "action", "")
    if action and not hasattr(node_class, action):
        raise ExtensionError(
            f"The parameter {fault.parameter!r} of the class {node_class.__name__} ends with {action!r}, which is no "
            f"@action there: {suggestion(action, vars(node_class))}add it, or leave ends_with out."
        )
    restarted = (restart(fault.node),) in fault.cures
    if getattr(parameter, "cured_by_restart", restarted) != restarted:
        raise ExtensionError(
            f"A restart of {fault.node} {'is a' if restarted else 'is no'} cure of the fault {fault.name}: say "
            f"cured_by_restart={restarted} for the parameter {fault.parameter!r} of the class {node_class.__name__}, "
            "or change the cures."
        )
