"""Requesting an adaptation that the system's description names."""

from sunset.managing.base import ManagingSystem
from sunset.ros.task import Future
from sunset.system.vocabulary import Adaptation, AdaptationKind


def request(manager: ManagingSystem, adaptation: Adaptation) -> Future[bool]:
    """Let a managing system do an adaptation, such as one of `offered_adaptations()` or a step of a fault's cure.

    Returns:
        As the method of `ManagingSystem` of its kind.
    """
    match adaptation.kind:
        case AdaptationKind.RESTART:
            return manager.restart(adaptation.node)
        case AdaptationKind.REDEPLOY:
            return manager.redeploy(adaptation.node)
        case AdaptationKind.ACTIVATE:
            return manager.activate(adaptation.node)
        case AdaptationKind.DEACTIVATE:
            return manager.deactivate(adaptation.node)
        case AdaptationKind.CHANGE_TOPIC:
            return manager.change_topic(adaptation.node, adaptation.parameter, str(adaptation.value))
    if adaptation.value is None:
        raise ValueError(f"The adaptation of {adaptation.node}.{adaptation.parameter} has no value.")
    return manager.set_parameter(adaptation.node, adaptation.parameter, adaptation.value)
