"""The interface of observers of a network."""

from sunset_ros.interfaces import Message
from sunset_ros.rmw.core.port import EndpointKind, RequestId


class Tap:
    """Observes a network without being part of it; override the methods of interest.

    In a simulation it sees every sample, with or without subscriptions, and takes no time. It may keep messages, but
    must not change them. Names of nodes, topics and services are fully qualified. Times are nanoseconds of the
    middleware's system clock.
    """

    def on_node(self, process: str, node: str) -> None:
        """Note that a node of a process joins the network."""

    def on_endpoint(self, node: str, kind: EndpointKind, name: str) -> None:
        """Note that a node subscribes to a topic (`kind` SUBSCRIPTION) or offers a service (SERVICE) of a name."""

    def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
        """Note that a sample of a node left its process at `time_ns`."""

    def on_request(  # noqa: PLR0917  all callers pass positions
        self, time_ns: int, service: str, client: str, server: str, request: Message, request_id: RequestId
    ) -> None:
        """Note that a request of the node `client` is taken by the node `server`, whose callback starts."""

    def on_response(
        self, time_ns: int, service: str, server: str, response: Message, request_id: RequestId
    ) -> None:
        """Note that the response to a request of `on_request` left the process of the server at `time_ns`."""
