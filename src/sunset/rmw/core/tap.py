"""What an outside observer of a network may see."""

from sunset.interfaces import Message
from sunset.rmw.core.port import EndpointKind, RequestId


class Tap:
    """Listens to a network without being part of it; override what is of interest.

    In a simulation it sees every sample, whether or not anybody subscribes, takes no time and cannot be lost. It may
    keep the messages that it is given but must not change them.
    """

    def on_node(self, process: str, node: str) -> None:
        """Note that a node joins the network.

        Args:
            process: the name of its process.
            node: its fully qualified name.
        """

    def on_endpoint(self, node: str, kind: EndpointKind, name: str) -> None:
        """Note that a node subscribes to a topic or offers a service.

        Args:
            node: its fully qualified name.
            kind: `EndpointKind.SUBSCRIPTION` or `EndpointKind.SERVICE`.
            name: the fully qualified name of the topic or service.
        """

    def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
        """Note that a sample left its process.

        Args:
            time_ns: when it left.
            topic: fully qualified name.
            node: fully qualified name of the node that published it.
            message: the sample.
        """

    def on_request(  # noqa: PLR0917  it is called with all of them, in this order
        self, time_ns: int, service: str, client: str, server: str, request: Message, request_id: RequestId
    ) -> None:
        """Note that a server takes a request.

        Args:
            time_ns: when the server's callback starts.
            service: fully qualified name.
            client: fully qualified name of the node that asks.
            server: fully qualified name of the node that will answer.
            request: the request.
            request_id: identifies it until its response.
        """

    def on_response(
        self, time_ns: int, service: str, server: str, response: Message, request_id: RequestId
    ) -> None:
        """Note that a response left the process of the server.

        Args:
            time_ns: when it left.
            service: fully qualified name.
            server: fully qualified name of the node that answers.
            response: the response.
            request_id: the one that `on_request` was given.
        """
