"""A managing system that prints all that it can see of the graph, ten times a second: JSON, compressed, in base 64."""

import base64
import json
import zlib

from sunset.managing import NoAdaptation


class Census(NoAdaptation):
    def on_start(self) -> None:
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
        text = json.dumps([self.get_clock().now().nanoseconds, graph])
        print(base64.b64encode(zlib.compress(text.encode())).decode())  # noqa: T201  it is what it does
