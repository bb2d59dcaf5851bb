"""The port between the client library and the middlewares.

A `Process` has a thread of callbacks, a clock and, as a `Middleware` (in `node`), nodes. A node has endpoints, each
with a *handler*. The middleware calls handlers on that thread, one at a time, while the process spins
and the node is attached. Messages cross the port as objects, and middlewares serialize them where needed. A handler
owns its message, and a sender keeps the message that it sent, but arrays are shared and read-only.

Names that cross the port are fully qualified (`/ns/name`), expanded, remapped and validated.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.texts import shorten


class CallbackError(MiddlewareError):
    """A callback, such as `Camera.on_image`, of a node raised an exception, which is the `__cause__`."""

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
        return cls(node, callback, f"raised {type(error).__name__}: {shorten(str(error))}")


def qualified_name(namespace: str, node: str) -> str:
    """Return a node's name with its namespace.

    >>> qualified_name("/uav", "camera"), qualified_name("/", "monitor")
    ('/uav/camera', '/monitor')
    """
    return f"{namespace.rstrip('/')}/{node}"


def next_due_ns(due_ns: int, period_ns: int, now_ns: int) -> int:
    """Return when a timer is due again after a call that was due at `due_ns` and starts at `now_ns`.

    The result is on the grid of whole periods, and not in the past.

    >>> next_due_ns(100, 100, 130), next_due_ns(100, 100, 430), next_due_ns(100, 100, 400)
    (200, 500, 400)
    """
    due_ns += period_ns
    if due_ns < now_ns:
        due_ns = now_ns if period_ns == 0 else due_ns + -(-(now_ns - due_ns) // period_ns) * period_ns
    return due_ns


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
    """An endpoint on the graph."""

    kind: EndpointKind
    name: str  #: of its topic or service, fully qualified
    type_name: str  #: such as `sensor_msgs/msg/Image` or `std_srvs/srv/Trigger`
    node_name: str  #: without namespace
    node_namespace: str  #: the root is `/`
    qos: QoSProfile  #: the profile that it offers or requests
    gid: bytes  #: 16 bytes that identify it on this network


class Process(ABC):
    """A process on the network: its clocks, its thread of callbacks, its life, and its view of the graph."""

    _alive = True
    _ending = False
    _end_text = "The process has ended."

    @abstractmethod
    def now_ns(self) -> int:
        """Return the time of the system clock, in nanoseconds since its epoch."""

    @abstractmethod
    def steady_ns(self) -> int:
        """Return the time of a clock that never jumps, in nanoseconds since some fixed moment."""

    @abstractmethod
    def spin_once(self, timeout_ns: int | None) -> bool:
        """Wait for a callback of an attached node and run it; return whether a callback ran.

        It does not wait if `timeout_ns` is 0, and waits for ever if it is None. In a simulation, events happen
        meanwhile.

        Raises:
            CallbackError: the callback raised, or in a simulation another callback.
            MiddlewareError: called in a callback, or no events are left in a simulation and `timeout_ns` is None.
        """

    @abstractmethod
    def wait_for(self, predicate: Callable[[], bool], timeout_ns: int | None) -> bool:
        """Wait, except in a callback, until a predicate on the graph holds; return whether it holds.

        Callbacks of this process do not run meanwhile, unless it is simulated.
        """

    def wake(self) -> None:  # noqa: B027  not all have other threads
        """Make a waiting `spin_once` return, where another thread may run during it."""

    @property
    def alive(self) -> bool:
        """Whether the process may still use the network."""
        return self._alive and not self._ending

    def check_alive(self) -> None:
        """Raise a `MiddlewareError` if the process has ended."""
        if not self._alive:
            raise MiddlewareError(self._end_text)

    @abstractmethod
    def shutdown(self) -> None:
        """Leave the network; in a callback, once its messages are sent. A signal handler may call it."""

    @abstractmethod
    def nodes(self) -> Sequence[tuple[str, str]]:
        """Return (name, namespace) of all nodes on the graph, in a fixed order."""

    @abstractmethod
    def endpoints(self, name: str | None = None) -> Sequence[EndpointInfo]:
        """Return all endpoints on the graph, or those of a topic or service, in a fixed order."""
