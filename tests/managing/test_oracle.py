"""The managing system that is told the truth: that it alone is told, and what it makes of it."""

from pathlib import Path

import pytest

from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.managing import KnownFault, ManagingSystem, Oracle, Symptoms, register_manager
from sunset.recording import StoredRun
from sunset.scenarios import load_scenario
from sunset.system import FaultKind


def fly(folder: Path, manager: str, scenario: str = "gpu_failure", duration: float = 3.0) -> StoredRun:
    settings = Settings(timing=Timing(duration_s=duration))
    return run(RunSpec(scenario=load_scenario(scenario), manager=manager, settings=settings), folder)


class Impostor(Oracle):
    """Would like to be told too."""


class Listener(ManagingSystem):
    """Reads what only the oracle may."""

    def on_start(self) -> None:
        from sunset.system_interfaces.msg import FaultInjection  # noqa: PLC0415

        self.create_subscription(FaultInjection, "/experiment/injections", lambda _: None, 10)

    def adapt(self, symptoms: Symptoms) -> None:
        """Do nothing."""


def test_it_repairs_before_any_symptom_shows(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", "oracle")

    assert result.record.valid, result.record.reason
    (command,) = result.timeline.commands
    assert (command.kind, command.node) == ("redeploy", "/managed_subsystem/segmentation")
    assert command.time < 0.1


def test_it_hinders_no_fault_that_comes_when_another_heals(tmp_path: Path) -> None:
    (tmp_path / "turn.yaml").write_text(
        "name: turn\nfaults:\n"
        "  - {name: image_degradation, at: 0, until: 2}\n"
        "  - {name: unneeded_enhancement, at: 2}\n",
        encoding="utf-8",
    )
    result = fly(tmp_path / "run", "oracle", str(tmp_path / "turn.yaml"), duration=5.0)

    assert result.record.valid, result.record.reason
    assert [outcome.fault for outcome in result.metrics.outcomes if outcome.cured is not None] == [
        "image_degradation",
        "unneeded_enhancement",
    ]


def test_no_other_class_is_told(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", register_manager(Impostor))

    assert "must be told the scenario, which only a run with --manager oracle does" in (
        result.record.manager_failed or ""
    )


def test_no_other_class_may_listen(tmp_path: Path) -> None:
    result = fly(tmp_path / "run", register_manager(Listener))

    assert not result.record.valid
    assert "subscribes to /experiment/injections, which carries the truth" in result.record.reason


@pytest.mark.parametrize(
    ("age_s", "end_s", "remaining_s"), [(0.0, 20.0, 8.0), (1.0, 4.0, 1.0), (3.0, 4.0, 2.0), (2.0, 2.9, 0.0)]
)
def test_what_comes_and_goes_is_there_for_a_part_of_the_time(
    age_s: float, end_s: float, remaining_s: float
) -> None:
    fault = KnownFault(
        name="gpu_failure", failure="F3", kind=FaultKind.INTERNAL, cures=(), value=True, on=2.0, off=3.0
    )
    assert fault.remaining_s(age_s, end_s) == pytest.approx(remaining_s)
