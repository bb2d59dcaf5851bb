"""The service by which a node tells what the types that it uses are made of, as rclpy's nodes do since Jazzy."""

from collections.abc import Callable, Iterator
from typing import Protocol

from sunset.interfaces import (
    Message,
    Service,
    TypeFields,
    field_defaults,
    type_description,
    type_hash,
    type_source,
)
from sunset.interfaces.rcl_interfaces.msg import ParameterDescriptor
from sunset.interfaces.type_description_interfaces.msg import (
    Field,
    FieldType,
    IndividualTypeDescription,
    TypeDescription,
    TypeSource,
)
from sunset.interfaces.type_description_interfaces.srv import GetTypeDescription
from sunset.ros.client import AnyClient
from sunset.ros.context import Context
from sunset.ros.parameter import Parameter
from sunset.ros.publisher import AnyPublisher
from sunset.ros.service import Service as ServiceEnd
from sunset.ros.subscription import AnySubscription


class _Node(Protocol):
    """What the service needs of its node."""

    @property
    def context(self) -> Context: ...
    @property
    def publishers(self) -> Iterator[AnyPublisher]: ...
    @property
    def subscriptions(self) -> Iterator[AnySubscription]: ...
    @property
    def clients(self) -> Iterator[AnyClient]: ...
    @property
    def services(self) -> Iterator[ServiceEnd]: ...
    def declare_parameter(self, name: str, value: bool, descriptor: ParameterDescriptor) -> Parameter: ...
    def create_service(
        self,
        srv_type: type[GetTypeDescription],
        srv_name: str,
        callback: Callable[[GetTypeDescription.Request, GetTypeDescription.Response], object],
    ) -> ServiceEnd: ...


def offer_type_descriptions(node: _Node) -> None:
    """Let a node serve `~/get_type_description` where other nodes of its network do.

    Its parameter `start_type_description_service` may forbid it.
    """
    if not node.context.middleware.describes_types:
        return

    def answer(
        request: GetTypeDescription.Request, response: GetTypeDescription.Response
    ) -> GetTypeDescription.Response:
        kind = next((kind for kind in _used(node) if type_hash(kind) == request.type_hash), None)
        if kind is None:
            response.failure_reason = "No endpoint of this node has a type with this hash."
        else:
            _describe(kind, response, with_sources=request.include_type_sources)
        return response

    descriptor = ParameterDescriptor(description="whether others can ask for its types", read_only=True)
    if node.declare_parameter("start_type_description_service", True, descriptor).value:
        node.create_service(GetTypeDescription, "~/get_type_description", answer)


def _used(node: _Node) -> list[type[Message | Service]]:
    """Return the types of a node's endpoints."""
    messages = [*(end.msg_type for end in node.publishers), *(end.msg_type for end in node.subscriptions)]
    services = [*(end.srv_type for end in node.clients), *(end.srv_type for end in node.services)]
    return [*messages, *services]


def _describe(
    kind: type[Message | Service], response: GetTypeDescription.Response, *, with_sources: bool
) -> None:
    described = type_description(kind)
    types = [described["type_description"], *described["referenced_type_descriptions"]]
    first, *others = [_individual(one) for one in types]
    response.type_description = TypeDescription(type_description=first, referenced_type_descriptions=others)
    if with_sources:
        response.type_sources = [_source(one["type_name"]) for one in types]
    response.successful = True


def _individual(described: TypeFields) -> IndividualTypeDescription:
    name = described["type_name"]
    defaults = field_defaults(name)
    fields = [
        Field(name=one["name"], type=FieldType(**one["type"]), default_value=defaults.get(one["name"], ""))
        for one in described["fields"]
    ]
    return IndividualTypeDescription(type_name=name, fields=fields)


def _source(name: str) -> TypeSource:
    encoding, text = type_source(name)
    return TypeSource(type_name=name, encoding=encoding, raw_file_contents=text)
