"""How the nodes of the managed system feed each other when all is well, and which of them has stopped first."""

from sunset.managing.symptoms import Symptoms
from sunset.system.vocabulary import described_nodes, full_name, topic_names


class Wiring:
    """The topics between the managed nodes, by their full names.

    Attributes:
        publisher: topic → the node that publishes on it.
        inputs: node → the topics of other nodes that it gets.
        topics: the topics that have messages, of those that the monitor watches.
        boot_s: node → how long it is away for a redeploy [s].
    """

    def __init__(self) -> None:
        nodes = described_nodes()
        self.publisher = {full_name(topic): node.name for node in nodes for topic in node.outputs}
        self.inputs = {
            node.name: tuple(topic for topic in map(full_name, node.inputs) if topic in self.publisher)
            for node in nodes
        }
        self.boot_s = {node.name: max(0.0, node.activation_delay_s) for node in nodes}
        active = {node.name for node in nodes if node.initial_state == "active"}
        self.topics = tuple(
            topic for topic in map(full_name, topic_names()) if self.publisher.get(topic) in active
        )

    def first_silent(self, symptoms: Symptoms) -> str:
        """Return the node furthest upstream of those whose topics have stopped; an empty text if none has."""
        silent = [topic for topic in self.topics if symptoms.stopped(topic)]
        sources = [self.publisher[topic] for topic in silent]
        return next((node for node in sources if not set(silent).intersection(self.topics_before(node))), "")

    def topics_before(self, node: str) -> list[str]:
        """Return what the nodes before a node send, where the monitor watches that."""
        before = [
            topic for source in self.inputs[node] for topic in self.topics_until(self.publisher[source])
        ]
        return list(dict.fromkeys(before))

    def topics_until(self, node: str) -> list[str]:
        """Return what a node and those before it send, where the monitor watches that."""
        return [*self.topics_before(node), *(topic for topic in self.topics if self.publisher[topic] == node)]
