"""What SUNSET sends and understands, byte by byte, as captured from real ROS 2 nodes."""

import struct
from typing import TYPE_CHECKING

import pytest

from rmw.peer import LATCHED, header, payload, text
from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces.lifecycle_msgs.srv import GetState
from sunset_ros.interfaces.std_msgs.msg import Empty, Header, String
from sunset_ros.interfaces.std_srvs.srv import SetBool
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.dds._graph import NodeEntities, Participant, decode_participant, encode_participant

if TYPE_CHECKING:
    from .conftest import Live

STRING = "std_msgs::msg::dds_::String_"
DISCOVERY = ("ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_")
SET_REQUEST = ("rq/server/setRequest", "std_srvs::srv::dds_::SetBool_Request_")
SET_REPLY = ("rr/server/setReply", "std_srvs::srv::dds_::SetBool_Response_")

CAPTURED_REQUEST = bytes.fromhex("00010000 ef0ec8e67715180c 0100000000000000 01000000")
"""SetBool(true), as a real rclpy client sent it."""

RESPONSE_TO_IT = bytes.fromhex("00010000 ef0ec8e67715180c 0100000000000000 01000000 03000000 6f6b0000")
"""success: true, message: ok."""

GUID = bytes.fromhex("0110d5b9fc33ea905b40d70d000001c1")
READER = bytes.fromhex("0110d5b9fc33ea905b40d70d00000104")
WRITER = bytes.fromhex("0110d5b9fc33ea905b40d70d00000203")
ANNOUNCEMENT = bytes.fromhex(
    "00010000"
    "0110d5b9fc33ea905b40d70d000001c1"
    "01000000"
    "02000000 2f000000"  # "/"
    "0f000000 5f726f7332636c695f33313230360000"  # "_ros2cli_31206"
    "01000000 0110d5b9fc33ea905b40d70d00000104"
    "01000000 0110d5b9fc33ea905b40d70d00000203"
)
HUMBLES = bytes.fromhex(
    "00010000"
    "0110d5b9fc33ea905b40d70d000001c1 0000000000000000"
    "01000000"
    "02000000 2f000000"
    "0f000000 5f726f7332636c695f33313230360000"
    "01000000 0110d5b9fc33ea905b40d70d00000104 0000000000000000"
    "01000000 0110d5b9fc33ea905b40d70d00000203 0000000000000000"
)
NODES = (NodeEntities("/", "_ros2cli_31206", (READER,), (WRITER,)),)


def test_a_topic_sample(live: "Live") -> None:
    node, _ = live.node()
    peer = live.peer()
    reader = peer.reader("rt/chatter", STRING)
    publisher = node.create_publisher(String, "/chatter", 10)
    assert peer.wait(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(String(data="hi"))
    assert peer.collect(reader, 1) == [bytes.fromhex("00010000 03000000 68690000")]


def test_a_message_without_fields_is_one_octet(live: "Live") -> None:
    node, _ = live.node()
    peer = live.peer()
    reader = peer.reader("rt/ping", "std_msgs::msg::dds_::Empty_")
    publisher = node.create_publisher(Empty, "/ping", 10)
    assert peer.wait(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(Empty())
    assert peer.collect(reader, 1) == [bytes.fromhex("00010000 00000000")]


def test_a_topic_sample_is_understood(live: "Live") -> None:
    node, executor = live.node()
    peer = live.peer()
    seen: list[Header] = []
    subscription = node.create_subscription(Header, "/headers", seen.append, 10)
    writer = peer.writer("rt/headers", "std_msgs::msg::dds_::Header_")
    assert peer.wait(lambda: subscription.get_publisher_count() == 1)
    peer.send(writer, bytes.fromhex("00010000 01000000 02000000 07000000 63616d6572610000"))
    assert live.spin(executor, lambda: bool(seen))
    assert (seen[0].stamp.sec, seen[0].stamp.nanosec, seen[0].frame_id) == (1, 2, "camera")


def test_a_request_and_its_response(live: "Live") -> None:
    node, executor = live.node()
    peer = live.peer()
    requests = peer.reader(*SET_REQUEST, user_data=b"serviceid=1;")
    replies = peer.writer(*SET_REPLY, user_data=b"serviceid=1;")
    client = node.create_client(SetBool, "/server/set")
    assert client.wait_for_service(10.0)
    futures = [client.call_async(SetBool.Request(data=data)) for data in (True, False)]
    first, second = peer.collect(requests, 2)
    client_id = first[4:12]
    assert first == payload(client_id + struct.pack("<q", 1) + b"\x01")
    assert second == payload(client_id + struct.pack("<q", 2) + b"\x00")
    assert len(first) == len(CAPTURED_REQUEST)
    for head in (header(12345, 1), second[4:20], first[4:20]):
        peer.send(replies, payload(head + b"\x01\x00\x00\x00" + text(head.hex())))
    assert live.spin(executor, lambda: all(future.done() for future in futures))
    assert [future.result() for future in futures] == [
        SetBool.Response(success=True, message=sample[4:20].hex()) for sample in (first, second)
    ]


def test_a_request_is_answered(live: "Live") -> None:
    node, executor = live.node("server")
    node.create_service(
        SetBool, "~/set", lambda request, _: SetBool.Response(success=request.data, message="ok")
    )
    peer = live.peer()
    replies = peer.reader(*SET_REPLY, user_data=b"clientid=1.2;")
    requests = peer.writer(*SET_REQUEST, user_data=b"clientid=1.2;")
    assert peer.wait(
        lambda: bool(requests.get_matched_subscriptions() and replies.get_matched_publications())
    )
    peer.send(requests, CAPTURED_REQUEST)
    assert live.collect(executor, replies, 1) == [RESPONSE_TO_IT]


def test_a_request_without_fields_is_one_octet_behind_the_header(live: "Live") -> None:
    node, _ = live.node()
    peer = live.peer()
    requests = peer.reader("rq/a/get_stateRequest", "lifecycle_msgs::srv::dds_::GetState_Request_")
    client = node.create_client(GetState, "/a/get_state")
    assert peer.wait(lambda: len(requests.get_matched_publications()) == 1)
    client.call_async(GetState.Request())
    (sample,) = peer.collect(requests, 1)
    assert sample == payload(sample[4:20] + b"\x00")


@pytest.mark.parametrize(("size", "sample"), [(16, ANNOUNCEMENT), (24, HUMBLES)])
def test_an_announcement(size: int, sample: bytes) -> None:
    participant = Participant(GUID, NODES, size)
    assert encode_participant(participant) == sample
    assert decode_participant(sample) == participant


@pytest.mark.parametrize(("size", "sample"), [(16, ANNOUNCEMENT[:20]), (24, HUMBLES[:28])])
def test_the_announcement_of_a_participant_that_leaves(size: int, sample: bytes) -> None:
    empty = Participant(GUID, (), size)
    assert encode_participant(empty) == sample + bytes(4)
    assert decode_participant(sample + bytes(4)) == empty


@pytest.mark.parametrize(
    "sample",
    [
        b"",
        b"\x00\x01\x00\x00",
        ANNOUNCEMENT[:-1],
        ANNOUNCEMENT + bytes(4),
        b"\x00\x00" + ANNOUNCEMENT[2:],
        ANNOUNCEMENT.replace(b"/\x00", b"\xff\x00"),
        ANNOUNCEMENT.replace(b"/\x00", b"//"),
        ANNOUNCEMENT[:20] + b"\xff\xff\xff\xff" + ANNOUNCEMENT[24:],
    ],
)
def test_a_malformed_announcement_is_refused(sample: bytes) -> None:
    with pytest.raises(InterfaceError):
        decode_participant(sample)


@pytest.mark.parametrize(("distro", "padding"), [("jazzy", b""), ("humble", bytes(8))])
def test_a_process_announces_its_nodes(live: "Live", distro: str, padding: bytes) -> None:
    process = live.process(distro=distro)
    peer = live.peer()
    guid = peer.other_participant()
    process.create_node("talker", "/uav").create_publisher(String, "/chatter", QoSProfile())
    process.create_node("idle", "/")
    assert peer.wait(lambda: len(peer.writers("rt/chatter")) == 1)
    (writer,) = peer.writers("rt/chatter")
    assert peer.collect(peer.reader(*DISCOVERY, qos=LATCHED), 1) == [
        payload(
            guid
            + padding
            + struct.pack("<I", 2)
            + text("/uav")
            + text("talker")
            + struct.pack("<II", 0, 1)
            + writer.key.bytes
            + padding
            + text("/")
            + text("idle")
            + struct.pack("<II", 0, 0)
        )
    ]


def test_gids_shrink_when_others_have_short_ones(live: "Live") -> None:
    process = live.process()
    process.create_node("node", "/")
    peer = live.peer()
    mine = peer.participant.guid.bytes
    reader, writer = peer.reader(*DISCOVERY, qos=LATCHED), peer.writer(*DISCOVERY, qos=LATCHED)
    assert [len(sample) for sample in peer.collect(reader, 1)] == [4 + 24 + 4 + 8 + 12 + 8]
    peer.send(writer, payload(mine + bytes(4)))
    own, others = peer.collect(reader, 2)
    assert (len(own), len(others)) == (24, 4 + 16 + 4 + 8 + 12 + 8)
