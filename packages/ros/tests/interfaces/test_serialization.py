from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces import (
    Message,
    deserialize,
    get_message,
    message_definition,
    serialize,
    type_name,
)
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from sunset_ros.interfaces.lifecycle_msgs.srv import GetState
from sunset_ros.interfaces.rcl_interfaces.msg import (
    FloatingPointRange,
    Parameter,
    ParameterDescriptor,
    ParameterEvent,
    ParameterValue,
)
from sunset_ros.interfaces.rmw_dds_common.msg import Gid, NodeEntitiesInfo
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import (
    Bool,
    Float32,
    Float64,
    Float64MultiArray,
    Header,
    Int8,
    String,
    UInt64,
)
from sunset_ros.interfaces.std_srvs.srv import SetBool

HEADER_HEX = "0001000001000000020000000400000063616d00"


@pytest.fixture(scope="module")
def store() -> Typestore:
    """An independent implementation of CDR, of the standard messages from its own definitions."""
    return get_typestore(Stores.ROS2_JAZZY)


def known_to(store: Typestore, kind: type[Message]) -> str:
    """Return the name by which `store` knows a message, after teaching it those that it does not."""
    name = type_name(kind).replace("/srv/", "/msg/")
    if name not in store.fielddefs:
        parsed = get_types_from_msg(message_definition(kind), name)
        for _, fields in parsed.values():
            if not fields:
                fields.append(("structure_needs_at_least_one_member", (Nodetype.BASE, ("uint8", 0))))
        store.register(parsed)
    return name


def plain(value: object) -> object:
    """Return a value of either implementation as lists, numbers and strings."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, bytes):
        return int.from_bytes(value, signed=True)
    if isinstance(value, list):
        return [plain(item) for item in value]
    names = getattr(value, "__dataclass_fields__", None) or getattr(value, "__ros_fields__", None)
    if names is None:
        return value
    return {
        name: plain(getattr(value, name))
        for name in names
        if not name.startswith(("__", "structure_needs")) and not name.isupper()
    }


def test_every_message_survives_the_wire(examples: list[Message]) -> None:
    for message in examples:
        assert deserialize(serialize(message), type(message)) == message


def test_every_payload_is_padded_to_four_bytes(examples: list[Message]) -> None:
    assert {len(serialize(message)) % 4 for message in examples} == {0}


def test_an_independent_implementation_writes_the_same_bytes(
    examples: list[Message], store: Typestore
) -> None:
    name = known_to(store, type(examples[0]))
    for message in examples:
        payload = serialize(message)
        theirs = store.deserialize_cdr(payload, name)
        again = bytes(store.serialize_cdr(theirs, name))
        assert again + bytes(-len(again) % 4) == payload


def test_an_independent_implementation_reads_the_same_values(
    examples: list[Message], store: Typestore
) -> None:
    name = known_to(store, type(examples[0]))
    for message in examples:
        expected = {} if not message.__ros_fields__ else plain(message)
        assert plain(store.deserialize_cdr(serialize(message), name)) == expected


def test_a_header_has_these_bytes() -> None:
    message = Header(stamp=Time(sec=1, nanosec=2), frame_id="cam")
    assert serialize(message).hex() == HEADER_HEX
    assert deserialize(bytes.fromhex(HEADER_HEX), Header) == message


def test_an_image_has_these_bytes() -> None:
    image = Image(
        header=Header(stamp=Time(sec=1, nanosec=2), frame_id="cam"),
        height=1,
        width=2,
        encoding="8UC1",
        step=2,
        data=b"\x07\x08",
    )
    tail = "0100000002000000050000003855433100000000020000000200000007080000"
    assert serialize(image).hex() == HEADER_HEX + tail


def test_a_set_bool_request_has_the_bytes_captured_from_a_real_node() -> None:
    assert serialize(SetBool.Request(data=True)).hex() == "0001000001000000"


def test_a_message_without_fields_is_one_octet() -> None:
    assert serialize(GetState.Request()).hex() == "0001000000000000"
    assert deserialize(bytes.fromhex("0001000000"), GetState.Request) == GetState.Request()
    with pytest.raises(InterfaceError, match="needs one octet"):
        deserialize(bytes.fromhex("00010000"), GetState.Request)


def test_eight_byte_numbers_are_aligned_behind_the_encapsulation_header() -> None:
    message = Float64MultiArray(data=[1.0])
    assert serialize(message).hex() == "0001000000000000000000000100000000000000000000000000f03f"


def test_an_empty_sequence_of_eight_byte_numbers_adds_no_padding() -> None:
    assert serialize(Float64MultiArray()).hex() == "00010000000000000000000000000000"


def test_arrays_from_the_wire_look_at_the_payload_and_are_read_only() -> None:
    payload = serialize(Image(data=np.arange(100, dtype=np.uint8)))
    image = deserialize(payload, Image)
    assert np.shares_memory(image.data, np.frombuffer(payload, np.uint8))
    assert not image.data.flags.writeable


def test_payloads_may_come_in_any_buffer() -> None:
    payload = serialize(String(data="hallo"))
    assert deserialize(bytearray(payload), String) == deserialize(memoryview(payload), String)


def test_numpy_scalars_and_plain_sequences_are_accepted() -> None:
    message = ParameterValue()
    message.bool_value = np.True_  # type: ignore[assignment]
    message.integer_value = np.int32(-4)  # type: ignore[assignment]
    message.double_value = 3
    message.double_array_value = [1, 2.5]  # type: ignore[assignment]
    message.string_array_value = ("a", "b")  # type: ignore[assignment]
    back = deserialize(serialize(message), ParameterValue)
    assert (back.bool_value, back.integer_value, back.double_value) == (True, -4, 3.0)
    assert back.double_array_value.tolist() == [1.0, 2.5]
    assert back.string_array_value == ["a", "b"]


@pytest.mark.parametrize(
    ("message", "sentence"),
    [
        (Bool(data=1.5), "'data' of std_msgs/msg/Bool must be True or False, got float 1.5"),  # type: ignore[arg-type]
        (Bool(data=None), "must be True or False, got NoneType None"),  # type: ignore[arg-type]
        (Bool(data=[]), "must be True or False, got list"),  # type: ignore[arg-type]
        (Int8(data=128), "'data' of std_msgs/msg/Int8 must be a whole number from -128 to 127, got int 128"),
        (UInt64(data=-1), "must be a whole number from 0 to 18446744073709551615"),
        (Int8(data="1"), "must be a whole number from -128 to 127, got str '1'"),  # type: ignore[arg-type]
        (Float32(data="1"), "must be a number, got str"),  # type: ignore[arg-type]
        (Float32(data=1e39), "must be a number that fits 32 bits, got float 1e[+]39"),
        (Float32(data=10**400), "must be a number that fits 32 bits"),
        (Float64(data=10**400), "must be a number that fits 64 bits"),
        (String(data=7), "'data' of std_msgs/msg/String must be a string, got int 7"),  # type: ignore[arg-type]
        (String(data="\ud800"), "must be a string that UTF-8 can express"),
        (Header(stamp=None), None),
        (DiagnosticStatus(level=0), "'level' of diagnostic_msgs/msg/DiagnosticStatus must be one byte"),  # type: ignore[arg-type]
        (DiagnosticStatus(level=b"ab"), "must be one byte"),
        (DiagnosticStatus(values=[KeyValue(), KeyValue(key=3)]), r"Field 'values\[1\].key' of"),  # type: ignore[arg-type]
        (DiagnosticStatus(values=KeyValue()), "'values' of .* must be a list"),  # type: ignore[arg-type]
        (DiagnosticStatus(values=[Time()]), r"'values\[0\]' of .* must be a diagnostic_msgs/msg/KeyValue"),  # type: ignore[list-item]
        (ParameterValue(byte_array_value=[b"a", b""]), r"'byte_array_value\[1\]' of .* must be one byte"),
        (ParameterValue(byte_array_value=b"ab"), "'byte_array_value' of .* must be a list"),  # type: ignore[arg-type]
        (ParameterValue(bool_array_value=[True, 2]), r"'bool_array_value\[1\]' of .* must be True or False"),  # type: ignore[list-item]
        (ParameterValue(string_array_value=["a", 2]), r"'string_array_value\[1\]' of"),  # type: ignore[list-item]
        (
            ParameterDescriptor(floating_point_range=[FloatingPointRange()] * 2),
            "'floating_point_range' of .* must be of at most 1 elements",
        ),
        (NodeEntitiesInfo(node_name="x" * 257), "'node_name' of .* must be a string of at most 256 bytes"),
        (NodeEntitiesInfo(reader_gid_seq=[Gid(data=[1])]), r"'reader_gid_seq\[0\].data' of .* 16 elements"),
    ],
)
def test_what_does_not_fit_is_named_in_one_sentence(message: Message, sentence: str | None) -> None:
    if sentence is None:
        assert deserialize(serialize(message), type(message)) == message
        return
    with pytest.raises(InterfaceError, match=sentence) as caught:
        serialize(message)
    text = str(caught.value)
    assert text.endswith(".")
    assert "\n" not in text


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (np.zeros((2, 3), np.uint8), "one-dimensional"),
        ([256], "from 0 to 255"),
        ([-1], "from 0 to 255"),
        ([1.5], "an array of uint8"),
        (["a"], "an array of uint8"),
        ([[1], [2, 3]], "an array of uint8"),
        (None, "an array of uint8"),
    ],
)
def test_an_array_that_does_not_fit_is_named(value: object, expected: str) -> None:
    image = Image()
    image.data = value  # type: ignore[assignment]
    with pytest.raises(InterfaceError, match=rf"Field 'data' of sensor_msgs/msg/Image must be .*{expected}"):
        serialize(image)


def test_a_nested_message_that_is_missing_is_named() -> None:
    event = ParameterEvent()
    event.stamp = None  # type: ignore[assignment]
    with pytest.raises(
        InterfaceError, match=r"'stamp' of .*/ParameterEvent must be a builtin_interfaces/msg/Time"
    ):
        serialize(event)


def test_only_messages_are_serialized() -> None:
    with pytest.raises(InterfaceError, match="Only a message can be serialized, got 3"):
        serialize(3)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("payload", "expected"),
    [
        ("", "starts with 0001, got nothing"),
        ("0000000000000001", "starts with 0001, got 00000000"),
        ("000100", "not a std_msgs/msg/String"),
        ("00010000", "not a std_msgs/msg/String"),
        ("0001000000000000", "no terminator"),
        ("000100000200000061", "not a std_msgs/msg/String"),
        ("00010000020000006162", "no terminator"),
        ("00010000ffffffff6100", "not a std_msgs/msg/String"),
        ("0001000002000000ff00", "can't decode"),
        ("00010000010000000000000000", "not a std_msgs/msg/String, which ends at byte 9"),
    ],
)
def test_a_malformed_payload_is_refused(payload: str, expected: str) -> None:
    with pytest.raises(InterfaceError, match=expected):
        deserialize(bytes.fromhex(payload), String)


def test_every_truncation_is_refused(make_random: Callable[[type[Message], int], Message]) -> None:
    for seed in range(5):
        payload = serialize(make_random(Parameter, seed))
        end = len(payload.rstrip(b"\0"))
        for size in range(end):
            with pytest.raises(InterfaceError, match="payload"):
                deserialize(payload[:size], Parameter)


@given(st.sampled_from(["rcl_interfaces/msg/Parameter", "sensor_msgs/msg/Image"]), st.binary(max_size=120))
def test_arbitrary_bytes_give_a_message_or_an_interface_error(name: str, body: bytes) -> None:
    kind = get_message(name)
    try:
        message = deserialize(b"\0\1\0\0" + body, kind)
    except InterfaceError:
        return
    assert isinstance(message, kind)


@given(st.integers(0, 10**6), st.integers(min_value=4), st.integers(0, 255))
def test_a_flipped_byte_gives_a_message_or_an_interface_error(seed: int, place: int, value: int) -> None:
    rng = np.random.default_rng(seed)
    event = ParameterEvent(
        node="/a",
        new_parameters=[
            Parameter(name="p" * int(rng.integers(9)), value=ParameterValue(integer_array_value=[3, 4]))
        ],
    )
    payload = bytearray(serialize(event))
    payload[4 + place % (len(payload) - 4)] = value
    try:
        assert isinstance(deserialize(payload, ParameterEvent), ParameterEvent)
    except InterfaceError as error:
        assert "rcl_interfaces/msg/ParameterEvent" in str(error)  # noqa: PT017  both ends are right
