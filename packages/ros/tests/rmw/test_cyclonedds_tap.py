"""What an observer of a live network is told."""

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pytest
from cyclonedds._clayer import ddspy_write_ts

from rmw.peer import LATCHED, Peer, header, payload, text
from sunset_ros import Node
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.std_msgs.msg import Int32, String
from sunset_ros.interfaces.std_srvs.srv import SetBool
from sunset_ros.rmw.core.port import EndpointKind, RequestId
from sunset_ros.rmw.core.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sunset_ros.rmw.core.tap import Tap
from sunset_ros.rmw.dds import CycloneTap, _tap
from sunset_ros.rmw.dds import _library as dds
from sunset_ros.rmw.dds._graph import NodeEntities, Participant

if TYPE_CHECKING:
    from .conftest import Live

S = 10**9
IGNORED_SERVICES = ("parameter",)


class Notes(Tap):
    """Writes down what it is told, less what every node has."""

    def __init__(self) -> None:
        self.nodes: list[str] = []
        self.endpoints: list[tuple[str, EndpointKind, str]] = []
        self.messages: list[tuple[str, str, Message]] = []
        self.times: list[int] = []
        self.calls: list[tuple[str, ...]] = []
        self.ids: list[RequestId] = []
        self.noted = threading.Event()

    def on_node(self, process: str, node: str) -> None:
        assert process == ""
        self.nodes.append(node)

    def on_endpoint(self, node: str, kind: EndpointKind, name: str) -> None:
        if not any(ignored in name for ignored in IGNORED_SERVICES):
            self.endpoints.append((node, kind, name))

    def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
        if topic not in {"/parameter_events", "/rosout"}:
            self.messages.append((topic, node, message))
            self.times.append(time_ns)

    def on_request(  # noqa: PLR0917  as of Tap
        self, time_ns: int, service: str, client: str, server: str, request: Message, request_id: RequestId
    ) -> None:
        self.calls.append(("request", service, client, server, repr(request)))
        self.times.append(time_ns)
        self.ids.append(request_id)

    def on_response(
        self, time_ns: int, service: str, server: str, response: Message, request_id: RequestId
    ) -> None:
        self.calls.append(("response", service, server, repr(response)))
        self.times.append(time_ns)
        self.ids.append(request_id)


def until(predicate: Callable[[], bool], seconds: float = 10.0) -> bool:
    end = time.monotonic() + seconds
    while not predicate() and time.monotonic() < end:
        threading.Event().wait(0.01)
    return predicate()


def tapped(live: "Live", notes: Tap) -> CycloneTap:
    return CycloneTap(notes, domain_id=live.domain_id, environment={})


def test_it_sees_every_message_in_the_order_of_sending(live: "Live") -> None:
    notes = Notes()
    with tapped(live, notes):
        node, _ = live.node("talker")
        publishers = [node.create_publisher(Int32, topic, 5) for topic in ("/a", "/b")]
        assert until(lambda: all(publisher.get_subscription_count() == 1 for publisher in publishers))
        before = time.time_ns()
        for number in range(400):
            publishers[number % 2].publish(Int32(data=number))
            if number % 4 == 3:
                threading.Event().wait(0.002)
        after = time.time_ns()
    assert [message for _, _, message in notes.messages] == [Int32(data=number) for number in range(400)]
    assert {(topic, node) for topic, node, _ in notes.messages} == {("/a", "/talker"), ("/b", "/talker")}
    assert notes.times == sorted(notes.times)
    assert before <= notes.times[0] <= notes.times[-1] <= after


def test_it_sees_who_asks_whom_and_what_is_answered(live: "Live") -> None:
    notes = Notes()
    with tapped(live, notes):
        server, serving = live.node("server")
        service = server.create_service(
            SetBool, "~/set", lambda request, _: SetBool.Response(success=request.data)
        )
        node, executor = live.node("client")
        client = node.create_client(SetBool, "/server/set")
        assert client.wait_for_service(10.0)
        assert until(lambda: ("/server", EndpointKind.SERVICE, "/server/set") in notes.endpoints)
        assert until(lambda: "/client" in notes.nodes)
        ends: list[Any] = [service.handle, client.handle]
        assert until(lambda: all(len(dds.matched_subscriptions(end._writer)) == 2 for end in ends))
        threading.Event().wait(0.2)
        for data in (True, False):
            future = client.call_async(SetBool.Request(data=data))
            while not future.done():
                serving.spin_once(timeout_sec=0.01)
                executor.spin_once(timeout_sec=0.01)
    assert notes.calls == [
        step
        for data in (True, False)
        for step in (
            ("request", "/server/set", "/client", "/server", repr(SetBool.Request(data=data))),
            ("response", "/server/set", "/server", repr(SetBool.Response(success=data))),
        )
    ]
    first, answered, second, _ = notes.ids
    assert first == answered
    assert first.client == second.client
    assert first.sequence < second.sequence


def test_it_sees_nodes_subscriptions_and_services(live: "Live") -> None:
    node, _ = live.node("early")
    node.create_subscription(String, "/chat", print, 10)
    notes = Notes()
    with tapped(live, notes):
        late, _ = live.node("late")
        late.create_service(SetBool, "~/set", lambda _, response: response)
        assert until(lambda: len(notes.endpoints) == 2)
        again, _ = live.node("late")
        assert until(lambda: len(notes.nodes) == 3)
    assert sorted(notes.nodes) == ["/early", "/late", "/late"]
    assert sorted(notes.endpoints, key=str) == [
        ("/early", EndpointKind.SUBSCRIPTION, "/chat"),
        ("/late", EndpointKind.SERVICE, "/late/set"),
    ]
    assert again.get_name() == "late"


def test_it_is_no_part_of_the_graph(live: "Live") -> None:
    server, _ = live.node("server")
    server.create_service(SetBool, "~/set", lambda _, response: response)
    server.create_publisher(String, "/chat", 10)
    notes = Notes()
    with tapped(live, notes):
        assert until(lambda: len(notes.endpoints) == 1)
        node, _ = live.node("client")
        client = node.create_client(SetBool, "/server/set")
        assert client.wait_for_service(10.0)
        assert node.get_node_names() == ["client", "server"]
        assert node.count_subscribers("/chat") == 0
        server.destroy_node()
        process = node.context.middleware
        assert process.wait_for(lambda: not client.service_is_ready(), 10 * S)
        assert process.wait_for(lambda: node.get_node_names() == ["client"], 10 * S)
        assert "/server/set" not in dict(node.get_service_names_and_types())


def test_it_hears_reliable_and_best_effort_writers_each_once(live: "Live") -> None:
    notes = Notes()
    with tapped(live, notes):
        node, _ = live.node("talker")
        for reliability in ReliabilityPolicy:
            publisher = node.create_publisher(String, "/chat", QoSProfile(reliability=reliability))
            assert until(lambda publisher=publisher: publisher.get_subscription_count() > 0)  # type: ignore[misc]
            threading.Event().wait(0.2)
            publisher.publish(String(data=reliability.name))
    assert [message for _, _, message in notes.messages] == [
        String(data="RELIABLE"),
        String(data="BEST_EFFORT"),
    ]


def test_it_gets_what_is_kept_for_late_comers(live: "Live") -> None:
    process = live.process()
    peer = live.peer()
    peer.send(peer.writer("rt/kept", "std_msgs::msg::dds_::String_", LATCHED), payload(bytes(4)))
    publisher = process.create_node("node", "/").create_publisher(
        Int32, "/latched", QoSProfile(durability=DurabilityPolicy.TRANSIENT_LOCAL)
    )
    publisher.publish(Int32(data=7))
    notes = Notes()
    with tapped(live, notes) as tap:
        assert until(lambda: bool(notes.messages))
    assert notes.messages == [("/latched", "/node", Int32(data=7))]
    assert tap.problems == {"/kept": 1}  # a string without its terminator


def heard_peer(live: "Live") -> tuple[Any, Any]:
    """Return a participant that is no node, and its writer of /numbers, which a tap hears."""
    live.process()
    peer = live.peer()
    writer = peer.writer("rt/numbers", "std_msgs::msg::dds_::Int32_")
    assert peer.wait(lambda: bool(writer.get_matched_subscriptions()))
    return peer, writer


def test_a_sender_that_is_no_node_has_no_name(live: "Live") -> None:
    notes = Notes()
    with tapped(live, notes):
        peer, writer = heard_peer(live)
        peer.send(writer, payload(b"\x01\x00\x00\x00"))
        assert until(lambda: bool(notes.messages))
    assert notes.messages == [("/numbers", "", Int32(data=1))]


def test_types_that_are_not_ours_are_passed_over(live: "Live") -> None:
    with tapped(live, Notes()) as tap:
        live.process()
        peer = live.peer()
        peer.writer("rt/scan", "sensor_msgs::msg::dds_::LaserScan_")
        peer.writer("rt/odd", "odd")
        assert until(lambda: set(tap.problems) == {"/scan", "/odd"})


def test_a_topic_that_cannot_be_heard_does_not_end_it(live: "Live") -> None:
    notes = Notes()
    with tapped(live, notes) as tap:
        live.process()
        peer = live.peer()
        peer.writer("rt/numbers", "std_msgs::msg::dds_::Int32_")
        assert peer.wait(lambda: bool(tap._writers))
        writer, *_ = tap._writers.values()
        # as another DDS announces it, for Cyclone has no such topics
        tap._queue.put((writer._replace(topic="rt/a b"), True))
        assert until(lambda: tap.problems["/a b"] == 1)
        live.node("late")
        assert until(lambda: "/late" in notes.nodes)


@pytest.mark.parametrize("years", [-10, 10])
def test_nobody_can_say_that_a_sample_was_sent_at_another_time(live: "Live", years: int) -> None:
    notes = Notes()
    with tapped(live, notes):
        _, writer = heard_peer(live)
        before = time.time_ns()
        assert ddspy_write_ts(writer._ref, payload(bytes(4)), before + years * 365 * 86400 * S) == 0
        assert until(lambda: bool(notes.messages))
    assert before - S <= notes.times[0] <= time.time_ns()


def test_a_request_that_nobody_gets_is_not_told(live: "Live") -> None:
    notes = Notes()
    with tapped(live, notes):
        live.process()
        peer: Peer = live.peer()
        writer = peer.writer("rq/nobody/setRequest", "std_srvs::srv::dds_::SetBool_Request_")
        assert peer.wait(lambda: bool(writer.get_matched_subscriptions()))
        peer.send(writer, payload(bytes(17)))
        peer.send(writer, payload(bytes(3)))
        threading.Event().wait(0.3)
    assert notes.calls == []


def test_a_request_that_comes_after_its_response_is_told_before_it(
    live: "Live", monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_tap, "_PATIENCE_NS", 60 * S)
    notes = Notes()
    with tapped(live, notes) as tap:
        live.process()
        peer: Peer = live.peer()
        asks = peer.writer("rq/late/setRequest", "std_srvs::srv::dds_::SetBool_Request_")
        answers = peer.writer("rr/late/setReply", "std_srvs::srv::dds_::SetBool_Response_")
        asked = peer.reader("rq/late/setRequest", "std_srvs::srv::dds_::SetBool_Request_")
        assert peer.wait(
            lambda: bool(asks.get_matched_subscriptions() and answers.get_matched_subscriptions())
        )
        entities = NodeEntities("/", "peer", (asked.guid.bytes,), (asks.guid.bytes, answers.guid.bytes))
        tap._queue.put(Participant(peer.participant.guid.bytes, (entities,)))
        assert until(lambda: "/peer" in notes.nodes)
        sent = time.time_ns()
        peer.send(answers, payload(header(1, 1) + bytes(4) + text("")))
        threading.Event().wait(0.3)
        assert ddspy_write_ts(asks._ref, payload(header(1, 1) + bytes(1)), sent) == 0
        assert until(lambda: len(notes.calls) > 1)
    assert [kind for kind, *_ in notes.calls] == ["request", "response"]


def test_what_a_tap_raises_comes_out_of_it(live: "Live") -> None:
    class Full(Tap):
        def on_node(self, process: str, node: str) -> None:
            raise OSError("disk full")

    tap = tapped(live, Full())
    tap.check()
    node: Node
    node, _ = live.node()

    def failed() -> bool:
        try:
            tap.check()
        except OSError:
            return True
        return False

    assert until(failed)
    with pytest.raises(OSError, match="disk full"):
        tap.finish()
    with pytest.raises(OSError, match="disk full"), tap:
        pass
    assert node.get_node_names() == ["node"]


def test_an_error_inside_its_context_is_not_replaced(live: "Live") -> None:
    notes: Any = Notes()
    with pytest.raises(LookupError, match="the caller's"), tapped(live, notes):
        raise LookupError("the caller's")
