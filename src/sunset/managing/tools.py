"""Tools for managing systems: the topics between nodes, cool-downs, thresholds, and adaptations of the catalogue."""

import math
from typing import cast

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import FloatOrNaN, Symptoms
from sunset.system.vocabulary import Adaptation, current_system, full_name
from sunset_ros.task import Future


class Wiring:
    """The topics between the managed nodes of a healthy system, by their full names.

    Attributes:
        publisher: topic → the node that publishes on it.
        inputs: node → the topics that it gets from other nodes.
        topics: the topics of active nodes that the monitor watches.
        boot_s: node → the time that it takes to boot [s].
    """

    def __init__(self) -> None:
        nodes = current_system().nodes.values()
        self.publisher = {full_name(topic): node.name for node in nodes for topic in node.outputs}
        self.inputs = {
            node.name: tuple(topic for topic in map(full_name, node.inputs) if topic in self.publisher)
            for node in nodes
        }
        self.boot_s = {node.name: max(0.0, node.activation_delay_s) for node in nodes}
        active = {node.name for node in nodes if node.initial_state == "active"}
        self.topics = tuple(
            topic for topic in map(full_name, current_system().topics) if self.publisher.get(topic) in active
        )

    def first_silent(self, symptoms: Symptoms) -> str:
        """Return the node furthest upstream whose topic has stopped; an empty text if no topic has stopped."""
        silent = [topic for topic in self.topics if symptoms.stopped(topic)]
        sources = [self.publisher[topic] for topic in silent]
        return next((node for node in sources if not set(silent).intersection(self.topics_before(node))), "")

    def topics_before(self, node: str) -> list[str]:
        """Return the watched topics of all nodes upstream of a node."""
        before = [
            topic for source in self.inputs[node] for topic in self.topics_until(self.publisher[source])
        ]
        return list(dict.fromkeys(before))

    def topics_until(self, node: str) -> list[str]:
        """Return the watched topics of a node and of all nodes upstream of it."""
        return [*self.topics_before(node), *(topic for topic in self.topics if self.publisher[topic] == node)]


class Waits:
    """Cool-downs by name, in the experiment's time.

    Args:
        manager: the managing system that waits.
    """

    def __init__(self, manager: ManagingSystem) -> None:
        self._manager = manager
        self._until_s: dict[str, float] = {}

    def start(self, name: str, seconds: float) -> None:
        """Begin a wait now, also if a wait of this name has begun already."""
        self._until_s[name] = self._manager.now_s + seconds

    def over(self, name: str) -> bool:
        """Return whether a wait is over, or has never begun."""
        return self._manager.now_s >= self._until_s.get(name, 0.0)


class Thresholds:
    """The thresholds of all signals; thresholds of the model's card are parameters of the managing system."""

    def __init__(self, manager: ManagingSystem) -> None:
        self._manager = manager
        self._signals = current_system().signals
        for signal in self._signals.values():
            if signal.calibrated and not manager.has_parameter(signal.threshold_name):
                manager.declare_parameter(signal.threshold_name, 0.0)

    def badness(self, name: str, symptoms: Symptoms) -> float:
        """Return a signal, negated if low is bad; NaN until it is measured."""
        value = symptoms.signal(name)
        return -value if self._signals[name].below else value

    def threshold(self, name: str) -> FloatOrNaN:
        """Return the threshold of a signal; NaN without a threshold."""
        signal = self._signals[name]
        if signal.calibrated:
            return cast("float", self._manager.get_parameter(signal.threshold_name).value)
        return math.nan if signal.threshold is None else signal.threshold

    def is_beyond(self, name: str, symptoms: Symptoms) -> bool:
        """Return whether a signal is on the wrong side of its threshold; False without a threshold."""
        return self._signals[name].is_beyond(symptoms.signal(name), self.threshold(name))


def request(manager: ManagingSystem, adaptation: Adaptation) -> Future[bool]:
    """Let a managing system do an adaptation, such as a step of a fault's cure.

    Returns:
        The future that the method of `ManagingSystem` for this kind of adaptation returns.
    """
    arguments = (adaptation.parameter, adaptation.value) if adaptation.parameter else ()
    future: Future[bool] = getattr(manager, adaptation.kind)(adaptation.node, *arguments)
    return future
