"""What a managing system may know of the managed one: names of nodes, topics and the blackboard's entries.

What can go wrong and what cures it is in other modules, which managing systems do not import.
"""

from sunset.system.current import current_system
from sunset.system.description import Value
from sunset.system.harness import BLACKBOARD_TOPIC, RESULT_TOPIC
from sunset.system.names import frequency_entry, full_name

__all__ = [
    "BLACKBOARD_TOPIC",
    "RESULT_TOPIC",
    "Value",
    "frequency_entry",
    "full_name",
    "node_names",
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
