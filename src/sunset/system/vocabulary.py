"""The part of the description that managing systems may know: nodes, topics, signals, and the catalogue of faults.

The catalogue lists how each possible fault shows, and its cures. The faults of a run are not here. The experiment's
topics are here for the oracle, the only managing system that may read them.
"""

from collections.abc import Mapping

from sunset.system.current import current_system
from sunset.system.description import (
    Adaptation,
    AdaptationKind,
    Failure,
    Fault,
    FaultKind,
    NodeDescription,
    Sensor,
    Signal,
    Value,
    View,
    redeploy,
    restart,
)
from sunset.system.harness import (
    BLACKBOARD_TOPIC,
    DIAGNOSE,
    DIAGNOSIS_TOPIC,
    FAULT_ENDS_TOPIC,
    INJECTIONS_TOPIC,
    MANAGING_SYSTEM,
    REPAIR,
    RESULT_TOPIC,
)
from sunset.system.names import age_entry, frequency_entry, full_name, heartbeat_entry, state_entry
from sunset.system.paper import ENTROPY_SIGNAL, SHARPNESS_SIGNAL
from sunset.system.window import PERIOD_S

__all__ = [
    "BLACKBOARD_TOPIC",
    "DIAGNOSE",
    "DIAGNOSIS_TOPIC",
    "ENTROPY_SIGNAL",
    "FAULT_ENDS_TOPIC",
    "INJECTIONS_TOPIC",
    "MANAGING_SYSTEM",
    "REPAIR",
    "RESULT_TOPIC",
    "SHARPNESS_SIGNAL",
    "Adaptation",
    "AdaptationKind",
    "Failure",
    "Fault",
    "FaultKind",
    "NodeDescription",
    "Sensor",
    "Signal",
    "Value",
    "View",
    "age_entry",
    "described_failures",
    "described_faults",
    "described_nodes",
    "described_signals",
    "described_views",
    "frequency_entry",
    "full_name",
    "heartbeat_entry",
    "node_names",
    "offered_adaptations",
    "price_s",
    "redeploy",
    "restart",
    "signal_names",
    "state_entry",
    "topic_names",
]


def node_names() -> tuple[str, ...]:
    """Return the names of the managed nodes."""
    return tuple(current_system().nodes)


def signal_names() -> tuple[str, ...]:
    """Return the names of the signals, which are the blackboard's entries with their means."""
    return tuple(current_system().signals)


def topic_names() -> tuple[str, ...]:
    """Return the names of the topics that the monitor watches."""
    return tuple(current_system().topics)


def described_nodes() -> tuple[NodeDescription, ...]:
    """Return the managed nodes."""
    return tuple(current_system().nodes.values())


def described_signals() -> tuple[Signal, ...]:
    """Return the signals."""
    return tuple(current_system().signals.values())


def described_faults() -> Mapping[str, Fault]:
    """Return the catalogue of faults, by name."""
    return current_system().faults


def described_failures() -> Mapping[str, Failure]:
    """Return the failures that faults show as, by name."""
    return current_system().failures


def described_views() -> tuple[View, ...]:
    """Return the values of the parameter that chooses the sensors of the pipeline."""
    return current_system().views


def price_s(adaptation: Adaptation) -> float:
    """Return the price of an adaptation in `utility`, in seconds of healthy output."""
    return current_system().price(adaptation.kind) * PERIOD_S


def offered_adaptations() -> tuple[Adaptation, ...]:
    """Return the adaptations that a managing system can request, in an order that does not reveal cures."""
    return tuple(sorted(current_system().adaptations, key=str))
