from conformance.harness import Harness
from sunset_ros.interfaces.std_srvs.srv import SetBool, Trigger
from sunset_ros.task import Future


def answered(future: Future[SetBool.Response]) -> SetBool.Response:
    response = future.result()
    assert response is not None
    return response


def test_a_service_answers(harness: Harness) -> None:
    harness.start("Server")
    client = harness.node.create_client(SetBool, "/server/set")
    for data in (True, False):
        response = harness.call(client, SetBool.Request(data=data))
        assert response == SetBool.Response(success=data, message=f"set to {data}")


def test_answers_find_their_questions(harness: Harness) -> None:
    harness.start("Server")
    clients = [harness.node.create_client(SetBool, "/server/set") for _ in range(3)]
    assert harness.spin(lambda: all(client.service_is_ready() for client in clients))
    harness.pause(0.3)
    questions = [bool(number % 3) for number in range(9)]
    futures = [
        clients[number % 2].call_async(SetBool.Request(data=data)) for number, data in enumerate(questions)
    ]
    assert harness.spin(lambda: all(future.done() for future in futures))
    assert [answered(future).success for future in futures] == questions


def test_a_service_may_ask_others_before_it_answers(harness: Harness) -> None:
    harness.start("Server")
    client = harness.node.create_client(Trigger, "/server/ask")
    for _ in range(2):
        response = harness.call(client, Trigger.Request())
        assert response == Trigger.Response(success=True, message="asked: set to True, set to False")


def test_the_answer_leaves_before_the_process_that_shuts_down(harness: Harness) -> None:
    harness.start("Server")
    response = harness.call(harness.node.create_client(Trigger, "/server/leave"), Trigger.Request())
    assert response.success
    assert harness.spin(lambda: not harness.is_running("Server"))
    assert harness.spin(lambda: "server" not in harness.node.get_node_names())


def test_readiness_follows_the_server(harness: Harness) -> None:
    client = harness.node.create_client(SetBool, "/server/set")
    assert not client.service_is_ready()
    assert not client.wait_for_service(timeout_sec=0.1)
    harness.start("Server")
    assert client.wait_for_service(timeout_sec=10.0)
    harness.kill("Server")
    assert harness.spin(lambda: not client.service_is_ready(), 20.0)


def test_services_are_remapped_from_the_command_line(harness: Harness) -> None:
    harness.start("Server", "-r", "~/set:=/switch")
    response = harness.call(harness.node.create_client(SetBool, "/switch"), SetBool.Request(data=True))
    assert response.success
