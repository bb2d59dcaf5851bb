"""The service by which nodes tell what their types are made of."""

from typing import TYPE_CHECKING, Any

import pytest

from sunset_ros import Context, Node, Parameter
from sunset_ros.exceptions import ParameterImmutableException
from sunset_ros.interfaces import type_hash
from sunset_ros.interfaces.lifecycle_msgs.srv import GetState
from sunset_ros.interfaces.std_msgs.msg import Header
from sunset_ros.interfaces.std_srvs.srv import SetBool
from sunset_ros.interfaces.type_description_interfaces.srv import GetTypeDescription

if TYPE_CHECKING:
    from .conftest import Live

SERVICE = "/guest/get_type_description"
INT32, UINT32, NESTED, STRING, BOUNDED_NESTED = 6, 7, 1, 17, 97
"""Numbers of types, of type_description_interfaces/msg/FieldType."""


def ask(live: "Live", kind: Any, *, with_sources: bool = True, type_hash_: str = "") -> Any:
    """Return what a node with one endpoint of each kind says of a type."""
    node, executor = live.node("guest")
    node.create_publisher(Header, "out", 10)
    node.create_service(SetBool, "~/set", lambda _, response: response)
    client = node.create_client(GetTypeDescription, SERVICE)
    assert client.wait_for_service(10.0)
    future = client.call_async(
        GetTypeDescription.Request(type_hash=type_hash_ or type_hash(kind), include_type_sources=with_sources)
    )
    assert live.spin(executor, future.done)
    return future.result()


def fields(described: Any) -> tuple[str, list[tuple[str, int, str]]]:
    return described.type_name, [
        (field.name, field.type.type_id, field.type.nested_type_name) for field in described.fields
    ]


def test_a_node_tells_what_a_message_is_made_of(live: "Live") -> None:
    answer = ask(live, Header)
    assert (answer.successful, answer.failure_reason) == (True, "")
    assert fields(answer.type_description.type_description) == (
        "std_msgs/msg/Header",
        [("stamp", NESTED, "builtin_interfaces/msg/Time"), ("frame_id", STRING, "")],
    )
    assert [fields(one) for one in answer.type_description.referenced_type_descriptions] == [
        ("builtin_interfaces/msg/Time", [("sec", INT32, ""), ("nanosec", UINT32, "")])
    ]
    assert [
        (source.type_name, source.encoding, source.raw_file_contents) for source in answer.type_sources
    ] == [
        ("std_msgs/msg/Header", "msg", "builtin_interfaces/Time stamp\nstring frame_id\n"),
        ("builtin_interfaces/msg/Time", "msg", "int32 sec\nuint32 nanosec\n"),
    ]


def test_a_node_tells_what_a_service_is_made_of(live: "Live") -> None:
    answer = ask(live, GetTypeDescription)
    name = "type_description_interfaces/srv/GetTypeDescription"
    assert fields(answer.type_description.type_description) == (
        name,
        [
            ("request_message", NESTED, f"{name}_Request"),
            ("response_message", NESTED, f"{name}_Response"),
            ("event_message", NESTED, f"{name}_Event"),
        ],
    )
    others = {one.type_name: one for one in answer.type_description.referenced_type_descriptions}
    assert list(others) == sorted(others)
    assert fields(others[f"{name}_Event"])[1] == [
        ("info", NESTED, "service_msgs/msg/ServiceEventInfo"),
        ("request", BOUNDED_NESTED, f"{name}_Request"),
        ("response", BOUNDED_NESTED, f"{name}_Response"),
    ]
    assert [field.default_value for field in others[f"{name}_Request"].fields] == ["", "", "True"]
    sources = {source.type_name: source for source in answer.type_sources}
    assert set(sources) == {name, *others}
    assert (sources[name].encoding, sources[f"{name}_Event"].encoding) == ("srv", "implicit")
    assert sources[f"{name}_Event"].raw_file_contents == ""


def test_sources_are_left_out_on_request(live: "Live") -> None:
    answer = ask(live, SetBool, with_sources=False)
    assert (answer.successful, answer.type_sources) == (True, [])


@pytest.mark.parametrize("type_hash_", ["", "RIHS01_", "x" * 10_000])
def test_types_that_a_node_does_not_use_are_not_described(live: "Live", type_hash_: str) -> None:
    answer = ask(live, GetState, type_hash_=type_hash_)
    assert not answer.successful
    assert answer.failure_reason == "No endpoint of this node has a type with this hash."
    assert answer.type_sources == []


def test_a_parameter_that_cannot_be_set_later_says_whether_a_node_tells(live: "Live") -> None:
    node, _ = live.node("guest")
    assert node.get_parameter("start_type_description_service").value is True
    with pytest.raises(ParameterImmutableException):
        node.undeclare_parameter("start_type_description_service")
    (result,) = node.set_parameters([Parameter("start_type_description_service", value=False)])
    assert not result.successful


def services_of(live: "Live", *arguments: str, declare: bool = False, **options: Any) -> list[str]:
    context = Context()
    context.init(["--ros-args", *arguments], middleware=live.process(**options))
    node = Node("guest", context=context, automatically_declare_parameters_from_overrides=declare)
    return [service.srv_name for service in node.services]


@pytest.mark.parametrize("declare", [False, True])
def test_a_node_may_be_told_not_to_tell(live: "Live", declare: bool) -> None:
    assert SERVICE in services_of(live)
    assert SERVICE not in services_of(live, "-p", "start_type_description_service:=false", declare=declare)


def test_where_nodes_of_humble_are_nobody_tells(live: "Live") -> None:
    assert SERVICE not in services_of(live, distro="humble")
