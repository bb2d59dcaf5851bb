"""Servers of services, as in `rclpy.service`."""

from collections.abc import Callable

from sunset_ros.interfaces import Message
from sunset_ros.interfaces import Service as ServiceType
from sunset_ros.rmw.core.node import NodeHandle, ServiceHandle
from sunset_ros.rmw.core.port import RequestId
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.task import drive


class Service:
    """Answers requests; made by `Node.create_service`. The callback may be a coroutine."""

    def __init__(
        self,
        node: NodeHandle,
        srv_type: type[ServiceType],
        srv_name: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile,
        *,
        label: str,
    ) -> None:
        self.srv_type = srv_type
        self.srv_name = srv_name
        self.callback = callback
        self.qos_profile = qos_profile
        self.handle: ServiceHandle = node.create_service(
            srv_type, srv_name, qos_profile, self._on_request, label=label
        )

    def __repr__(self) -> str:
        return f"<Service {self.srv_name}>"

    @property
    def service_name(self) -> str:
        """The fully qualified name of the service."""
        return self.srv_name

    def send_response(self, response: Message, request_id: RequestId) -> None:
        """Answer a request; raise a `TypeError` if the response is of another type."""
        if not isinstance(response, self.srv_type.Response):
            raise TypeError(
                f"The callback of service {self.srv_name} must return a {self.srv_type.__name__}.Response, "
                f"got {response!r}."
            )
        self.handle.send_response(request_id, response)

    def destroy(self) -> None:
        """Leave the graph; prefer `Node.destroy_service`."""
        self.handle.destroy()

    def _on_request(self, request_id: RequestId, request: Message) -> None:
        drive(
            self.callback(request, self.srv_type.Response()),
            lambda response: self.send_response(response, request_id),
        )
