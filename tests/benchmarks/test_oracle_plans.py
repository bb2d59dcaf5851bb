"""The search for plans that beat the oracle: which plans there are, and that they are done when they say."""

from pathlib import Path

import pytest
from benchmarks.oracle_plans import DELAYS_S, MOST, plans

from benchmarks import oracle_plans
from sunset.managing import register_manager
from sunset.scenarios import load_scenario

pytestmark = pytest.mark.thorough


def test_every_move_is_done_at_every_delay_and_with_every_other() -> None:
    found = plans(load_scenario("sync_issue"), (0.05, 2.1))
    assert [" / ".join(map(str, plan)) for plan in found] == [
        "restart sensor_fusion at 0.05 s",
        "restart sensor_fusion at 2.1 s",
        "redeploy sensor_fusion at 0.05 s",
        "redeploy sensor_fusion at 2.1 s",
        "restart sensor_fusion at 0.05 s / redeploy sensor_fusion at 0.05 s",
        "restart sensor_fusion at 0.05 s / redeploy sensor_fusion at 2.1 s",
        "redeploy sensor_fusion at 0.05 s / restart sensor_fusion at 2.1 s",
        "restart sensor_fusion at 2.1 s / redeploy sensor_fusion at 2.1 s",
    ]


def test_no_plan_has_too_many_adaptations() -> None:
    found = plans(load_scenario("image_degradation+image_shift+autofocus_needed"), DELAYS_S)
    assert max(sum(len(step.move) for step in plan) for plan in found) == MOST


def test_a_plan_is_done_when_it_says(tmp_path: Path) -> None:
    start_s = (oracle_plans.fly("sync_issue", "none", 2.0, tmp_path / "none").record.start_ns or 0) / 1e9
    restart, *_ = plans(load_scenario("sync_issue"), (0.5,))
    oracle_plans.Planned.plan, oracle_plans.Planned.start_s = restart, start_s
    manager = register_manager(oracle_plans.Planned)
    commands = oracle_plans.fly("sync_issue", manager, 2.0, tmp_path / "planned").timeline.commands
    assert [command.kind for command in commands] == ["deactivate", "activate"]
    assert commands[0].time == pytest.approx(0.5, abs=0.02)
