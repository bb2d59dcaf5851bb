"""Clients of services, as in `rclpy.client`; a blocking `call` is not supported."""

from typing import Any, Generic, TypeAlias, TypeVar, cast

from sunset_ros.interfaces import Message, Service
from sunset_ros.rmw.core.node import ClientHandle, NodeHandle
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.task import Future

RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT", bound=Message)


class Client(Generic[RequestT, ResponseT]):
    """Asks a service; made by `Node.create_client`."""

    def __init__(
        self, node: NodeHandle, srv_type: type[Service], srv_name: str, qos_profile: QoSProfile
    ) -> None:
        self.srv_type = srv_type
        self.srv_name = srv_name
        self.qos_profile = qos_profile
        self._process = node.process
        self._pending: dict[int, Future[ResponseT]] = {}
        self.handle: ClientHandle = node.create_client(
            srv_type, srv_name, qos_profile, self._on_response, label=f"on response of {srv_name}"
        )

    def __repr__(self) -> str:
        return f"<Client of {self.srv_name}>"

    @property
    def service_name(self) -> str:
        """The fully qualified name of the service."""
        return self.srv_name

    def call_async(self, request: RequestT) -> Future[ResponseT]:
        """Send a request; the future is done when the response has come, which may be never.

        Raise a `TypeError` for a request of another type, and a `MiddlewareError` once the client is destroyed.
        """
        if not isinstance(request, self.srv_type.Request):
            raise TypeError(
                f"Service {self.srv_name} takes {self.srv_type.__name__}.Request, got {type(request).__name__}."
            )
        future: Future[ResponseT] = Future()
        self._pending[self.handle.send_request(request)] = future
        return future

    def remove_pending_request(self, future: Future[ResponseT]) -> None:
        """Forget a request; a response that still comes is dropped."""
        self._pending = {
            number: waiting for number, waiting in self._pending.items() if waiting is not future
        }

    def service_is_ready(self) -> bool:
        """Return whether a server is there."""
        return self.handle.server_ready()

    def wait_for_service(self, timeout_sec: float | None = None) -> bool:
        """Wait until a server exists, for ever without a timeout, and return whether it does.

        In a callback, it does not wait.
        """
        timeout_ns = None if timeout_sec is None else round(timeout_sec * 1e9)
        return self._process.wait_for(self.handle.server_ready, timeout_ns)

    def destroy(self) -> None:
        """Leave the graph; prefer `Node.destroy_client`."""
        self.handle.destroy()

    def _on_response(self, number: int, response: Message) -> None:
        future = self._pending.pop(number, None)
        if future is not None:  # else forgotten, or answered by another server before
            future.set_result(cast("ResponseT", response))


AnyClient: TypeAlias = Client[Any, Any]
"""A client of a service that is not known when the code is checked."""
