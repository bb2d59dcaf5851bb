"""The part of a node that asks who else is there."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter
from typing import TypeAlias

from sunset_ros.exceptions import NodeNameNonExistentError
from sunset_ros.rmw.core.node import Middleware
from sunset_ros.rmw.core.port import EndpointInfo, EndpointKind, qualified_name
from sunset_ros.rmw.core.qos import QoSProfile

NamesAndTypes: TypeAlias = list[tuple[str, list[str]]]
TOPIC_KINDS = (EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION)


@dataclass(frozen=True, slots=True)
class TopicEndpointInfo:
    """A publisher or subscription, as in `rclpy.topic_endpoint_info`."""

    node_name: str
    node_namespace: str
    topic_type: str
    endpoint_type: EndpointKind
    endpoint_gid: tuple[int, ...]
    qos_profile: QoSProfile


class NodeGraph:
    """Graph methods of `Node`, as in rclpy; all answer at once."""

    _middleware: Middleware

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Return the fully qualified name of a topic."""
        raise NotImplementedError

    def get_node_names(self) -> list[str]:
        """Return the names of all nodes, without namespaces."""
        return [name for name, _ in self._middleware.nodes()]

    def get_fully_qualified_node_names(self) -> list[str]:
        """Return the fully qualified names of all nodes."""
        return [qualified_name(namespace, name) for name, namespace in self._middleware.nodes()]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return (name, namespace) of all nodes."""
        return list(self._middleware.nodes())

    def get_topic_names_and_types(self) -> NamesAndTypes:
        """Return (name, types) of all topics, sorted by name."""
        return self._names_and_types(lambda info: info.kind in TOPIC_KINDS)

    def get_service_names_and_types(self) -> NamesAndTypes:
        """Return (name, types) of all services that are offered, sorted by name."""
        return self._names_and_types(lambda info: info.kind is EndpointKind.SERVICE)

    def get_publisher_names_and_types_by_node(self, node_name: str, node_namespace: str) -> NamesAndTypes:
        """Return (topic, types) of a node's publishers; raise a `NodeNameNonExistentError` without such a node."""
        return self._of_node(EndpointKind.PUBLISHER, node_name, node_namespace)

    def get_subscriber_names_and_types_by_node(self, node_name: str, node_namespace: str) -> NamesAndTypes:
        """Return (topic, types) of a node's subscriptions; raise a `NodeNameNonExistentError` without such a node."""
        return self._of_node(EndpointKind.SUBSCRIPTION, node_name, node_namespace)

    def get_service_names_and_types_by_node(self, node_name: str, node_namespace: str) -> NamesAndTypes:
        """Return (service, types) of a node's services; raise a `NodeNameNonExistentError` without such a node."""
        return self._of_node(EndpointKind.SERVICE, node_name, node_namespace)

    def get_client_names_and_types_by_node(self, node_name: str, node_namespace: str) -> NamesAndTypes:
        """Return (service, types) of a node's clients; raise a `NodeNameNonExistentError` without such a node."""
        return self._of_node(EndpointKind.CLIENT, node_name, node_namespace)

    def get_publishers_info_by_topic(self, topic_name: str) -> list[TopicEndpointInfo]:
        """Return who publishes on a topic."""
        return self._of_topic(EndpointKind.PUBLISHER, topic_name)

    def get_subscriptions_info_by_topic(self, topic_name: str) -> list[TopicEndpointInfo]:
        """Return who subscribes to a topic."""
        return self._of_topic(EndpointKind.SUBSCRIPTION, topic_name)

    def count_publishers(self, topic_name: str) -> int:
        """Return how many publishers a topic has."""
        return len(self.get_publishers_info_by_topic(topic_name))

    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscriptions a topic has."""
        return len(self.get_subscriptions_info_by_topic(topic_name))

    def _of_topic(self, kind: EndpointKind, topic_name: str) -> list[TopicEndpointInfo]:
        name = self.resolve_topic_name(topic_name)
        return [
            TopicEndpointInfo(
                info.node_name, info.node_namespace, info.type_name, info.kind, tuple(info.gid), info.qos
            )
            for info in self._middleware.endpoints(name)
            if info.kind is kind
        ]

    def _of_node(self, kind: EndpointKind, node_name: str, node_namespace: str) -> NamesAndTypes:
        if (node_name, node_namespace) not in self._middleware.nodes():
            raise NodeNameNonExistentError(
                f"There is no node {node_name!r} in the namespace {node_namespace!r} now."
            )
        return self._names_and_types(
            lambda info: (info.kind, info.node_name, info.node_namespace) == (kind, node_name, node_namespace)
        )

    def _names_and_types(self, wanted: Callable[[EndpointInfo], bool]) -> NamesAndTypes:
        return list(names_and_types(filter(wanted, self._middleware.endpoints())).items())


def names_and_types(infos: Iterable[EndpointInfo]) -> dict[str, list[str]]:
    """Return the types of endpoints by topic or service, sorted."""
    pairs = sorted({(info.name, info.type_name) for info in infos})
    return {name: [kind for _, kind in group] for name, group in groupby(pairs, itemgetter(0))}
