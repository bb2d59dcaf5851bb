import re

import pytest
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces import (
    Message,
    get_message,
    get_service,
    message_definition,
    type_hash,
    type_name,
)
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState, GetState
from sunset_ros.interfaces.rmw_dds_common.msg import Gid
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.interfaces.std_srvs.srv import SetBool


def independent_hash(kind: type[Message]) -> str:
    """Return the hash by an independent implementation, fed with our definition's text."""
    store = get_typestore(Stores.EMPTY)
    own = f"{type_name(kind).partition('/')[0]}/msg/Own"
    parsed = get_types_from_msg(re.sub(r"\bchar\b", "uint8", message_definition(kind)), own)
    constants, fields = parsed.pop(own)
    fields = fields or [("structure_needs_at_least_one_member", (Nodetype.BASE, ("uint8", 0)))]
    store.fielddefs.update(parsed)
    store.fielddefs[type_name(kind)] = (constants, fields)
    return store.hash_rihs01(type_name(kind))


def test_every_hash_agrees_with_an_independent_implementation(kind: type[Message]) -> None:
    assert type_hash(kind) == independent_hash(kind)


def test_hashes_of_standard_messages_are_those_of_the_distribution(kind: type[Message]) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    name = type_name(kind)
    if name in store.fielddefs and "char" not in str(store.generate_msgdef(name, ros_version=2)):
        assert type_hash(kind) == store.hash_rihs01(name)
    else:
        assert "/srv/" in name or name.startswith("system_interfaces/") or "char" in message_definition(kind)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("builtin_interfaces/msg/Time", "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197"),
        ("std_msgs/msg/Header", "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01"),
        ("std_msgs/msg/String", "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"),
        ("sensor_msgs/msg/Image", "d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47"),
    ],
)
def test_hashes_are_those_that_real_nodes_announce(name: str, expected: str) -> None:
    assert type_hash(get_message(name)) == f"RIHS01_{expected}"


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("std_srvs/srv/SetBool", "abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a"),
        (
            "lifecycle_msgs/srv/ChangeState",
            "356fe34f0475a43acf54542013af4167b0e729f77ea22ffb045c6ad8e20668e5",
        ),
    ],
)
def test_hashes_of_services_are_those_of_the_distribution(name: str, expected: str) -> None:
    assert type_hash(get_service(name)) == f"RIHS01_{expected}"


def test_names_and_classes_map_both_ways(kind: type[Message]) -> None:
    assert get_message(type_name(kind)) is kind


def test_services_are_found_by_name() -> None:
    assert get_service("std_srvs/srv/SetBool") is SetBool
    assert type_name(SetBool) == "std_srvs/srv/SetBool"
    assert get_message("lifecycle_msgs/srv/ChangeState_Request") is ChangeState.Request


@pytest.mark.parametrize(
    "name",
    [
        "",
        "Image",
        "sensor_msgs/Image",
        "sensor_msgs/msg/Imag",
        "sensor_msgs/msg/np",
        "no_such_package/msg/Image",
        "os.path/msg/Image",
        "std_srvs/srv/SetBool",
        "_codec/msg/Message",
        "std_msgs/msg/" + "A" * 300,
    ],
)
def test_an_unknown_message_is_an_interface_error(name: str) -> None:
    with pytest.raises(InterfaceError, match="There is no message"):
        get_message(name)


@pytest.mark.parametrize("name", ["", "SetBool", "std_srvs/msg/SetBool", "sensor_msgs/srv/Image"])
def test_an_unknown_service_is_an_interface_error(name: str) -> None:
    with pytest.raises(InterfaceError, match="There is no service"):
        get_service(name)


def test_a_definition_is_followed_by_those_that_it_uses() -> None:
    text = message_definition(Image)
    assert text.startswith("std_msgs/Header header\nuint32 height\n")
    assert [line for line in text.splitlines() if line.startswith("MSG:")] == [
        "MSG: std_msgs/Header",
        "MSG: builtin_interfaces/Time",
    ]


def test_the_definitions_of_request_and_response_are_apart() -> None:
    assert message_definition(SetBool.Request) == "bool data\n"
    assert message_definition(SetBool.Response) == "bool success\nstring message\n"
    assert message_definition(GetState.Request) == ""
    assert message_definition(String) == "string data\n"
    assert message_definition(Gid) == "char[16] data\n"
