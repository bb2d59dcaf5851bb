"""What the outside observer makes of the traffic that it sees."""

from typing import Any

import pytest

from sunset.experiments.observer import Observer
from sunset.system import COMMANDS_TOPIC
from sunset.system_interfaces.msg import Command
from sunset.system_interfaces.srv import Redeploy
from sunset_ros import Parameter
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from sunset_ros.interfaces.lifecycle_msgs.msg import State, Transition, TransitionEvent
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState, GetState
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterEvent, SetParametersResult
from sunset_ros.interfaces.rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.rmw.core.port import EndpointKind, RequestId

MANAGER, CAMERA = "/managing_system", "/managed_subsystem/camera"
NUMBER = RequestId(1, 1)


class Sink:
    def __init__(self) -> None:
        self.written: list[tuple[str, int, Any]] = []

    def write(self, topic: str, time_ns: int, message: Message) -> None:
        self.written.append((topic, time_ns, message))


@pytest.fixture
def sink() -> Sink:
    return Sink()


def exchange(
    observer: Observer, request: Message, response: Message, *, client: str = MANAGER, server: str = CAMERA
) -> None:
    observer.on_request(2_500_000_000, "/service", client, server, request, NUMBER)
    observer.on_response(2_600_000_000, "/service", server, response, NUMBER)


def setting(*names: str) -> SetParameters.Request:
    return SetParameters.Request(
        parameters=[Parameter(name, value=True).to_parameter_msg() for name in names]
    )


def change(label: str = "", number: int = 0) -> ChangeState.Request:
    return ChangeState.Request(transition=Transition(id=number, label=label))


ACCEPTED, REFUSED = SetParametersResult(successful=True), SetParametersResult(reason="no")


@pytest.mark.parametrize(
    ("request_", "response", "outcome"),
    [
        (setting("a", "b"), SetParameters.Response(results=[ACCEPTED] * 2), ("set_parameters", True, "")),
        (
            setting("a", "b"),
            SetParameters.Response(results=[ACCEPTED, REFUSED]),
            ("set_parameters", True, "no"),
        ),
        (
            setting("a", "b"),
            SetParameters.Response(results=[REFUSED, REFUSED]),
            ("set_parameters", False, "no; no"),
        ),
        (setting(), SetParameters.Response(), ("set_parameters", False, "")),
        (
            SetParametersAtomically.Request(parameters=setting("a").parameters),
            SetParametersAtomically.Response(result=REFUSED),
            ("set_parameters", False, "no"),
        ),
        (change("activate"), ChangeState.Response(success=True), ("activate", True, "")),
        (change(number=4), ChangeState.Response(), ("deactivate", False, "transition refused")),
    ],
)
def test_a_request_and_its_answer_are_a_command(
    sink: Sink, request_: Message, response: Message, outcome: tuple[str, bool, str]
) -> None:
    exchange(Observer(sink), request_, response)
    ((topic, time_ns, command),) = sink.written
    assert (topic, time_ns) == (COMMANDS_TOPIC, 2_600_000_000)
    assert (command.stamp.sec, command.stamp.nanosec) == (2, 500_000_000)  # when the request arrived
    assert (command.client, command.node, command.service) == (MANAGER, CAMERA, "/service")
    assert (command.kind, command.successful, command.reason) == outcome


def test_a_command_breaks_a_rule_where_the_task_is_to_diagnose(sink: Sink) -> None:
    observer = Observer(sink, task="diagnose")
    exchange(observer, change("deactivate"), ChangeState.Response(success=True), client="/scenario_executor")
    exchange(observer, GetParameters.Request(names=["modality"]), GetParameters.Response())
    assert observer.violations == []
    exchange(observer, change("deactivate"), ChangeState.Response(success=True))
    (violation,) = observer.violations
    assert violation == "/managing_system calls /service, and the task is to diagnose, without adaptations"


def test_a_redeploy_is_a_command_to_the_node_and_not_to_the_launcher(sink: Sink) -> None:
    exchange(
        Observer(sink), Redeploy.Request(node="depth"), Redeploy.Response(success=True), server="/launcher"
    )
    (command,) = [written[2] for written in sink.written]
    assert (command.node, command.kind, command.successful) == ("/managed_subsystem/depth", "redeploy", True)


def test_of_several_parameters_those_count_that_were_accepted(sink: Sink) -> None:
    results = [REFUSED, ACCEPTED, REFUSED]
    exchange(Observer(sink), setting("a", "b", "c"), SetParameters.Response(results=results))
    (command,) = [written[2] for written in sink.written]
    assert (command.parameters, command.values) == (["b"], ["true"])


def test_what_is_set_is_kept_as_text(sink: Sink) -> None:
    values = {"flag": True, "whole": 3, "share": 0.5, "name": "rgb", "wholes": [1, 2], "shares": [0.5]}
    parameters = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
    request = SetParameters.Request(parameters=parameters)
    exchange(Observer(sink), request, SetParameters.Response(results=[ACCEPTED] * 6))
    (command,) = [written[2] for written in sink.written]
    assert (command.parameters, command.values) == (
        list(values),
        ["true", "3", "0.5", "rgb", "[1, 2]", "[0.5]"],
    )


def test_of_a_long_value_only_the_beginning_is_kept(sink: Sink) -> None:
    parameter = Parameter("topic", value="t" * 10_000_000).to_parameter_msg()
    request = SetParameters.Request(parameters=[parameter])

    exchange(Observer(sink), request, SetParameters.Response(results=[ACCEPTED]))

    assert sink.written[0][2].values == ["t" * 1000 + "…"]


@pytest.mark.parametrize(
    ("client", "server"), [("/scenario_executor", CAMERA), (MANAGER, "/monitor"), (MANAGER, MANAGER)]
)
def test_requests_of_the_experiment_or_to_others_are_no_commands(
    sink: Sink, client: str, server: str
) -> None:
    answer = SetParameters.Response(results=[ACCEPTED])
    exchange(Observer(sink), setting("a"), answer, client=client, server=server)
    assert sink.written == []


def test_a_command_that_was_never_answered_is_unsuccessful(sink: Sink) -> None:
    observer = Observer(sink)
    observer.on_request(1, "/service", MANAGER, CAMERA, change("shutdown"), NUMBER)
    assert sink.written == []
    observer.finish(9)
    observer.finish(10)
    ((topic, time_ns, command),) = sink.written
    assert (topic, time_ns) == (COMMANDS_TOPIC, 9)
    assert isinstance(command, Command)
    assert (command.successful, command.reason) == (False, "never answered")


def went(start: int, goal: int) -> TransitionEvent:
    return TransitionEvent(start_state=State(id=start), goal_state=State(id=goal))


@pytest.mark.parametrize(
    ("label", "events", "outcome"),
    [
        ("shutdown", [went(3, 12), went(12, 4)], (True, "not answered, but done")),
        ("activate", [went(2, 13), went(13, 3)], (True, "not answered, but done")),
        ("deactivate", [went(3, 14), went(14, 2)], (True, "not answered, but done")),
        ("configure", [went(1, 10), went(10, 2)], (True, "not answered, but done")),
        ("cleanup", [went(2, 11), went(11, 1)], (True, "not answered, but done")),
        ("activate", [went(2, 13), went(13, 2), went(2, 13), went(13, 3)], (False, "never answered")),
        ("activate", [went(2, 13), went(13, 15), went(15, 1)], (False, "never answered")),
        ("shutdown", [went(2, 13), went(13, 3)], (False, "never answered")),
        ("destroy", [went(3, 12), went(12, 4)], (False, "never answered")),
    ],
)
def test_a_transition_that_happened_is_evidence_of_a_command_that_was_not_answered(
    sink: Sink, label: str, events: list[TransitionEvent], outcome: tuple[bool, str]
) -> None:
    observer = Observer(sink)
    observer.on_message(1, f"{CAMERA}/transition_event", CAMERA, events[0])  # before the request
    observer.on_message(1, f"{CAMERA}/transition_event", CAMERA, events[1])
    observer.on_request(2, "/service", MANAGER, CAMERA, change(label), NUMBER)
    observer.on_message(3, "/managed_subsystem/depth/transition_event", "/managed_subsystem/depth", events[1])
    observer.on_message(3, "/elsewhere", CAMERA, events[1])
    for event in events:
        observer.on_message(4, f"{CAMERA}/transition_event", CAMERA, event)
    observer.finish(9)
    (command,) = [message for topic, _, message in sink.written if topic == COMMANDS_TOPIC]
    assert (command.successful, command.reason, command.stamp.nanosec) == (*outcome, 2)


def test_one_transition_is_evidence_of_one_command(sink: Sink) -> None:
    observer = Observer(sink)
    for number in range(2):
        observer.on_request(2, "/service", MANAGER, CAMERA, change("activate"), RequestId(1, number))
    observer.on_message(4, f"{CAMERA}/transition_event", CAMERA, went(13, 3))
    observer.finish(9)
    commands = [message for topic, _, message in sink.written if topic == COMMANDS_TOPIC]
    assert [command.successful for command in commands] == [True, False]


@pytest.mark.parametrize(
    ("done_before", "outcome"),
    [([], (False, "never answered")), ([went(2, 13), went(13, 3)], (True, "not answered, but done"))],
)
def test_what_a_redeployed_node_does_is_no_evidence_of_what_the_dead_one_was_asked_for(
    sink: Sink, done_before: list[TransitionEvent], outcome: tuple[bool, str]
) -> None:
    observer = Observer(sink)
    observer.on_request(1, "/service", MANAGER, CAMERA, change("activate"), NUMBER)
    for event in done_before:
        observer.on_message(2, f"{CAMERA}/transition_event", CAMERA, event)
    observer.on_node("camera", CAMERA)
    observer.on_message(6, f"{CAMERA}/transition_event", CAMERA, went(13, 3))
    observer.finish(9)
    (command,) = [message for topic, _, message in sink.written if topic == COMMANDS_TOPIC]
    assert (command.successful, command.reason) == outcome


@pytest.mark.parametrize("clients", [(MANAGER, "/launcher"), ("/launcher", MANAGER)])
def test_what_the_experiment_asked_for_is_no_evidence_of_a_command(
    sink: Sink, clients: tuple[str, str]
) -> None:
    observer = Observer(sink)
    for number, client in enumerate(clients):
        request_id = RequestId(1, number)
        observer.on_request(1, "/service", client, CAMERA, change("shutdown"), request_id)
    observer.on_message(2, f"{CAMERA}/transition_event", CAMERA, went(12, 4))
    observer.finish(9)
    (command,) = [message for topic, _, message in sink.written if topic == COMMANDS_TOPIC]
    assert (command.client, command.successful) == (MANAGER, False)
    assert observer.commands == 1


@pytest.mark.parametrize(
    ("node", "kind", "topic", "evidence"),
    [
        (MANAGER, EndpointKind.SUBSCRIPTION, "/managed_subsystem/rgb_camera", "images"),
        (MANAGER, EndpointKind.SUBSCRIPTION, "/managed_subsystem/sensors_fused", "images"),
        (MANAGER, EndpointKind.SUBSCRIPTION, "/blackboard_group", "symptoms"),
        (MANAGER, EndpointKind.PUBLISHER, "/managed_subsystem/rgb_camera", "symptoms"),
        (
            "/managed_subsystem/sensor_fusion",
            EndpointKind.SUBSCRIPTION,
            "/managed_subsystem/rgb_camera",
            "symptoms",
        ),
        ("/rviz", EndpointKind.SUBSCRIPTION, "/managed_subsystem/rgb_camera", "symptoms"),
    ],
)
def test_what_a_managing_system_subscribed_to_is_its_evidence(
    node: str, kind: EndpointKind, topic: str, evidence: str, sink: Sink
) -> None:
    observer = Observer(sink, viewers=("/rviz",))
    observer.on_endpoint(node, kind, topic)
    assert observer.evidence == evidence


def test_an_answer_has_more_weight_than_a_transition(sink: Sink) -> None:
    observer = Observer(sink)
    observer.on_request(2, "/service", MANAGER, CAMERA, change("activate"), NUMBER)
    observer.on_message(4, f"{CAMERA}/transition_event", CAMERA, went(13, 3))
    observer.on_response(5, "/service", CAMERA, ChangeState.Response(), NUMBER)
    (command,) = [message for topic, _, message in sink.written if topic == COMMANDS_TOPIC]
    assert (command.successful, command.reason) == (False, "transition refused")


def test_messages_of_the_system_on_its_topics_are_recorded_and_forged_ones_are_not(sink: Sink) -> None:
    observer = Observer(sink)
    observer.on_message(1, "/managed_subsystem/rgb_camera", CAMERA, String())
    observer.on_message(2, "/managed_subsystem/rgb_camera", MANAGER, String())
    observer.on_message(3, "/my_own_topic", MANAGER, String())
    assert [time_ns for _, time_ns, _ in sink.written] == [1, 3]
    assert [MANAGER in violation for violation in observer.violations] == [True]


@pytest.mark.parametrize(
    ("node", "topic", "allowed"),
    [
        (CAMERA, "/managed_subsystem/rgb_camera", True),
        (CAMERA, "/diagnostics", True),
        (CAMERA, "/rosout", True),
        (CAMERA, f"{CAMERA}/transition_event", True),
        (CAMERA, "/gt_segmentation", False),
        (CAMERA, "/managed_subsystem/depth_camera", False),
        (CAMERA, "/anything", False),
        ("/bag_player", "/gt_segmentation", True),
        ("/evaluator", "/anything", True),
        (MANAGER, "/anything", True),
    ],
)
def test_a_managed_node_publishes_what_its_description_says(
    node: str, topic: str, allowed: bool, sink: Sink
) -> None:
    observer = Observer(sink)
    observer.on_message(1, topic, node, String())
    assert (not observer.violations) is allowed
    assert bool(sink.written) is allowed


def test_the_process_of_a_managed_node_has_no_node_of_another_name_of_the_system(sink: Sink) -> None:
    observer = Observer(sink)
    observer.on_node("camera", CAMERA)
    observer.on_node("camera", "/helper")
    assert not observer.violations
    observer.on_node("camera", "/bag_player")
    assert list(observer.violations) == [
        "the process of camera has a node /bag_player, which is a name of the system's"
    ]


@pytest.mark.parametrize(
    ("topic", "allowed"),
    [
        ("/managed_subsystem/rgb_enhanced", True),
        ("/clock", True),
        ("/parameter_events", True),
        ("/mine/rgb", False),
        ("/gt_segmentation", False),
        ("/experiment/log", False),
    ],
)
def test_what_may_feed_a_managed_node(topic: str, allowed: bool, sink: Sink) -> None:
    observer = Observer(sink)

    observer.on_endpoint("/managed_subsystem/sensor_fusion", EndpointKind.SUBSCRIPTION, topic)

    assert (not observer.violations) is allowed


def test_a_parameter_event_in_the_name_of_another_is_not_recorded(sink: Sink) -> None:
    observer = Observer(sink)

    observer.on_message(1, "/parameter_events", MANAGER, ParameterEvent(node=MANAGER))
    observer.on_message(2, "/parameter_events", MANAGER, ParameterEvent(node=CAMERA))

    assert [time_ns for _, time_ns, _ in sink.written] == [1]
    assert list(observer.violations) == [
        f"{MANAGER} publishes on /parameter_events in the name of another node"
    ]


def test_diagnostics_are_shared_but_not_those_of_a_managed_node(sink: Sink) -> None:
    observer = Observer(sink)
    own = DiagnosticStatus(name="battery: level", hardware_id="battery")
    nameless = DiagnosticStatus()
    as_camera = DiagnosticStatus(name="battery: level", hardware_id="camera")
    as_depth = DiagnosticStatus(name="depth: heartbeat", hardware_id="none")

    observer.on_message(1, "/diagnostics", MANAGER, DiagnosticArray(status=[own, nameless]))
    observer.on_message(2, "/diagnostics", CAMERA, DiagnosticArray(status=[as_camera]))
    assert not observer.violations
    for time_ns, status in enumerate((as_camera, as_depth), 3):
        observer.on_message(time_ns, "/diagnostics", f"/node{time_ns}", DiagnosticArray(status=[own, status]))
    observer.on_message(5, "/diagnostics", CAMERA, DiagnosticArray(status=[as_depth]))

    assert [time_ns for _, time_ns, _ in sink.written] == [1, 2]
    assert list(observer.violations) == [
        f"{node} publishes on /diagnostics in the name of another node"
        for node in ("/node3", "/node4", CAMERA)
    ]


@pytest.mark.parametrize("topic", ["/gt_segmentation", "/rgb_raw", "/experiment/injections", "/seg_metrics"])
def test_a_viewer_may_read_everything(topic: str, sink: Sink) -> None:
    observer = Observer(sink, viewers=["/recorder"])

    observer.on_endpoint("/recorder", EndpointKind.SUBSCRIPTION, topic)
    observer.on_endpoint("/recorder", EndpointKind.SERVICE, "/recorder/get_parameters")
    observer.on_message(1, "/rosout", "/recorder", String())
    observer.on_message(1, "/parameter_events", "/recorder", ParameterEvent(node="/recorder"))
    assert not observer.violations

    observer.on_endpoint("/other", EndpointKind.SUBSCRIPTION, topic)
    assert [violation.split()[0] for violation in observer.violations] == ["/other"]


def test_a_viewer_neither_publishes_nor_calls(sink: Sink) -> None:
    observer = Observer(sink, viewers=["/recorder"])

    observer.on_message(1, "/goal", "/recorder", String())
    observer.on_request(2, f"{CAMERA}/get_state", "/recorder", CAMERA, GetState.Request(), NUMBER)
    observer.on_request(2, "/recorder/get_state", "/recorder", "/recorder", GetState.Request(), NUMBER)

    assert list(observer.violations) == [
        "/recorder publishes on /goal, and was said to be a viewer",
        f"/recorder calls {CAMERA}/get_state, and was said to be a viewer",
    ]


def test_whoever_reads_or_sets_the_truth_is_noted_once(sink: Sink) -> None:
    observer = Observer(sink)
    for _ in range(2):
        exchange(observer, setting("hardware_disconnect"), SetParameters.Response(results=[REFUSED]))
        exchange(observer, GetParameters.Request(names=["autofocus_needed"]), GetParameters.Response())
        exchange(observer, setting("perform_autofocus"), SetParameters.Response(results=[ACCEPTED]))
        for topic in ("/gt_segmentation", "/blackboard_group"):
            observer.on_endpoint(MANAGER, EndpointKind.SUBSCRIPTION, topic)
    assert list(observer.violations) == [
        f"{MANAGER} sets the fault parameter hardware_disconnect of {CAMERA}",
        f"{MANAGER} reads the fault parameter autofocus_needed of {CAMERA}",
        f"{MANAGER} subscribes to /gt_segmentation, which carries the truth",
    ]
