"""The middleware port: the narrow door between the client library and whatever carries its messages.

A `Middleware` (in `node`) is one process on the network: it has one thread of callbacks, a clock, and nodes. A
node makes endpoints, each with a *handler* that the middleware calls on that thread, one at a time,
and only while the process spins and the node is attached. Messages cross the port as typed Python
objects; a middleware that needs bytes serialises behind it. Handlers own what they are given, and
a sender keeps what it sent, except that arrays are shared and read-only.

Names that cross the port are fully qualified (`/ns/name`), expanded, remapped and validated.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from sunset.common.errors import MiddlewareError
from sunset.common.texts import shorten
from sunset.interfaces import Message
from sunset.rmw.core.qos import QoSProfile


class CallbackError(MiddlewareError):
    """A callback of a node raised; `__cause__` is what it raised.

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
        """What the callback raised; itself where that is not known, as of one that comes from another process."""
        return self.__cause__ or self

    def __reduce__(self) -> tuple[type["CallbackError"], tuple[str, str, str]]:
        """Let it come back from another process."""
        return type(self), (self.node, self.callback, self._reason)

    @classmethod
    def of(cls, node: str, callback: str, error: Exception) -> "CallbackError":
        """Wrap what a callback raised; the caller raises the result `from error`."""
        try:
            text = str(error)
        except Exception as inner:  # noqa: BLE001  str() of a user's exception may itself raise
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
    """What an endpoint does."""

    PUBLISHER = "publisher"
    SUBSCRIPTION = "subscription"
    CLIENT = "client"
    SERVICE = "service"


@dataclass(frozen=True, slots=True)
class EndpointInfo:
    """One endpoint as seen on the graph.

    Attributes:
        kind: what it does.
        name: fully qualified topic or service name.
        type_name: such as `sensor_msgs/msg/Image` or `std_srvs/srv/Trigger`.
        node_name: name of its node, without namespace.
        node_namespace: namespace of its node; the root is `/`.
        qos: what it offers or asks for.
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
    """An end of a topic or service, which its user destroys."""

    @abstractmethod
    def destroy(self) -> None:
        """Leave the graph for good: what was sent arrives, what has come and is not yet handled is dropped."""


class PublisherHandle(Handle):
    """A writer on one topic."""

    @abstractmethod
    def publish(self, message: Message) -> None:
        """Send a message; the caller may change it afterwards, but not the arrays in it.

        Raises:
            MiddlewareError: the publisher is destroyed, or the middleware refuses.
            InterfaceError: the message does not fit its definition; some middlewares find it only when it leaves.
        """

    @property
    @abstractmethod
    def wanted(self) -> bool:
        """Whether anybody would get a message sent now, or could get it later."""

    @property
    @abstractmethod
    def matched(self) -> int:
        """Number of subscriptions that get what is sent."""


class SubscriptionHandle(Handle):
    """A reader of one topic; it holds the last messages that were not handled yet, as many as its QoS says."""

    @property
    @abstractmethod
    def matched(self) -> int:
        """Number of publishers whose messages arrive here."""


class ClientHandle(Handle):
    """The asking end of one service: it asks every server of its name and type."""

    @abstractmethod
    def send_request(self, request: Message) -> int:
        """Send a request and return its number, with which the response comes to the handler.

        The numbers of each client run from 1, so that one that is far away knows them.

        Raises:
            MiddlewareError: the client is destroyed.
            InterfaceError: the request does not fit its definition.
        """

    @abstractmethod
    def server_ready(self) -> bool:
        """Whether a server of this name and type is there."""


class ServiceHandle(Handle):
    """The answering end of one service; it holds the last requests that were not handled yet, as its QoS says."""

    @abstractmethod
    def send_response(self, request_id: RequestId, response: Message) -> None:
        """Answer a request that the handler was given.

        Raises:
            MiddlewareError: no such request waits for a response, or the server is destroyed.
            InterfaceError: the response does not fit its definition.
        """
