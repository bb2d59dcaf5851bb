"""The managing system that reasons: what it repairs and when, what it believes, and what it leaves alone."""

from pathlib import Path

import pytest

from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.metrics import Command
from sunset.names import base_name
from sunset.recording import StoredRun
from sunset.scenarios import load_scenario

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


def test_noise_is_believed_in_when_all_else_is_excluded_and_looked_at_again(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", "depth_degradation", 7.0)

    modalities = [
        value
        for command in result.timeline.commands
        for name, value in zip(command.parameters, command.values, strict=True)
        if name == "modality"
    ]
    assert modalities == ["1", "0", "1"]
    last = result.timeline.diagnoses[-1].probabilities
    assert last["depth_degradation"] > 0.9
    assert all(probability < 0.5 for fault, probability in last.items() if fault != "depth_degradation")


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
