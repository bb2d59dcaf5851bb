"""The port between the client library and the middlewares.

A `Middleware` (in `node`) is one process on the network, with a thread of callbacks, a clock, and nodes. A node makes
endpoints, each with a *handler*. The middleware calls handlers on that thread, one at a time, while the process spins
and the node is attached. Messages cross the port as objects, and middlewares serialize them where needed. A handler
owns its message, and a sender keeps the message that it sent, but arrays are shared and read-only.

Names that cross the port are fully qualified (`/ns/name`), expanded, remapped and validated.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.texts import shorten


class CallbackError(MiddlewareError):
    """A callback of a node raised an exception, which is the `__cause__`.

    Attributes:
        node: fully qualified name of the node.
        callback: name of the callback, such as `Camera.on_image`.
    """

    def __init__(self, node: str, callback: str, reason: str) -> None:
        super().__init__(f"Callback {callback} of node {node} {reason}")
        self.node = node
        self.callback = callback
        self._reason = reason

    @property
    def origin(self) -> BaseException:
        """The exception of the callback; this error itself if it comes from another process."""
        return self.__cause__ or self

    def __reduce__(self) -> tuple[type["CallbackError"], tuple[str, str, str]]:
        """Let it be pickled."""
        return type(self), (self.node, self.callback, self._reason)

    @classmethod
    def of(cls, node: str, callback: str, error: Exception) -> "CallbackError":
        """Describe an exception of a callback; the caller raises the result `from error`."""
        try:
            text = str(error)
        except Exception as inner:  # noqa: BLE001  str() of a user's exception may raise
            text = f"no text, since that raised {type(inner).__name__}"
        return cls(node, callback, f"raised {type(error).__name__}: {shorten(text)}")


def qualified_name(namespace: str, node: str) -> str:
    """Return a node's name with its namespace.

    >>> qualified_name("/uav", "camera"), qualified_name("/", "monitor")
    ('/uav/camera', '/monitor')
    """
    return f"{namespace.rstrip('/')}/{node}"


class RequestId(NamedTuple):
    """Identity of one service request: who asked, and that client's running number."""

    client: int
    sequence: int


class EndpointKind(Enum):
    """The kind of an endpoint."""

    PUBLISHER = "publisher"
    SUBSCRIPTION = "subscription"
    CLIENT = "client"
    SERVICE = "service"


@dataclass(frozen=True, slots=True)
class EndpointInfo:
    """An endpoint on the graph.

    Attributes:
        kind: publisher, subscription, client or service.
        name: fully qualified topic or service name.
        type_name: such as `sensor_msgs/msg/Image` or `std_srvs/srv/Trigger`.
        node_name: name of its node, without namespace.
        node_namespace: namespace of its node; the root is `/`.
        qos: the profile that it offers or requests.
        gid: 16 bytes that identify it on this network.
    """

    kind: EndpointKind
    name: str
    type_name: str
    node_name: str
    node_namespace: str
    qos: QoSProfile
    gid: bytes


class Handle(ABC):
    """An endpoint that its user destroys."""

    @abstractmethod
    def destroy(self) -> None:
        """Leave the graph for good: sent messages still arrive, received messages in the queue are dropped."""


class PublisherHandle(Handle):
    """A publisher of a topic."""

    @abstractmethod
    def publish(self, message: Message) -> None:
        """Send a message; the caller may change it afterwards, but not the arrays in it.

        Raises:
            MiddlewareError: the publisher is destroyed, or the middleware refuses.
            InterfaceError: the message does not fit its definition; some middlewares raise it later.
        """

    @property
    @abstractmethod
    def wanted(self) -> bool:
        """Whether a subscription would receive a message sent now, at once or later."""

    @property
    @abstractmethod
    def matched(self) -> int:
        """The number of subscriptions that receive messages from here."""


class SubscriptionHandle(Handle):
    """A subscription to a topic, with a queue of the depth in its QoS."""

    @property
    @abstractmethod
    def matched(self) -> int:
        """The number of publishers whose messages arrive here."""


class ClientHandle(Handle):
    """A client of a service; requests go to every server of its name and type."""

    @abstractmethod
    def send_request(self, request: Message) -> int:
        """Send a request, and return its number, which the handler receives with the response.

        The numbers of each client run from 1, so that remote clients know them.

        Raises:
            MiddlewareError: the client is destroyed.
            InterfaceError: the request does not fit its definition.
        """

    @abstractmethod
    def server_ready(self) -> bool:
        """Return whether a server of this name and type exists."""


class ServiceHandle(Handle):
    """A server of a service, with a queue of the depth in its QoS."""

    @abstractmethod
    def send_response(self, request_id: RequestId, response: Message) -> None:
        """Answer a request of the handler.

        Raises:
            MiddlewareError: no such request waits, or the server is destroyed.
            InterfaceError: the response does not fit its definition.
        """
