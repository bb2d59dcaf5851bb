"""Services on DDS: who is asked, who is answered, and what is dropped."""

import threading
import time
from typing import TYPE_CHECKING, Any

import pytest

from rmw.peer import Peer, header, payload
from sunset_ros import CallbackError, Future, Node, SingleThreadedExecutor
from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces.std_srvs.srv import SetBool, Trigger
from sunset_ros.rmw.dds import _endpoints, _process

if TYPE_CHECKING:
    from .conftest import Live

REQUEST = ("rq/server/setRequest", "std_srvs::srv::dds_::SetBool_Request_")
REPLY = ("rr/server/setReply", "std_srvs::srv::dds_::SetBool_Response_")


def serve(live: "Live") -> tuple[Node, SingleThreadedExecutor]:
    """Start a server that answers with what it is asked."""
    node, executor = live.node("server")

    def set_to(request: SetBool.Request, _: SetBool.Response) -> SetBool.Response:
        return SetBool.Response(success=request.data)

    node.create_service(SetBool, "~/set", set_to)
    return node, executor


def request(client: int, number: int, *, data: bool = True) -> bytes:
    return payload(header(client, number) + bytes([data]))


def answered(samples: list[bytes]) -> list[bytes]:
    """Return the headers of responses."""
    return [sample[4:20] for sample in samples]


def matched(peer: Peer, *ends: Any) -> bool:
    """Wait until each end is connected to one other."""
    return peer.wait(
        lambda: all(
            len(
                end.get_matched_subscriptions()
                if hasattr(end, "matched_sub")
                else end.get_matched_publications()
            )
            == 1
            for end in ends
        )
    )


def asked_by_the_deaf(live: "Live", count: int) -> tuple[SingleThreadedExecutor, Peer, Any]:
    """Start a server and a client that does not listen but has asked so often; return both and what it asks with."""
    _, executor = serve(live)
    peer = live.peer()
    deaf = peer.writer(*REQUEST, user_data=b"clientid=7;")
    assert matched(peer, deaf)
    for number in range(1, count + 1):
        peer.send(deaf, request(7, number))
    return executor, peer, deaf


def test_a_client_is_answered_as_soon_as_it_listens(live: "Live") -> None:
    executor, peer, _ = asked_by_the_deaf(live, 1)
    listen: list[Any] = []
    late = threading.Timer(0.03, lambda: listen.append(peer.reader(*REPLY, user_data=b"clientid=7;")))
    late.start()
    assert live.spin(executor, lambda: bool(listen))
    late.join()
    assert answered(live.collect(executor, listen[0], 1)) == [header(7, 1)]


def test_a_client_that_listens_late_is_answered_late(live: "Live") -> None:
    executor, peer, _ = asked_by_the_deaf(live, 2)
    live.spin(executor, lambda: False, 0.4)
    listening = peer.reader(*REPLY, user_data=b"clientid=7;")
    assert answered(live.collect(executor, listening, 2)) == [header(7, 1), header(7, 2)]
    (process,) = live.processes
    assert not process.problems
    assert not process.alarms


def test_a_client_that_does_not_listen_delays_nobody_twice(
    live: "Live", monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_endpoints, "_LATE_NS", 200_000_000)
    executor, peer, deaf = asked_by_the_deaf(live, 50)
    (process,) = live.processes
    assert live.spin(executor, lambda: process.problems["/server/set"] == 10, 8.0)  # its queue holds ten
    listening = peer.reader(*REPLY, user_data=b"clientid=7;")
    assert matched(peer, listening)
    peer.send(deaf, request(7, 100))
    assert answered(live.collect(executor, listening, 1)) == [header(7, 100)]


def test_few_responses_wait_for_those_who_do_not_listen(
    live: "Live", monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_endpoints, "_LATE", 3)
    monkeypatch.setattr(_endpoints, "_LATE_NS", 60 * 10**9)
    executor, peer, _ = asked_by_the_deaf(live, 10)
    (process,) = live.processes
    assert live.spin(executor, lambda: process.problems["/server/set"] == 7)
    peer.leave()
    assert live.spin(executor, lambda: not process.alarms)  # who is gone is waited for no more
    assert process.problems["/server/set"] == 7


def serve_once(live: "Live") -> tuple[SingleThreadedExecutor, Peer]:
    """Let a client that does not listen ask a server that ends its process with its answer."""
    live.process()  # which stays, and the domain with it
    node, executor = live.node("server")

    def go(_: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        node.context.shutdown()
        return response

    node.create_service(SetBool, "~/set", go)
    peer = live.peer()
    requests = peer.writer(*REQUEST, user_data=b"clientid=1;")
    assert matched(peer, requests)
    peer.send(requests, request(1, 1))
    return executor, peer


def test_an_answer_leaves_before_the_process_does_though_its_client_listens_late(
    live: "Live", monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_process, "_PARTING_NS", 60 * 10**9)
    executor, peer = serve_once(live)
    listen: list[Any] = []
    late = threading.Timer(0.5, lambda: listen.append(peer.reader(*REPLY, user_data=b"clientid=1;")))
    late.start()
    live.spin(executor, lambda: not executor.context.ok())
    late.join()
    assert answered(peer.collect(listen[0], 1)) == [header(1, 1)]


def test_a_process_does_not_wait_long_for_a_client_that_never_listens(live: "Live") -> None:
    executor, _ = serve_once(live)
    began = time.monotonic()
    live.spin(executor, lambda: not executor.context.ok())
    assert time.monotonic() - began < 8.0  # a process that goes on tries for 10 s


def test_a_process_does_not_wait_for_a_client_that_is_gone(
    live: "Live", monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_process, "_PARTING_NS", 60 * 10**9)
    executor, peer = serve_once(live)
    threading.Timer(0.3, peer.leave).start()
    began = time.monotonic()
    live.spin(executor, lambda: not executor.context.ok())
    assert time.monotonic() - began < 10.0


def test_a_client_without_an_id_is_answered_at_once(live: "Live") -> None:
    _, executor = serve(live)
    peer = live.peer()
    replies, requests = peer.reader(*REPLY), peer.writer(*REQUEST)
    assert matched(peer, replies, requests)
    peer.send(requests, request(1, 1))
    assert answered(live.collect(executor, replies, 1)) == [header(1, 1)]


def test_new_clients_that_ask_at_once_are_all_answered(live: "Live") -> None:
    _, server = serve(live)
    ending = threading.Event()

    def run() -> None:
        while not ending.is_set():
            server.spin_once(timeout_sec=0.05)

    thread = threading.Thread(target=run)
    thread.start()
    try:
        for number in range(20):
            node, executor = live.node(f"client{number}")
            client = node.create_client(SetBool, "/server/set")
            assert client.wait_for_service(10.0)
            future = client.call_async(SetBool.Request(data=True))
            executor.spin_until_future_complete(future, 10.0)
            assert future.result() == SetBool.Response(success=True)
            node.context.shutdown()
    finally:
        ending.set()
        thread.join()


def test_at_most_as_many_requests_wait_as_the_queue_holds(live: "Live") -> None:
    _, executor = serve(live)
    peer = live.peer()
    replies, requests = peer.reader(*REPLY), peer.writer(*REQUEST)
    assert matched(peer, replies, requests)
    for number in range(50):
        peer.send(requests, request(1, number))
    peer.wait(lambda: False, 0.1)
    assert answered(live.collect(executor, replies, 10)) == [header(1, number) for number in range(40, 50)]


def test_a_request_that_is_being_handled_is_not_handled_twice(live: "Live") -> None:
    node, executor = live.node("server")
    asked: list[Future[bool]] = []

    async def later(_: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        asked.append(Future())
        response.success = await asked[-1]
        return response

    node.create_service(SetBool, "~/set", later)
    peer = live.peer()
    replies, requests = peer.reader(*REPLY), peer.writer(*REQUEST)
    assert matched(peer, replies, requests)
    for _ in range(3):
        peer.send(requests, request(1, 1))
    assert live.spin(executor, lambda: bool(asked))
    live.spin(executor, lambda: False, 0.2)
    (future,) = asked
    future.set_result(True)
    assert answered(live.collect(executor, replies, 1)) == [header(1, 1)]


def test_what_nobody_asked_cannot_be_answered(live: "Live") -> None:
    node, executor = live.node("server")
    twice: list[Any] = []

    def answer_twice(_: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        (request_id,) = service.handle.asked
        service.send_response(response, request_id)
        twice.append(request_id)
        return response

    service = node.create_service(SetBool, "~/set", answer_twice)
    client = node.create_client(SetBool, "/server/set")
    assert client.wait_for_service(10.0)
    client.call_async(SetBool.Request())
    with pytest.raises(CallbackError, match=r"Service /server/set has no request \(\d+, 1\) to answer"):
        live.spin(executor, lambda: False)
    assert len(twice) == 1


@pytest.mark.parametrize(
    "sample",
    [
        payload(b"\x01"),
        payload(header(1, 1)),
        payload(header(1, 1) + b"\x01" + bytes(20)),
        payload(bytes(8) + b"\xff" * 8),
        b"\x00\x07\x00\x00" + header(1, 1) + b"\x01\x00\x00\x00",
    ],
)
def test_a_malformed_request_is_dropped_and_the_server_lives(live: "Live", sample: bytes) -> None:
    _, executor = serve(live)
    peer = live.peer()
    replies, requests = peer.reader(*REPLY), peer.writer(*REQUEST)
    assert matched(peer, replies, requests)
    peer.send(requests, sample)
    peer.send(requests, request(1, 2))
    assert answered(live.collect(executor, replies, 1)) == [header(1, 2)]


@pytest.mark.parametrize("sample", [payload(bytes(8)), payload(header(0, 1) + bytes(4))])
def test_a_malformed_response_is_dropped_and_the_client_waits_on(live: "Live", sample: bytes) -> None:
    node, executor = live.node()
    peer = live.peer()
    requests, replies = peer.reader(*REQUEST), peer.writer(*REPLY)
    client = node.create_client(SetBool, "/server/set")
    assert matched(peer, requests, replies)
    future = client.call_async(SetBool.Request())
    (asked,) = peer.collect(requests, 1)
    peer.send(replies, sample[:4] + asked[4 : 4 + len(sample) - 8] + bytes(4))
    peer.send(replies, payload(asked[4:20] + b"\x01\x00\x00\x00" + b"\x01\x00\x00\x00\x00"))
    assert live.spin(executor, future.done)
    assert future.result() == SetBool.Response(success=True)


@pytest.mark.parametrize(
    ("asked", "answering", "ready"),
    [
        (b"serviceid=1;", b"serviceid=1;", True),
        (b"", b"", True),
        (b"serviceid=1;", b"serviceid=2;", False),
        (b"serviceid=1;", None, False),
        (None, b"serviceid=1;", False),
        (b"", None, False),
    ],
)
def test_a_server_is_there_when_both_its_ends_are(
    live: "Live", asked: bytes | None, answering: bytes | None, ready: bool
) -> None:
    node, _ = live.node()
    peer = live.peer()
    client = node.create_client(SetBool, "/server/set")
    ends = []
    if asked is not None:
        ends.append(peer.reader(*REQUEST, user_data=asked))
    if answering is not None:
        ends.append(peer.writer(*REPLY, user_data=answering))
    assert matched(peer, *ends)
    assert client.wait_for_service(10.0 if ready else 0.1) is ready


def test_inside_a_callback_nobody_waits_for_a_service(live: "Live") -> None:
    node, executor = live.node()
    client = node.create_client(Trigger, "/nowhere")
    found: list[bool] = []
    executor.create_task(lambda: found.append(client.wait_for_service()))  # would be for ever
    assert live.spin(executor, lambda: bool(found))
    assert found == [False]


def test_a_destroyed_client_hears_nothing_and_asks_nobody(live: "Live") -> None:
    node, executor = serve(live)
    client = node.create_client(SetBool, "/server/set")
    assert client.wait_for_service(10.0)
    future = client.call_async(SetBool.Request())
    node.destroy_client(client)
    live.spin(executor, lambda: False, 0.1)
    assert not future.done()
    assert not client.service_is_ready()
    with pytest.raises(MiddlewareError, match="Node /server cannot call /server/set: it was destroyed"):
        client.call_async(SetBool.Request())


def test_a_destroyed_service_answers_nobody(live: "Live") -> None:
    node, executor = live.node("server")
    service = node.create_service(Trigger, "~/go", lambda _, response: response)
    client = node.create_client(Trigger, "/server/go")
    assert client.wait_for_service(10.0)
    future = client.call_async(Trigger.Request())
    node.destroy_service(service)
    live.spin(executor, lambda: False, 0.1)
    assert not future.done()
    assert node.context.middleware.wait_for(lambda: not client.service_is_ready(), 10**10)


def test_requests_on_which_the_handler_raised_are_forgotten(live: "Live") -> None:
    node, executor = live.node("server")

    def refuse(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        if not request.data:
            raise RuntimeError("x" * 100_000)
        return response

    service = node.create_service(SetBool, "~/set", refuse)
    peer = live.peer()
    replies, requests = peer.reader(*REPLY), peer.writer(*REQUEST)
    assert matched(peer, replies, requests)
    for _ in range(2):  # the same request, too
        peer.send(requests, request(1, 1, data=False))
        with pytest.raises(CallbackError, match=r"raised RuntimeError: x{1000}…$"):
            live.spin(executor, lambda: False)
    assert not service.handle.asked
    peer.send(requests, request(1, 1))
    assert answered(live.collect(executor, replies, 1)) == [header(1, 1)]
