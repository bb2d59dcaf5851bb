"""What an outside observer of a network may see."""

from sunset.interfaces import Message
from sunset.rmw.core.port import EndpointKind, RequestId


class Tap:
    """Listens to a network without being part of it; override what is of interest.

    In a simulation it sees every sample, whether or not anybody subscribes, takes no time and cannot be lost. It may
    keep the messages that it is given but must not change them. All names are fully qualified, but for those of
    processes; all times are nanoseconds of the middleware's system clock.
    """

    def on_node(self, process: str, node: str) -> None:
        """Note that a node of a process joins the network."""

    def on_endpoint(self, node: str, kind: EndpointKind, name: str) -> None:
        """Note that a node subscribes to a topic (`kind` SUBSCRIPTION) or offers a service (SERVICE) of a name."""

    def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
        """Note that a sample of a node left its process at `time_ns`."""

    def on_request(  # noqa: PLR0917  it is called with all of them, in this order
        self, time_ns: int, service: str, client: str, server: str, request: Message, request_id: RequestId
    ) -> None:
        """Note that a request of the node `client` is taken by the node `server`.

        Args:
            time_ns: when the server's callback starts.
            service: its name.
            client: the node that asks.
            server: the node that will answer.
            request: the request.
            request_id: identifies it until its response.
        """

    def on_response(
        self, time_ns: int, service: str, server: str, response: Message, request_id: RequestId
    ) -> None:
        """Note that the response to a request of `on_request` left the process of the server at `time_ns`."""
