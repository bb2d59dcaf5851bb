"""What endpoints and participants say of themselves, as real ROS 2 nodes do."""

import re
import struct
from typing import TYPE_CHECKING, Any

import pytest
from cyclonedds.qos import Policy

from rmw.peer import LATCHED, Peer, payload, text
from sunset_ros import Context, Node
from sunset_ros.interfaces.rcl_interfaces.srv import GetParameters
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.lifecycle import LifecycleNode
from sunset_ros.rmw.core.port import EndpointKind
from sunset_ros.rmw.core.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

if TYPE_CHECKING:
    from .conftest import Live

FOREVER = 2**63 - 1
STRING = "std_msgs::msg::dds_::String_"
DISCOVERY = ("ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_")
DISCOVERY_HASH = b"typehash=RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e;"
STRING_HASH = b"typehash=RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18;"
"""Both of a real Jazzy installation."""


class Sampler(LifecycleNode):
    """Has one endpoint of every kind."""

    def __init__(self, context: Context) -> None:
        super().__init__("sampler", context=context)
        self.create_publisher(String, "default", 10)
        self.create_subscription(String, "default", print, 10)
        self.create_client(GetParameters, "elsewhere/get_parameters")
        self._time_source.use_sim_time(True)


def qos(depth: int, *, reliable: bool = True, latched: bool = False) -> dict[str, object]:
    """Return the policies that a real node announces."""
    return {
        "Reliability": Policy.Reliability.Reliable(FOREVER) if reliable else Policy.Reliability.BestEffort,
        "Durability": Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile,
        "History": Policy.History.KeepLast(depth),
        "Liveliness": Policy.Liveliness.Automatic(FOREVER),
        "DataRepresentation": Policy.DataRepresentation(use_cdrv0_representation=True),
    }


SERVICE, PARAMETERS = qos(10), qos(1000)
WRITERS = {
    "rt/default": qos(10),
    "rt/parameter_events": qos(1000),
    "rt/rosout": qos(1000, latched=True),
    "rt/sampler/transition_event": qos(10),
    "rr/sampler/get_parametersReply": PARAMETERS,
    "rr/sampler/set_parameters_atomicallyReply": PARAMETERS,
    "rr/sampler/change_stateReply": SERVICE,
    "rq/elsewhere/get_parametersRequest": SERVICE,
    "ros_discovery_info": qos(1, latched=True),
}
READERS = {
    "rt/default": qos(10),
    "rt/clock": qos(1, reliable=False),
    "rq/sampler/describe_parametersRequest": PARAMETERS,
    "rq/sampler/get_stateRequest": SERVICE,
    "rr/elsewhere/get_parametersReply": SERVICE,
    "ros_discovery_info": {**qos(1, latched=True), "History": Policy.History.KeepAll},
}


def announced(endpoint: Any, policies: dict[str, object]) -> dict[str, object]:
    """Return those policies of an endpoint."""
    found = Peer.policies(endpoint)
    return {name: found[name] for name in policies}


def user_data(announcement: Any) -> bytes:
    """Return what else is said of an endpoint or participant."""
    data: bytes = Peer.policies(announcement)["Userdata"].data
    return data


@pytest.mark.parametrize("topic", WRITERS)
def test_writers_announce_the_quality_of_service_of_ros(live: "Live", topic: str) -> None:
    live.executor(Sampler)
    (writer,) = live.peer().writers(topic)
    assert announced(writer, WRITERS[topic]) == WRITERS[topic]
    others = Peer.policies(writer)
    assert others["WriterDataLifecycle"] == Policy.WriterDataLifecycle(autodispose=False)
    assert others["Lifespan"] == Policy.Lifespan(10 * 10**9 if topic == "rt/rosout" else FOREVER)
    assert writer.type_id is None


@pytest.mark.parametrize("topic", READERS)
def test_readers_announce_the_quality_of_service_of_ros(live: "Live", topic: str) -> None:
    live.executor(Sampler)
    (reader,) = live.peer().readers(topic)
    assert announced(reader, READERS[topic]) == READERS[topic]
    assert reader.type_id is None


def test_a_latched_writer_keeps_for_late_comers_what_it_keeps(live: "Live") -> None:
    live.executor(Sampler)
    (writer,) = live.peer().writers("rt/rosout")
    assert Peer.policies(writer)["DurabilityService"] == Policy.DurabilityService(
        0, Policy.History.KeepLast(1000), -1, -1, -1
    )


def test_user_data_tell_enclave_and_type(live: "Live") -> None:
    live.executor(Sampler)
    peer = live.peer()
    participant = peer.participants()[peer.other_participant()]
    assert user_data(participant) == b"enclave=/;"
    for topic, type_name, type_hash in (("rt/default", STRING, STRING_HASH), (*DISCOVERY, DISCOVERY_HASH)):
        for endpoints in (peer.writers(topic), peer.readers(topic)):
            (endpoint,) = endpoints
            assert user_data(endpoint) == type_hash
            assert endpoint.type_name == type_name


def test_both_ends_of_a_service_and_of_a_client_carry_an_id_of_their_own(live: "Live") -> None:
    live.executor(Sampler)
    peer = live.peer()
    guid = peer.other_participant()
    first, *others = guid[:12]
    seen = set()
    for name, service in (
        ("serviceid", "/sampler/get_parameters"),
        ("serviceid", "/sampler/get_state"),
        ("clientid", "/elsewhere/get_parameters"),
    ):
        request, reply = f"rq{service}Request", f"rr{service}Reply"
        (reader,) = peer.readers(request if name == "serviceid" else reply)
        (writer,) = peer.writers(reply if name == "serviceid" else request)
        ends = [
            re.fullmatch(rf"{name}=([^;]*);typehash=RIHS01_[0-9a-f]{{64}};", user_data(end).decode())
            for end in (reader, writer)
        ]
        assert ends[0]
        assert ends[1]
        assert ends[0][1] == ends[1][1]
        assert ends[0][1].startswith(
            ".".join([f"{first:x}".rjust(2), *(f"{byte:x}" for byte in others), "0.0.0."])
        )
        seen.add(ends[0][1])
    assert len(seen) == 3


def test_humble_knows_no_type_hashes(live: "Live") -> None:
    live.process(distro="humble").create_node("node", "/").create_publisher(String, "/chatter", QoSProfile())
    peer = live.peer()
    for topic in ("rt/chatter", "ros_discovery_info"):
        (writer,) = peer.writers(topic)
        assert "Userdata" not in Peer.policies(writer)


def test_endpoints_of_others_are_described(live: "Live") -> None:
    process = live.process()
    peer = live.peer()
    peer.writer("rt/chatter", STRING, LATCHED)
    peer.reader("rq/server/setRequest", "std_srvs::srv::dds_::SetBool_Request_")
    peer.writer("chatter", STRING)  # no ROS name
    assert peer.wait(lambda: len(process.endpoints()) == 2)
    publisher, service = process.endpoints()
    assert (publisher.kind, publisher.name, publisher.type_name) == (
        EndpointKind.PUBLISHER,
        "/chatter",
        "std_msgs/msg/String",
    )
    assert publisher.qos == QoSProfile(
        depth=1,
        history=HistoryPolicy.KEEP_LAST,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )
    assert (publisher.node_name, publisher.node_namespace) == (
        "_NODE_NAME_UNKNOWN_",
        "_NODE_NAMESPACE_UNKNOWN_",
    )
    assert (service.kind, service.name, service.type_name) == (
        EndpointKind.SERVICE,
        "/server/set",
        "std_srvs/srv/SetBool",
    )
    assert process.endpoints("/server/set") == [service]
    assert process.endpoints("/nothing") == []


def test_the_graph_follows_nodes_that_come_and_go(live: "Live") -> None:
    process = live.process()
    other = live.executor(lambda context: Node("here", context=context, namespace="/uav"))
    assert process.wait_for(lambda: process.nodes() == [("here", "/uav")], 10**10)
    (node,) = other.get_nodes()
    assert process.wait_for(
        lambda: [info.node_name for info in process.endpoints("/rosout")] == ["here"], 10**10
    )
    node.destroy_node()
    assert process.wait_for(lambda: process.nodes() == [] and process.endpoints() == [], 10**10)


def test_participants_that_came_and_went_meanwhile_are_no_problem(live: "Live") -> None:
    process = live.process()
    with process.link._looking:  # as on a computer that is busy
        for _ in range(3):
            other = live.process()
            other.create_node("short", "/")
            other.shutdown()
    assert process.nodes() == []
    assert not process.problems


def test_nodes_of_a_participant_that_is_not_there_are_dropped(live: "Live") -> None:
    process = live.process()
    peer = live.peer()
    writer = peer.writer(*DISCOVERY, LATCHED)
    assert peer.wait(lambda: bool(writer.get_matched_subscriptions()))
    Peer.send(writer, payload(bytes(range(16)) + struct.pack("<I", 1) + text("/") + text("ghost") + bytes(8)))
    peer.wait(lambda: False, 0.3)
    assert process.nodes() == []
