"""What a managing system may know of the managed one: names of nodes, topics and the blackboard's entries.

What can go wrong and what cures it is in other modules, which managing systems do not import.
"""

from sunset.system.current import current_system
from sunset.system.description import Adaptation, AdaptationKind, NodeDescription, Signal, Value
from sunset.system.harness import BLACKBOARD_TOPIC, DIAGNOSIS_TOPIC, RESULT_TOPIC
from sunset.system.names import frequency_entry, full_name

__all__ = [
    "BLACKBOARD_TOPIC",
    "DIAGNOSIS_TOPIC",
    "RESULT_TOPIC",
    "AdaptationKind",
    "Value",
    "described_nodes",
    "described_signals",
    "frequency_entry",
    "full_name",
    "node_names",
    "offered_adaptations",
    "signal_names",
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


def offered_adaptations() -> tuple[Adaptation, ...]:
    """Return what a managing system can do to the managed one, in an order that does not tell what cures what."""
    return tuple(sorted(current_system().adaptations, key=str))
