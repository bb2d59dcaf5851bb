"""A managing system that logs a digest of all that it can see of the graph, ten times a second."""

import hashlib
import json

from sunset.managing import NoAdaptation


class Census(NoAdaptation):
    def on_start(self) -> None:
        self.create_timer(0.1, self.look)

    def look(self) -> None:
        names = self.get_node_names_and_namespaces()
        nodes = [
            (
                name,
                namespace,
                self.get_publisher_names_and_types_by_node(name, namespace),
                self.get_subscriber_names_and_types_by_node(name, namespace),
                self.get_service_names_and_types_by_node(name, namespace),
                self.get_client_names_and_types_by_node(name, namespace),
            )
            for name, namespace in names
        ]
        graph = json.dumps([nodes, self.get_topic_names_and_types(), self.get_service_names_and_types()])
        self.get_logger().info(f"{hashlib.sha256(graph.encode()).hexdigest()} {len(graph)} {names}")
