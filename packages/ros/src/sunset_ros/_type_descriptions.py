"""The service `~/get_type_description` of nodes."""

from collections.abc import Iterable

from sunset_ros.interfaces import (
    Message,
    Service,
    TypeFields,
    field_defaults,
    type_description,
    type_hash,
    type_source,
)
from sunset_ros.interfaces.type_description_interfaces.msg import (
    Field,
    FieldType,
    IndividualTypeDescription,
    TypeDescription,
    TypeSource,
)
from sunset_ros.interfaces.type_description_interfaces.srv import GetTypeDescription


def describe_type(
    types: Iterable[type[Message | Service]],
    request: GetTypeDescription.Request,
    response: GetTypeDescription.Response,
) -> GetTypeDescription.Response:
    """Describe the type with the requested hash, if it is among the types of a node."""
    kind = next((kind for kind in types if type_hash(kind) == request.type_hash), None)
    if kind is None:
        response.failure_reason = "No endpoint of this node has a type with this hash."
        return response
    described = type_description(kind)
    parts = [described["type_description"], *described["referenced_type_descriptions"]]
    first, *others = [_individual(part) for part in parts]
    response.type_description = TypeDescription(type_description=first, referenced_type_descriptions=others)
    if request.include_type_sources:
        response.type_sources = [_source(part["type_name"]) for part in parts]
    response.successful = True
    return response


def _individual(described: TypeFields) -> IndividualTypeDescription:
    name = described["type_name"]
    defaults = field_defaults(name)
    fields = [
        Field(name=each["name"], type=FieldType(**each["type"]), default_value=defaults.get(each["name"], ""))
        for each in described["fields"]
    ]
    return IndividualTypeDescription(type_name=name, fields=fields)


def _source(name: str) -> TypeSource:
    encoding, text = type_source(name)
    return TypeSource(type_name=name, encoding=encoding, raw_file_contents=text)
