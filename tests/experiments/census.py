"""A managing system that writes down all that it can see of the graph, ten times a second."""

import json
from pathlib import Path

from sunset.managing import NoAdaptation

OUT = Path("census.jsonl")
"""In the folder in which the experiment is flown."""


class Census(NoAdaptation):
    def on_start(self) -> None:
        OUT.unlink(missing_ok=True)
        self.create_timer(0.1, self.look)

    def look(self) -> None:
        nodes = {
            f"{namespace}|{name}": [
                self.get_publisher_names_and_types_by_node(name, namespace),
                self.get_subscriber_names_and_types_by_node(name, namespace),
                self.get_service_names_and_types_by_node(name, namespace),
                self.get_client_names_and_types_by_node(name, namespace),
            ]
            for name, namespace in self.get_node_names_and_namespaces()
        }
        graph = [nodes, self.get_topic_names_and_types(), self.get_service_names_and_types()]
        with OUT.open("a") as file:
            file.write(json.dumps([self.get_clock().now().nanoseconds, graph]) + "\n")
