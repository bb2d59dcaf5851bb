"""The managing system that looks at images: what it cures and how, what it leaves alone, and what it looked at."""

from pathlib import Path

import pytest

from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.managing import MANAGERS
from sunset.recording import StoredRun
from sunset.scenarios import load_scenario
from sunset.texts.names import base_name


def fly(folder: Path, scenario: str, duration: float = 2.0, manager: str = "inspecting") -> StoredRun:
    settings = Settings(timing=Timing(duration_s=duration))
    result = run(RunSpec(scenario=load_scenario(scenario), manager=manager, settings=settings), folder)
    assert result.record.valid, result.record.reason
    assert result.record.manager_failed is None
    return result


def done(result: StoredRun) -> list[str]:
    """What was done, in words; of a restart both halves."""
    return [
        " ".join((command.kind, base_name(command.node), *command.parameters, *command.values)).replace(
            "set_parameters ", ""
        )
        for command in result.timeline.commands
    ]


def test_a_healthy_system_is_left_alone(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", "nofault", 5.0)

    assert result.timeline.commands == ()
    assert all(not any(one.probabilities.values()) for one in result.timeline.diagnoses)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("fault", "cure"),
    [
        ("camera_driver_issue", ["deactivate camera", "activate camera"]),
        (
            "hardware_disconnect",
            [
                "deactivate camera",
                "activate camera",
                "redeploy camera",
                "sensor_fusion modality 2",
                "sensor_fusion modality 0",
            ],
        ),
        ("sync_issue", ["deactivate sensor_fusion", "activate sensor_fusion"]),
        (
            "memory_leakage",
            ["deactivate sensor_fusion", "activate sensor_fusion", "redeploy sensor_fusion"],
        ),
        ("cuda_out_of_memory", ["deactivate segmentation", "activate segmentation"]),
        (
            "gpu_failure",
            ["deactivate segmentation", "activate segmentation", "redeploy segmentation"],
        ),
        (
            "image_degradation",
            ["activate image_enhancement", "sensor_fusion topic_camera_input rgb_enhanced"],
        ),
        ("unneeded_enhancement", ["sensor_fusion topic_camera_input rgb_camera"]),
        ("image_shift", ["sensor_fusion do_recalibration true"]),
        ("depth_degradation", ["sensor_fusion modality 1"]),
        ("autofocus_needed", ["camera perform_autofocus true"]),
    ],
)
def test_it_cures_each_fault_and_does_nothing_else(tmp_path: Path, fault: str, cure: list[str]) -> None:
    result = fly(tmp_path / "run", fault, 6.0 if fault == "hardware_disconnect" else 4.0)

    assert done(result) == cure
    assert result.timeline.commands[0].time < 0.6  # two frames, and the time to the next call of adapt
    assert result.metrics.faults_cured == result.metrics.faults_injected == 1
    assert result.metrics.faults_identified == 1
    assert result.metrics.false_alarms == 0


def test_a_workaround_is_taken_back_when_the_fault_has_healed(tmp_path: Path) -> None:
    (tmp_path / "passing.yaml").write_text(
        "name: passing\nfaults:\n"
        "  - {name: image_degradation, value: 1.4, at: 0, until: 2}\n"
        "  - {name: depth_degradation, at: 1, until: 2.5}\n",
        encoding="utf-8",
    )
    result = fly(tmp_path / "run", str(tmp_path / "passing.yaml"), 4.0)

    assert done(result) == [
        "activate image_enhancement",
        "sensor_fusion topic_camera_input rgb_enhanced",
        "image_enhancement image_degradation 1.4",
        "sensor_fusion modality 1",
        "sensor_fusion topic_camera_input rgb_camera",
        "sensor_fusion modality 0",
    ]
    assert result.metrics.needless == 2  # taking back is no step of a cure
    assert not any(result.timeline.diagnoses[-1].probabilities.values())


@pytest.mark.thorough
def test_it_alone_looked_at_images(tmp_path: Path) -> None:
    evidence = {name: fly(tmp_path / name, "nofault", 1.0, name).record.evidence for name in MANAGERS}

    assert evidence == dict.fromkeys(MANAGERS, "symptoms") | {"inspecting": "images"}
