"""The managing system that reasons: what it repairs and when, what it believes, and what it leaves alone."""

from pathlib import Path

import pytest

from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.metrics import Command
from sunset.recording import StoredRun
from sunset.scenarios import load_scenario
from sunset.system import extended_system
from sunset.texts.names import base_name

Done = tuple[str, str]


def fly(folder: Path, scenario: str, duration: float) -> StoredRun:
    settings = Settings(timing=Timing(duration_s=duration))
    result = run(RunSpec(scenario=load_scenario(scenario), manager="diagnosing", settings=settings), folder)
    assert result.record.valid, result.record.reason
    assert result.record.manager_failed is None
    return result


def done(commands: tuple[Command, ...]) -> list[Done]:
    """What was done, and to which node; of a restart both halves."""
    return [(command.kind, base_name(command.node)) for command in commands]


def test_a_healthy_system_is_left_alone(tmp_path: Path) -> None:
    assert fly(tmp_path / "run", "nofault", 3.0).timeline.commands == ()


def test_the_camera_is_repaired_and_done_without_meanwhile_and_nothing_else_is_touched(
    tmp_path: Path,
) -> None:
    result = fly(tmp_path / "run", "hardware_disconnect", 6.0)

    assert done(result.timeline.commands) == [
        ("deactivate", "camera"),
        ("activate", "camera"),
        ("redeploy", "camera"),
        ("set_parameters", "sensor_fusion"),
        ("set_parameters", "sensor_fusion"),
    ]
    assert [value for command in result.timeline.commands for value in command.values] == ["2", "0"]
    assert result.timeline.commands[0].time < 0.8  # before a second without messages is over
    assert result.metrics.t_down_s is not None
    assert result.metrics.t_down_s < 2.0  # less than half of what the camera takes to be back


def test_the_next_node_is_repaired_when_the_one_before_it_sends_again(tmp_path: Path) -> None:
    commands = fly(tmp_path / "run", "sync_issue+cuda_out_of_memory", 3.0).timeline.commands

    assert done(commands) == [
        ("deactivate", "sensor_fusion"),
        ("activate", "sensor_fusion"),
        ("deactivate", "segmentation"),
        ("activate", "segmentation"),
    ]


def modalities(result: StoredRun) -> list[str]:
    """What the fusion's modality was set to."""
    return [
        value
        for command in result.timeline.commands
        for name, value in zip(command.parameters, command.values, strict=True)
        if name == "modality"
    ]


def test_noise_is_believed_in_when_all_else_is_excluded(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", "depth_degradation", 5.0)

    assert modalities(result) == ["1"]
    last = result.timeline.diagnoses[-1].probabilities
    assert last["depth_degradation"] > 0.9
    assert all(probability < 0.5 for fault, probability in last.items() if fault != "depth_degradation")


@pytest.mark.thorough
def test_a_hidden_sensor_is_looked_at_again_when_that_pays(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", "depth_degradation", 26.0)

    assert modalities(result) == ["1", "0", "1"]


def test_what_darkens_the_only_image_that_is_seen_is_noticed_by_a_jump(tmp_path: Path) -> None:
    (tmp_path / "dark.yaml").write_text(
        "name: dark\nfaults:\n- {name: depth_degradation, at: 0}\n- {name: image_degradation, at: 4}\n"
    )
    result = fly(tmp_path / "run", str(tmp_path / "dark.yaml"), 6.5)

    assert {outcome.fault for outcome in result.metrics.outcomes if outcome.cured is not None} == {
        "depth_degradation",
        "image_degradation",
    }


def test_a_fault_that_came_while_its_node_booted_is_cured_when_it_shows(tmp_path: Path) -> None:
    (tmp_path / "boot.yaml").write_text(
        "name: boot\nfaults:\n- {name: hardware_disconnect, at: 0}\n- {name: autofocus_needed, at: 2}\n"
    )
    commands = fly(tmp_path / "run", str(tmp_path / "boot.yaml"), 7.0).timeline.commands

    assert commands[-1].parameters == ("perform_autofocus",)


def test_a_parameter_that_is_wrong_is_set_back_before_anything_shows(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", "unneeded_enhancement", 2.0)

    (command,) = result.timeline.commands
    assert (command.parameters, command.values) == (("topic_camera_input",), ("rgb_camera",))
    assert command.time < 0.5


@pytest.mark.thorough
def test_what_works_around_a_fault_of_the_world_is_kept_and_what_is_no_help_undone(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", "image_degradation", 5.0)

    topics = [
        value
        for command in result.timeline.commands
        for name, value in zip(command.parameters, command.values, strict=True)
        if name in {"topic_camera_input", "modality"}
    ]
    assert topics == ["rgb_enhanced"]
    assert result.metrics.faults_cured == 1


PROBE = """
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset.nodes import AdaptiveNode, FaultParameter, NodeParameter
from sunset.system import *


class Probe(AdaptiveNode):
    node_name = "probe"
    probe_hangs = FaultParameter(False, "internal fault: nothing comes out", cured_by_restart=True)

    def set_up(self):
        self.images = self.create_lifecycle_publisher(Image, "probed", 10)
        self.create_active_subscription(Image, "depth_camera", self.on_image)

    def on_image(self, message):
        if not self.probe_hangs:
            self.images.publish(message)


class Plotter(AdaptiveNode):
    node_name = "plotter"
    scale = NodeParameter(1.0, "metres in a pixel", minimum=0.0, maximum=9.0)

    def set_up(self):
        self.images = self.create_lifecycle_publisher(Image, "plotted", 10)
        self.create_active_subscription(Image, "probed", self.images.publish)


def silent(name, topic):
    return Failure(name, f"no {topic}", f"{topic} stopped", f"{topic} is back", topic=topic)


EXTENSION = Extension(
    nodes=(
        NodeDescription("probe", Probe, ("depth_camera",), ("probed",), 1.0, 0.001),
        NodeDescription("plotter", Plotter, ("probed",), ("plotted",), 1.0, 0.001),
    ),
    topics=(Topic("probed"), Topic("plotted")),
    failures=(silent("F6", "probed"), silent("F7", "plotted")),
    faults=(
        Fault(
            name="probe_hangs",
            failure="F6",
            node="probe",
            description="Nothing comes out.",
            cures=((restart("probe"),), (redeploy("probe"),)),
        ),
        Fault(
            name="wrong_scale",
            failure="F7",
            node="plotter",
            description="The scale is wrong.",
            parameter="scale",
            value=3.0,
            healthy=1.0,
            limits=(0.0, 9.0),
            kind=FaultKind.CONFIGURATION,
            cures=((Adaptation(AdaptationKind.SET_PARAMETER, "plotter", "scale", 1.0),),),
        ),
    ),
)
"""


def test_a_system_of_an_extension_is_repaired_where_it_is_broken(tmp_path: Path) -> None:
    (tmp_path / "probe.py").write_text(PROBE, encoding="utf-8")
    with extended_system([tmp_path / "probe.py"]):
        hangs = fly(tmp_path / "hangs", "probe_hangs", 2.0)
        scale = fly(tmp_path / "scale", "wrong_scale", 2.0)

    assert done(hangs.timeline.commands) == [("deactivate", "probe"), ("activate", "probe")]
    assert [(command.parameters, command.values) for command in scale.timeline.commands] == [
        (("scale",), ("1.0",))
    ]
    assert [outcome.fault for outcome in scale.metrics.outcomes if outcome.cured is not None] == [
        "wrong_scale"
    ]
