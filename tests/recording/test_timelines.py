from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace
from tests.recording.runs import RUN

from sunset.errors import RecordError
from sunset.metrics import Command as ObservedCommand
from sunset.metrics import Injection, Setting, Timeline
from sunset.recording import RecordedMessage, RecordWriter, read_messages, timeline_of
from sunset.system_interfaces.msg import (
    Command,
    Diagnosis,
    ExperimentLogging,
    FaultEnd,
    FaultInjection,
    FrameEvaluation,
    ImageDigest,
)
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sunset_ros.interfaces.lifecycle_msgs.msg import State, TransitionEvent
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter as RosParameter
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterEvent, ParameterValue
from sunset_ros.interfaces.std_msgs.msg import String

Row = tuple[str, int, Message]
START = RecordedMessage(
    "/experiment/log", 5, ExperimentLogging(source="experiment", rule_name="start", timestamp=10**9)
)


def of(*messages: RecordedMessage) -> Timeline:
    return timeline_of(RUN, [START, *messages])


@pytest.fixture
def whole(record: Path) -> Timeline:
    return timeline_of(RUN, read_messages(record))


def test_time_zero_is_the_start_in_the_experiments_log(whole: Timeline) -> None:
    times = whole.message_times["/managed_subsystem/segmentation"]
    assert times.tolist() == pytest.approx([0.065 + 0.1 * number for number in range(-2, 8)])


def test_message_times_are_those_of_the_pipelines_topics(whole: Timeline) -> None:
    assert sorted(whole.message_times) == [
        "/managed_subsystem/rgb_camera",
        "/managed_subsystem/segmentation",
        "/managed_subsystem/sensors_fused",
    ]
    assert whole.message_times["/managed_subsystem/rgb_camera"][2] == pytest.approx(0.022)
    assert whole.message_times["/managed_subsystem/sensors_fused"][2] == pytest.approx(0.025)


def test_entropy_and_sharpness_are_those_that_their_nodes_report(whole: Timeline) -> None:
    assert whole.samples["segmentation_entropy"].values.tolist() == [0.05] * 10
    assert whole.samples["camera_sharpness"].values.tolist() == [0.4] * 10
    assert whole.samples["segmentation_entropy"].times[2] == pytest.approx(0.066)
    assert whole.samples["camera_sharpness"].times[2] == pytest.approx(0.067)


def test_a_value_under_another_nodes_name_does_not_count() -> None:
    status = DiagnosticStatus(hardware_id="camera", values=[KeyValue(key="entropy", value="0.9")])
    found = of(RecordedMessage("/diagnostics", 0, DiagnosticArray(status=[status])))
    assert found.samples["segmentation_entropy"].values.size == 0


def test_a_frames_time_is_that_of_its_picture(whole: Timeline) -> None:
    assert whole.frames.times.tolist() == pytest.approx([0.02 + 0.1 * number for number in range(-2, 8)])


def test_a_frame_without_a_recorded_truth_has_the_time_of_its_evaluation() -> None:
    counts = np.ones(28, np.uint32)
    evaluation = FrameEvaluation(iou=0.5, intersection=counts, predicted=counts, truth=counts)
    assert of(RecordedMessage("/seg_metrics", 3 * 10**9, evaluation)).frames.times.tolist() == [2.0]


def test_a_frame_in_whose_truth_no_class_is_known_counts_for_no_quality() -> None:
    counts = np.zeros(28, np.uint32)
    evaluation = FrameEvaluation(iou=0.0, intersection=counts, predicted=counts, truth=counts)
    timeline = of(RecordedMessage("/seg_metrics", 3 * 10**9, evaluation))
    assert timeline.without_truth.tolist() == [2.0]
    assert not len(timeline.frames.times)


def test_frames_that_were_evaluated_late_are_in_order_of_their_pictures() -> None:
    counts = np.ones(28, np.uint32)
    messages = []
    for number in (1, 2):
        digest = ImageDigest()
        digest.header.stamp = Time(sec=number)
        messages.append(RecordedMessage("/gt_segmentation", number * 10**9, digest))
    for number in (2, 1):
        evaluation = FrameEvaluation(iou=number / 10, intersection=counts, predicted=counts, truth=counts)
        evaluation.header.stamp = Time(sec=number)
        messages.append(RecordedMessage("/seg_metrics", 5 * 10**9, evaluation))
    frames = of(*messages).frames
    assert frames.times.tolist() == [0.0, 1.0]
    assert frames.iou.tolist() == [0.1, 0.2]


def test_frames_carry_their_counts(whole: Timeline) -> None:
    assert whole.frames.iou.tolist() == [0.5] * 10
    assert whole.frames.intersection.shape == (10, 28)
    assert whole.frames.intersection.dtype == np.int64
    assert whole.frames.intersection[3].tolist() == list(range(3, 31))
    assert (whole.frames.predicted == 2 * whole.frames.intersection).all()
    assert (whole.frames.truth == 3 * whole.frames.intersection).all()


def test_injections_and_commands_have_the_times_of_their_stamps(whole: Timeline) -> None:
    assert whole.injections == (
        Injection(
            time=0.0,
            fault="hardware_disconnect",
            failure="F1",
            node="/managed_subsystem/camera",
            internal=True,
            redeploy_only=True,
        ),
    )
    assert whole.commands == (
        ObservedCommand(
            time=0.2,
            client="/manager",
            node="/managed_subsystem/camera",
            kind="set_parameters",
            parameters=("a",),
            values=("1",),
            successful=True,
        ),
    )


def test_an_injection_that_was_not_confirmed_does_not_count() -> None:
    messages = [
        RecordedMessage("/experiment/injections", 0, FaultInjection(fault=name, confirmed=confirmed))
        for name, confirmed in (("a", False), ("b", True))
    ]
    assert [injection.fault for injection in of(*messages).injections] == ["b"]


def test_an_injection_is_never_before_the_start_that_orders_it() -> None:
    stamps = [Time(sec=0, nanosec=990_000_000), Time(sec=1, nanosec=20_000_000)]
    messages = [
        RecordedMessage("/experiment/injections", 0, FaultInjection(fault="a", confirmed=True, stamp=stamp))
        for stamp in stamps
    ]
    assert [injection.time for injection in of(*messages).injections] == [0.0, 0.02]


@pytest.mark.parametrize(
    ("kind", "counted"),
    [("redeploy", [2.0]), ("shutdown", [2.0]), ("set_parameters", [1.0, 2.0]), ("activate", [1.0, 2.0])],
)
def test_before_the_first_frame_only_what_leaves_nothing_behind_does_not_count(
    kind: str, counted: list[float]
) -> None:
    messages = [
        RecordedMessage("/gt_segmentation", 3 * 10**9, ImageDigest()),
        RecordedMessage("/gt_segmentation", 4 * 10**9, ImageDigest()),
        *(
            RecordedMessage("/experiment/commands", 9, Command(stamp=Time(sec=sec), kind=kind))
            for sec in (2, 3)
        ),
    ]
    assert [command.time for command in of(*messages).commands] == counted


def test_commands_are_in_order_of_their_requests_not_of_their_answers() -> None:
    messages = [
        RecordedMessage("/experiment/commands", 9, Command(stamp=Time(sec=sec), kind="activate"))
        for sec in (3, 2)
    ]
    assert [command.time for command in of(*messages).commands] == [1.0, 2.0]


def test_an_experiment_in_which_nothing_came_out_has_an_empty_timeline() -> None:
    found = of()
    assert (
        len(found.message_times),
        found.samples["segmentation_entropy"].times.size,
        found.frames.times.size,
    ) == (0, 0, 0)
    assert found.frames.truth.shape == (0, 28)


def test_the_specification_of_the_run_is_handed_on() -> None:
    thresholds = {"entropy_threshold": 0.1, "sharpness_threshold": 0.3}
    found = timeline_of(replace(RUN, **thresholds, duration_s=7.0, period_s=0.2, expected_frames=35), [START])
    assert found.thresholds == thresholds
    assert (found.duration_s, found.period_s, found.expected_frames) == (7.0, 0.2, 35)


@pytest.mark.parametrize(("source", "rule"), [("experiment", "end"), ("manager", "start")])
def test_a_record_without_the_start_is_refused(source: str, rule: str) -> None:
    entry = ExperimentLogging(source=source, rule_name=rule)
    with pytest.raises(RecordError, match="does not say when the experiment began"):
        timeline_of(RUN, [RecordedMessage("/experiment/log", 0, entry)])


@pytest.mark.parametrize(
    ("topic", "expected"),
    [
        ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"),
        ("/seg_metrics", "system_interfaces/msg/FrameEvaluation"),
        ("/experiment/commands", "system_interfaces/msg/Command"),
        ("/experiment/injections", "system_interfaces/msg/FaultInjection"),
        ("/gt_segmentation", "system_interfaces/msg/ImageDigest"),
    ],
)
def test_a_message_of_another_type_is_refused(topic: str, expected: str) -> None:
    with pytest.raises(RecordError, match=f"on {topic} must be a {expected}, got a std_msgs/msg/String"):
        of(RecordedMessage(topic, 0, String()))


@pytest.mark.parametrize(("value", "expected"), [("high", "must be a number, got 'high'"), ("nan", "finite")])
def test_a_reported_value_that_is_no_number_is_refused(value: str, expected: str) -> None:
    status = DiagnosticStatus(hardware_id="segmentation", values=[KeyValue(key="entropy", value=value)])
    with pytest.raises(RecordError, match=expected):
        of(RecordedMessage("/diagnostics", 0, DiagnosticArray(status=[status])))


def test_messages_on_other_topics_do_not_matter(tmp_path: Path) -> None:
    with RecordWriter(tmp_path / "r") as writer:
        writer.write(START.topic, START.time_ns, START.message)
        writer.write("/blackboard_group", 0, String())
        messages = writer.messages({START.topic, "/blackboard_group"})
    assert len(messages) == 2
    found = timeline_of(RUN, messages)
    assert found.message_times == {}


def test_settings_are_what_managed_nodes_say_of_themselves() -> None:
    fusion, elsewhere = "/managed_subsystem/sensor_fusion", "/managing_system"
    rgb = ParameterValue(type=2, integer_value=1)
    states = TransitionEvent(start_state=State(label="activating"), goal_state=State(label="active"))
    found = of(
        RecordedMessage(f"{fusion}/transition_event", 4 * 10**9, states),
        RecordedMessage(
            "/parameter_events",
            2 * 10**9,
            ParameterEvent(
                node=fusion,
                new_parameters=[RosParameter(name="do", value=ParameterValue(type=1, bool_value=False))],
            ),
        ),
        RecordedMessage(
            "/parameter_events",
            3 * 10**9,
            ParameterEvent(
                node=fusion,
                changed_parameters=[
                    RosParameter(name="modality", value=rgb),
                    RosParameter(name="list", value=ParameterValue(type=9, string_array_value=["a"])),
                ],
            ),
        ),
        RecordedMessage(
            "/parameter_events",
            3 * 10**9,
            ParameterEvent(node=elsewhere, changed_parameters=[RosParameter(name="modality", value=rgb)]),
        ),
    ).settings
    assert found == (
        Setting(1.0, fusion, "do", "false", declared=True),
        Setting(2.0, fusion, "modality", "1"),
        Setting(3.0, fusion, "", "active"),
    )


def test_diagnoses_have_the_time_at_which_they_left_and_other_messages_do_not_count() -> None:
    topic = "/managing_system/diagnosis"
    found = of(
        RecordedMessage(topic, 3 * 10**9, Diagnosis(faults=["a", "b"], probabilities=[0.25, 1.0])),
        RecordedMessage(topic, 4 * 10**9, String(data="gpu_failure")),
        RecordedMessage(topic, 5 * 10**9, Diagnosis(faults=["a", "b"], probabilities=[1.0])),
    ).diagnoses
    assert [(one.time, dict(one.probabilities)) for one in found] == [
        (2.0, {"a": 0.25, "b": 1.0}),
        (4.0, {"a": 1.0}),
    ]


@pytest.mark.parametrize("cause", ["restart", ""])
def test_a_fault_that_had_healed_may_be_cured_while_it_is_away(cause: str) -> None:
    injection = FaultInjection(stamp=Time(sec=1), fault="sync_issue", confirmed=True)
    healed, cured = (FaultEnd(stamp=Time(), fault="sync_issue", cause=text) for text in ("", cause))
    (found,) = of(
        RecordedMessage("/experiment/injections", 10**9, injection),
        RecordedMessage("/experiment/fault_ends", 3 * 10**9, healed),
        RecordedMessage("/experiment/fault_ends", 5 * 10**9, cured),
    ).injections
    assert (found.healed, found.cured_away) == (2.0, 4.0 if cause else None)


@pytest.mark.parametrize(("stamp_s", "recorded_s"), [(2, 3), (3, 2)])
def test_a_fault_ends_no_sooner_than_its_end_was_seen(stamp_s: int, recorded_s: int) -> None:
    injection = FaultInjection(stamp=Time(sec=1), fault="sync_issue", confirmed=True)
    end = FaultEnd(stamp=Time(sec=stamp_s), fault="sync_issue", cause="redeploy")
    (found,) = of(
        RecordedMessage("/experiment/injections", 10**9, injection),
        RecordedMessage("/experiment/fault_ends", recorded_s * 10**9, end),
    ).injections
    assert (found.ended, found.cause) == (2.0, "redeploy")
