"""`sunset ros` on a graph of two other processes: the camera, and a node that is not SUNSET's."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest
import yaml

from sunset.cli import main
from sunset_ros.rmw.dds.domains import free_domain_id

pytestmark = pytest.mark.xdist_group("ros")  # the two processes are started once

CAMERA = "/managed_subsystem/camera"
SUNSET = (sys.executable, "-m", "sunset")
Ros = Callable[..., str]


def environment(domain_id: int) -> dict[str, str]:
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("ROS_", "CYCLONEDDS"))}
    return {**kept, "ROS_DOMAIN_ID": str(domain_id)}


@pytest.fixture(scope="module")
def domain_id() -> Iterator[int]:
    """A domain with the two processes, which end with the tests."""
    stranger = str(Path(__file__).with_name("stranger.py"))
    delay = ("--ros-args", "-p", "lifecycle_activation_delay:=0.0")
    with free_domain_id() as domain:
        commands = [(*SUNSET, "node", "camera", *delay), (sys.executable, stranger, str(domain))]
        processes = [subprocess.Popen(command, env=environment(domain)) for command in commands]
        try:
            there = ("--domain-id", str(domain), "--timeout", "60")
            assert main(["ros", "topic", "echo", "--once", "/notice", *there]) == 0
            assert main(["ros", "lifecycle", "get", CAMERA, *there]) == 0
            yield domain
        finally:
            for process in processes:
                process.terminate()
            ended = [process.wait(timeout=60) for process in processes]
    assert ended[0] == 0


@pytest.fixture
def ros(
    domain_id: int, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Callable[..., str]:
    """Call `sunset ros`; return what it prints."""
    for name in ("ROS_LOCALHOST_ONLY", "ROS_AUTOMATIC_DISCOVERY_RANGE", "CYCLONEDDS_URI"):
        monkeypatch.delenv(name, raising=False)

    def call(*words: str, code: int = 0, timeout: float = 60.0) -> str:
        arguments = ["ros", *words, "--domain-id", str(domain_id), "--timeout", str(timeout)]
        assert main(arguments) == code
        out, err = capfd.readouterr()
        if code == 0:
            assert err == ""
            return out
        assert out == ""
        return err

    return call


def test_nodes_are_listed_by_their_full_names(ros: Ros) -> None:
    assert ros("node", "list") == f"{CAMERA}\n/stranger\n"


def test_a_node_is_described_by_its_parts(ros: Ros) -> None:
    lines = ros("node", "info", "stranger").splitlines()

    assert lines == [
        "/stranger",
        "  Subscribers:",
        "",
        "  Publishers:",
        "    /_hidden: std_msgs/msg/String",
        "    /notice: std_msgs/msg/String",
        "    /odd: odd_msgs/msg/Odd",
        "    /parameter_events: rcl_interfaces/msg/ParameterEvent",
        "    /silent: std_msgs/msg/String",
        "  Service Servers:",
        "    /grant: std_srvs/srv/SetBool",
        "  Service Clients:",
        "",
    ]


def test_topics_are_listed_but_hidden_ones(ros: Ros) -> None:
    plain = ros("topic", "list").splitlines()
    typed = ros("topic", "list", "-t").splitlines()

    assert "/managed_subsystem/rgb_camera" in plain
    assert "/_hidden" not in plain
    assert [line.split(" ")[0] for line in typed] == plain == sorted(plain)
    assert "/odd [odd_msgs/msg/Odd]" in typed


def test_a_topic_is_described_by_its_ends(ros: Ros) -> None:
    brief = ros("topic", "info", "/parameter_events")
    verbose = ros("topic", "info", "--verbose", "/notice")

    assert brief == ("Type: rcl_interfaces/msg/ParameterEvent\nPublisher count: 2\nSubscription count: 0\n")
    assert re.fullmatch(
        "Type: std_msgs/msg/String\n\nPublisher count: 1\n\nNode name: stranger\nNode namespace: /\n"
        r"Topic type: std_msgs/msg/String\nEndpoint type: PUBLISHER\nGID: ([0-9a-f]{2}\.){15}[0-9a-f]{2}\n"
        r"QoS profile:\n  Reliability: BEST_EFFORT\n  History \(Depth\): KEEP_LAST \(1\)\n"
        "  Durability: TRANSIENT_LOCAL\n  Lifespan: Infinite\n\nSubscription count: 0\n\n",
        verbose,
    )


def test_messages_are_printed(ros: Ros) -> None:
    notice = ros("topic", "echo", "--once", "notice")
    message, rest = yaml.safe_load_all(ros("topic", "echo", "--once", "--no-arr", "/diagnostics"))

    assert notice == "data: wet paint\n---\n"
    assert message["status"] == "<sequence type: diagnostic_msgs/msg/DiagnosticStatus, length: 1>"
    assert rest is None


def test_parameters_are_listed_read_and_set(ros: Ros) -> None:
    names = ros("param", "list", CAMERA)
    assert "  image_degradation\n" in names
    assert ros("param", "list") == f"{CAMERA}:\n{names}"
    assert ros("param", "get", CAMERA, "image_degradation") == "Double value is: 0.0\n"
    assert ros("param", "set", CAMERA, "image_degradation", "0.5") == "Set parameter successful\n"
    assert ros("param", "get", CAMERA, "image_degradation") == "Double value is: 0.5\n"
    assert ros("param", "get", CAMERA, "use_sim_time") == "Boolean value is: False\n"

    refused = ros("param", "set", CAMERA, "image_degradation", "dark", code=1)
    assert refused.startswith("sunset: Setting parameter failed: ")
    assert "not declared" in ros("param", "set", CAMERA, "nonsense", "1", code=1)
    assert "Parameter not set" in ros("param", "get", CAMERA, "nonsense", code=1)


def test_a_lifecycle_is_seen_and_changed(ros: Ros) -> None:
    assert ros("lifecycle", "nodes") == f"{CAMERA}\n"
    assert ros("lifecycle", "get") == f"{CAMERA}: active [3]\n"
    assert ros("lifecycle", "list", CAMERA) == (
        "- deactivate [4]\n\tStart: active\n\tGoal: deactivating\n"
        "- shutdown [7]\n\tStart: active\n\tGoal: shuttingdown\n"
    )
    assert ros("lifecycle", "set", CAMERA, "deactivate") == "Transitioning successful\n"
    assert ros("lifecycle", "get", CAMERA) == "inactive [2]\n"
    assert "available ones are cleanup [2], activate [3]" in ros("lifecycle", "set", CAMERA, "fly", code=1)
    assert ros("lifecycle", "set", CAMERA, "3") == "Transitioning successful\n"


def test_services_are_listed_and_called(ros: Ros) -> None:
    assert "/grant [std_srvs/srv/SetBool]" in ros("service", "list", "-t").splitlines()
    assert ros("service", "call", "/grant", "std_srvs/srv/SetBool", "{data: true}") == (
        "requester: making request: std_srvs.srv.SetBool_Request(data=True)\n\n"
        "response:\nstd_srvs.srv.SetBool_Response(success=True, message='granted')\n\n"
    )
    assert "message='denied'" in ros("service", "call", "/grant", "std_srvs/srv/SetBool")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["node", "info", "/nobody"], "Unable to find node '/nobody'"),
        (["topic", "info", "/nothing"], "Unknown topic '/nothing'"),
        (["topic", "echo", "/nothing"], "does not appear to be published"),
        (["topic", "hz", "/nothing"], "does not appear to be published"),
        (["param", "list", "/nobody"], "Unable to find node '/nobody'"),
        (["param", "get", "/nobody", "x"], "Unable to find node '/nobody'"),
        (["param", "set", "/nobody", "x", "1"], "Unable to find node '/nobody'"),
        (["lifecycle", "get", "/nobody"], "Unable to find node '/nobody'"),
        (["lifecycle", "set", "/nobody", "activate"], "Unable to find node '/nobody'"),
    ],
)
def test_what_is_not_there_is_one_sentence_and_code_1(ros: Ros, words: Sequence[str], told: str) -> None:
    sentence = ros(*words, code=1, timeout=0.5)

    assert re.search(told, sentence)
    assert re.fullmatch(r"sunset: [^\n]*[^.]\.\n", sentence)


def test_a_service_that_a_node_does_not_offer_is_missed(ros: Ros) -> None:
    sentence = ros("param", "list", "/stranger", code=1, timeout=2.0)

    assert sentence == (
        "sunset: The service /stranger/list_parameters of type rcl_interfaces/srv/ListParameters is not available.\n"
    )


def test_a_type_that_is_unknown_is_listed_but_not_printed(ros: Ros) -> None:
    assert "are odd_msgs/msg/Odd, a type that no installed package defines" in ros(
        "topic", "echo", "/odd", code=2
    )


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["topic", "echo", "/two words"], "must not contain ' '"),
        (["node", "list", "--domain-id", "233"], "0 to 232, got '?233"),
        (["node", "list", "--domain-id", "x"], "expected a whole number, got 'x'"),
        (["node", "list", "--timeout", "-1"], "seconds from 0 on, got '-1'"),
        (["node", "list", "--timeout", "inf"], "seconds from 0 on, got 'inf'"),
        (["service", "call", "/a", "std_srvs/srv/Nothing"], "no service 'std_srvs/srv/Nothing'"),
        (["service", "call", "/a", "std_srvs/srv/SetBool", "{data: "], "not valid YAML"),
        (["service", "call", "/a", "std_srvs/srv/SetBool", "{on: true}"], "no field"),
        (["param", "set", "/a", "x", "{}"], "cannot hold"),
        (["param", "set", "/a", "x", "[1"], "not valid YAML"),
        (["param", "get", "/a"], "required: PARAMETER"),
        (["bag"], "there is no 'bag'"),
    ],
)
def test_what_cannot_be_used_is_one_sentence_and_code_2(
    complaint: Callable[[Sequence[str]], str], words: Sequence[str], told: str
) -> None:
    assert re.search(told, complaint(["ros", *words]))


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "number", "first"),
    [
        (["topic", "hz", "/notice"], signal.SIGINT, r"average rate: \d+\.\d{3}\n"),
        (["topic", "echo", "/notice"], signal.SIGTERM, "data: wet paint\n"),
    ],
)
def test_listening_ends_cleanly_with_a_signal(
    ros: Ros, domain_id: int, words: Sequence[str], number: int, first: str
) -> None:
    command = [*SUNSET, "ros", *words]
    with subprocess.Popen(
        command, env=environment(domain_id), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        process.send_signal(number)
        _, err = process.communicate(timeout=60)

    assert re.fullmatch(first, line)
    assert (process.returncode, err) == (0, "")
    assert "Subscription count: 0" in ros("topic", "info", "/notice")


@pytest.mark.thorough
def test_the_reader_of_the_output_may_have_seen_enough(domain_id: int) -> None:
    command = [*SUNSET, "ros", "topic", "echo", "/notice"]
    with subprocess.Popen(
        command, env=environment(domain_id), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        process.stdout.close()
        code, err = process.wait(timeout=60), process.stderr.read()

    assert (code, err) == (0, "")
