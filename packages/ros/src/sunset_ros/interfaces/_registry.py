"""Classes by name, type hashes and type descriptions."""

import hashlib
import json
import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module, resources
from importlib.metadata import entry_points
from itertools import count
from pathlib import Path
from typing import Final

from sunset_ros.errors import InterfaceError
from sunset_ros.generator.definitions import DUMMY_FIELD, NUMERIC, PARTS, FieldType, parse_type, split_service
from sunset_ros.interfaces._message import Message, Service

_FOLDER: Final = Path(__file__).parent

_NESTED: Final = 1
_BOUNDED_STRING: Final = 21
_TYPE_IDS: Final = dict(zip(NUMERIC, count(2), strict=False)) | {"bool": 15, "byte": 16, "string": 17}
_ARRAY, _BOUNDED_SEQUENCE, _SEQUENCE = 48, 96, 144
"""Offsets of an element's id; all ids are from type_description_interfaces/msg/FieldType."""

_EVENT: Final = "Event"
"""The third message of a service in ROS 2, which introspection publishes."""
_RULE: Final = "=" * 80

_LONGEST_NAME: Final = 200
"""The longest name of an interface."""


def type_name(kind: type[Message | Service]) -> str:
    """Return the full ROS name of a message or service class.

    >>> from sunset_ros.interfaces.std_srvs.srv import SetBool
    >>> type_name(SetBool), type_name(SetBool.Request)
    ('std_srvs/srv/SetBool', 'std_srvs/srv/SetBool_Request')
    """
    return kind.__ros_name__


@cache
def get_message(name: str) -> type[Message]:
    """Return the class of a message, or of a service's request or response, by its full name.

    Raises:
        InterfaceError: no package defines it.

    >>> get_message("sensor_msgs/msg/Image").__name__
    'Image'
    """
    service, _, part = name.rpartition("_")
    if part in PARTS and "/srv/" in service:
        kind: object = getattr(get_service(service), part)
    else:
        kind = _find(name, "msg")
    if isinstance(kind, type) and issubclass(kind, Message):
        return kind
    raise InterfaceError(f"There is no message {name!r}; a name looks like 'std_msgs/msg/String'.")


@cache
def get_service(name: str) -> type[Service]:
    """Return the class of a service by its full name.

    Raises:
        InterfaceError: no package defines it.
    """
    kind = _find(name, "srv")
    if isinstance(kind, type) and issubclass(kind, Service):
        return kind
    raise InterfaceError(f"There is no service {name!r}; a name looks like 'std_srvs/srv/SetBool'.")


def _find(name: str, kind: str) -> object:
    match = re.fullmatch(rf"([a-z]\w*)/{kind}/([A-Z]\w*)", name)
    if match is None or len(name) > _LONGEST_NAME:
        return None
    package, short = match.groups()
    home = _python_package(package)
    module = getattr(import_module(home), kind, None) if home else None
    return getattr(module, short) if module and short in module.__all__ else None


@cache
def _python_package(package: str) -> str | None:
    """Return the Python package of a ROS package: of this library, or registered by a distribution."""
    if (_FOLDER / package).is_dir():
        return f"sunset_ros.interfaces.{package}"
    registered = entry_points(group="sunset_ros.interfaces")
    return next((entry.value for entry in registered if entry.name == package), None)


def field_types(kind: type[Message]) -> dict[str, FieldType]:
    """Return the types of a message's fields by name, in the order of the definition."""
    package = kind.__ros_name__.split("/")[0]
    return {name: parse_type(text, package) for name, text in kind.__ros_fields__.items()}


def type_hash(kind: type[Message | Service]) -> str:
    """Return the hash by which ROS 2 compares the types of two processes.

    Source: REP 2016, version 1 of the hash ("RIHS01"): SHA-256 of the type description as JSON, with the names of
    type_description_interfaces/msg/TypeDescription.

    >>> from sunset_ros.interfaces.std_msgs.msg import String
    >>> type_hash(String)
    'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18'
    """
    return _hash_of(kind.__ros_name__)


@cache
def _hash_of(name: str) -> str:
    described = {
        "type_description": _description(name),
        "referenced_type_descriptions": [_description(other) for other in sorted(set(_referenced(name)))],
    }
    return f"RIHS01_{hashlib.sha256(json.dumps(described).encode()).hexdigest()}"


def _referenced(name: str) -> Iterator[str]:
    """Return the names of all messages in the fields of a type, depth first, with repetitions."""
    for field in _fields(name).values():
        if field.is_message:
            yield field.base
            yield from _referenced(field.base)


def _fields(name: str) -> dict[str, FieldType]:
    """Return the fields of a message, of a service (request, response and event), or of its event."""
    service, _, part = name.rpartition("_")
    if "/srv/" not in name or part in PARTS:
        return field_types(get_message(name))
    if part == _EVENT:
        parts = {one.lower(): FieldType(f"{service}_{one}", is_array=True, limit=1) for one in PARTS}
        return {"info": FieldType("service_msgs/msg/ServiceEventInfo"), **parts}
    return {f"{one.lower()}_message": FieldType(f"{name}_{one}") for one in (*PARTS, _EVENT)}


def _description(name: str) -> dict[str, object]:
    fields = _fields(name) or {DUMMY_FIELD: FieldType("uint8")}
    return {
        "type_name": name,
        "fields": [{"name": field, "type": _field_type(kind)} for field, kind in fields.items()],
    }


def _field_type(field: FieldType) -> dict[str, object]:
    type_id = _NESTED if field.is_message else _TYPE_IDS[field.base]
    if field.string_bound:
        type_id = _BOUNDED_STRING
    if field.is_array:
        type_id += (
            _ARRAY if field.size is not None else _SEQUENCE if field.limit is None else _BOUNDED_SEQUENCE
        )
    return {
        "type_id": type_id,
        "capacity": field.size or field.limit or 0,
        "string_capacity": field.string_bound,
        "nested_type_name": field.base if field.is_message else "",
    }


def message_definition(kind: type[Message]) -> str:
    """Return the definition's text, followed by the definitions of all messages in it, as rosbag2 stores it."""
    name = kind.__ros_name__
    parts = [_definition_text(name)]
    parts += [
        f"{_RULE}\nMSG: {other.replace('/msg/', '/')}\n{_definition_text(other)}"
        for other in dict.fromkeys(_referenced(name))
    ]
    return "".join(parts)


def _definition_text(name: str) -> str:
    package, kind, short = name.split("/")
    folder = resources.files(f"{_python_package(package)}.{kind}")
    if kind == "msg":
        return folder.joinpath(f"{short}.msg").read_text("utf-8")
    service, _, part = short.rpartition("_")
    return split_service(folder.joinpath(f"{service}.srv").read_text("utf-8"), name)[PARTS.index(part)]
