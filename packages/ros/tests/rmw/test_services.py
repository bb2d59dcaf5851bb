import pytest

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.std_srvs.srv import SetBool, Trigger
from sunset_ros.rmw.core.node import NodeHandle, ServiceHandle
from sunset_ros.rmw.core.port import RequestId
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.sim import Simulation, Tap

MS = 1_000_000
QOS = QoSProfile(depth=10)


def node_of(sim: Simulation, name: str, *, is_protected: bool = False) -> NodeHandle:
    process = sim.create_process(name, is_protected=is_protected)
    node = process.create_node(name, "/")
    node.attach()
    process.run()
    return node


def serve(node: NodeHandle, message: str, qos: QoSProfile = QOS) -> list[Message]:
    requests: list[Message] = []

    def answer(request_id: RequestId, request: Message) -> None:
        requests.append(request)
        handle.send_response(request_id, SetBool.Response(success=True, message=message))

    handle: ServiceHandle = node.create_service(SetBool, "/switch", qos, answer, label="answer")
    return requests


Responses = list[tuple[int, Message]]


def test_a_response_comes_back_with_the_number_of_its_request() -> None:
    sim = Simulation(latency_s=0.001)
    requests = serve(node_of(sim, "server"), "done")
    responses: Responses = []
    times: list[int] = []

    def on_response(number: int, response: Message) -> None:
        responses.append((number, response))
        times.append(sim.now)

    client = node_of(sim, "client").create_client(SetBool, "/switch", QOS, on_response, label="on_response")
    assert client.server_ready()
    numbers = [client.send_request(SetBool.Request(data=data)) for data in (True, False)]
    sim.run_until(100 * MS)
    assert requests == [SetBool.Request(data=True), SetBool.Request(data=False)]
    assert [number for number, _ in responses] == numbers
    assert times == [2_200_000, 2_400_000]  # there, 0.2 ms of work each, and back


def test_every_server_is_asked_and_every_answer_comes() -> None:
    sim = Simulation()
    for name in ("first", "second"):
        serve(node_of(sim, name), name)
    responses: Responses = []
    client = node_of(sim, "client").create_client(
        SetBool, "/switch", QOS, lambda *response: responses.append(response), label="on_response"
    )
    client.send_request(SetBool.Request())
    sim.run_until(100 * MS)
    assert [(number, response.message) for number, response in responses] == [(1, "first"), (1, "second")]  # type: ignore[attr-defined]


def test_without_a_server_of_the_type_nothing_answers() -> None:
    sim = Simulation()
    node_of(sim, "server").create_service(Trigger, "/switch", QOS, lambda *_: None, label="answer")
    responses: Responses = []
    client = node_of(sim, "client").create_client(
        SetBool, "/switch", QOS, lambda *response: responses.append(response), label="on_response"
    )
    assert not client.server_ready()
    client.send_request(SetBool.Request())
    serve(node_of(sim, "late"), "late")
    assert client.server_ready()
    sim.run_until(100 * MS)
    assert responses == []


def test_a_server_holds_no_more_requests_than_its_depth() -> None:
    sim = Simulation()
    requests = serve(node_of(sim, "server"), "done", QoSProfile(depth=2))
    client = node_of(sim, "client").create_client(
        SetBool, "/switch", QOS, lambda *_: None, label="on_response"
    )
    for number in range(5):
        client.send_request(SetBool.Request(data=number == 4))
    sim.run_until(100 * MS)
    assert [request.data for request in requests] == [False, False, True]  # type: ignore[attr-defined]


def test_requests_of_a_protected_process_wait_for_no_other_and_take_nobodys_place() -> None:
    sim = Simulation()
    server = node_of(sim, "server")
    handled: list[tuple[str, int, int]] = []

    def serve_as(name: str) -> None:
        server.create_service(
            SetBool,
            name,
            QoSProfile(depth=2),
            lambda number, _: handled.append((name, number.sequence, sim.now)),
            label="answer",
        )

    serve_as("/other_switch")
    serve_as("/switch")
    protected, other = node_of(sim, "protected", is_protected=True), node_of(sim, "other")
    asking, beside, elsewhere = (
        node.create_client(SetBool, name, QOS, lambda *_: None, label="on_response")
        for node, name in ((protected, "/switch"), (other, "/switch"), (other, "/other_switch"))
    )
    for client in (elsewhere, beside, asking):
        for _ in range(4):
            client.send_request(SetBool.Request())
    sim.run_until(100 * MS)
    arrived, callback = 500_000, 200_000
    busy = arrived + callback
    assert handled == [
        ("/other_switch", 1, arrived),
        *(("/switch", number, busy) for number in (1, 2, 3, 4)),
        ("/other_switch", 3, busy),
        ("/other_switch", 4, busy + callback),
        ("/switch", 3, busy + 2 * callback),
        ("/switch", 4, busy + 3 * callback),
    ]


def test_the_responses_to_others_come_as_if_a_protected_process_had_sent_no_request() -> None:
    def response_times(requests_of_protected: int) -> list[int]:
        sim = Simulation()
        server, other = node_of(sim, "server"), node_of(sim, "other")
        serve(server, "done", QOS)
        times: list[int] = []

        def ask_again(*_: object) -> None:
            times.append(sim.now)
            client.send_request(SetBool.Request())

        client = other.create_client(SetBool, "/switch", QOS, ask_again, label="on_response")
        client.send_request(SetBool.Request())
        handled: list[int] = []
        asking = node_of(sim, "protected", is_protected=True).create_client(
            SetBool, "/switch", QOS, lambda number, _: handled.append(number), label="on_response"
        )
        for number in range(requests_of_protected):
            sim.run_until((5 + number) * MS + 100_000 * number)
            asking.send_request(SetBool.Request())
        sim.run_until(50 * MS)
        assert handled == [*range(1, requests_of_protected + 1)]
        return times

    assert response_times(20) == response_times(0)


def test_the_order_of_responses_is_as_if_a_protected_process_had_sent_no_request() -> None:
    def order_of_responses(*, is_asked: bool) -> list[tuple[int, str]]:
        sim = Simulation()
        order: list[tuple[int, str]] = []
        other = node_of(sim, "other")
        clients = []
        for name in ("/first", "/second"):
            service: list[ServiceHandle] = []

            def answer(request_id: RequestId, _: Message, service: list[ServiceHandle] = service) -> None:
                service[0].send_response(request_id, SetBool.Response())

            service.append(node_of(sim, name[1:]).create_service(SetBool, name, QOS, answer, label="answer"))

            def note(*_: object, name: str = name) -> None:
                order.append((sim.now, name))

            clients.append(other.create_client(SetBool, name, QOS, note, label="on_response"))
        asking = node_of(sim, "protected", is_protected=True).create_client(
            SetBool, "/first", QOS, lambda *_: None, label="on_response"
        )
        for _ in range(5):
            for client in clients:
                client.send_request(SetBool.Request())
        sim.run_until(300_000)
        if is_asked:
            asking.send_request(SetBool.Request())
        sim.run_until(50 * MS)
        return order

    assert order_of_responses(is_asked=True) == order_of_responses(is_asked=False)


def test_a_request_can_be_answered_later_but_once() -> None:
    sim = Simulation()
    server = node_of(sim, "server")
    waiting: list[RequestId] = []
    service = server.create_service(
        SetBool, "/switch", QOS, lambda request_id, _: waiting.append(request_id), label="answer"
    )
    responses: Responses = []
    client = node_of(sim, "client").create_client(
        SetBool, "/switch", QOS, lambda *response: responses.append(response), label="on_response"
    )
    client.send_request(SetBool.Request())
    sim.run_until(50 * MS)
    assert responses == []
    service.send_response(waiting[0], SetBool.Response(success=True))
    with pytest.raises(MiddlewareError, match="Service /switch has no request"):
        service.send_response(waiting[0], SetBool.Response())
    sim.run_until(100 * MS)
    assert responses == [(1, SetBool.Response(success=True))]


def test_a_client_that_is_gone_gets_no_response() -> None:
    sim = Simulation()
    serve(node_of(sim, "server"), "done")
    responses: Responses = []
    client = node_of(sim, "client").create_client(
        SetBool, "/switch", QOS, lambda *response: responses.append(response), label="on_response"
    )
    client.send_request(SetBool.Request())
    client.destroy()
    sim.run_until(100 * MS)
    assert responses == []
    with pytest.raises(MiddlewareError, match="Node /client cannot call /switch"):
        client.send_request(SetBool.Request())


def test_a_service_that_is_gone_is_not_ready_and_drops_requests() -> None:
    sim = Simulation()
    server = node_of(sim, "server")
    handled: list[RequestId] = []
    service = server.create_service(
        SetBool, "/switch", QOS, lambda request_id, _: handled.append(request_id), label="answer"
    )
    client = node_of(sim, "client").create_client(
        SetBool, "/switch", QOS, lambda *_: None, label="on_response"
    )
    client.send_request(SetBool.Request())
    service.destroy()
    assert not client.server_ready()
    sim.run_until(100 * MS)
    assert handled == []


def test_a_tap_sees_request_and_response_with_the_same_identity() -> None:
    sim = Simulation(latency_s=0.001)
    seen: list[tuple[object, ...]] = []

    class Witness(Tap):
        def on_request(self, *what: object) -> None:
            seen.append(("request", *what))

        def on_response(self, *what: object) -> None:
            seen.append(("response", *what))

    sim.add_tap(Witness())
    serve(node_of(sim, "server"), "done")
    client = node_of(sim, "client").create_client(
        SetBool, "/switch", QOS, lambda *_: None, label="on_response"
    )
    client.send_request(SetBool.Request(data=True))
    sim.run_until(100 * MS)
    (request, response) = seen
    request_id = request[-1]
    assert request == (
        "request",
        1 * MS,
        "/switch",
        "/client",
        "/server",
        SetBool.Request(data=True),
        request_id,
    )
    assert response == (
        "response",
        1_200_000,
        "/switch",
        "/server",
        SetBool.Response(success=True, message="done"),
        request_id,
    )
