from dataclasses import replace

import pytest

from sunset.errors import InvalidInputError
from sunset_lab import CONFIGS, MODALITIES, Schedule, TrainingConfig
from sunset_lab.config import Phase, Stage

pytestmark = pytest.mark.thorough


def test_all_modalities_share_one_plan_that_contains_both_branches() -> None:
    config = TrainingConfig()
    names = {layer.name for layer in config.layers("fusion")}
    assert {"rgb.logits", "depth.logits", "fusion.logits"} <= names
    assert {layer.name for layer in config.layers("rgb")} < names


def test_lite_learns_all_networks_at_once() -> None:
    (stage,) = CONFIGS["lite"].stages()
    assert stage.learned == MODALITIES
    assert stage.frozen == ()


def test_the_reference_learns_each_branch_and_then_merges_them_as_they_are() -> None:
    rgb, depth, fusion = CONFIGS["reference"].stages()
    assert (rgb.learned, depth.learned, fusion.learned) == (("rgb",), ("depth",), ("fusion",))
    assert (rgb.frozen, depth.frozen, fusion.frozen) == ((), (), ("rgb", "depth"))


def test_learned_weights_of_the_reference_are_learned_further_all_at_once_at_the_stride_of_use() -> None:
    (stage,) = CONFIGS["reference"].started().stages()
    assert (stage.learned, stage.frozen) == (MODALITIES, ())
    assert {phase.output_stride for phase in stage.schedule.phases} == {None}
    assert CONFIGS["lite"].started() == CONFIGS["lite"]


def test_the_second_branch_begins_with_the_first_ones_weights() -> None:
    config = CONFIGS["reference"]
    assert [stage.begun_with for stage in config.stages()] == [None, "rgb", None]
    for name in ("rgb", "depth"):
        (stage,) = replace(config, modalities=(name,)).stages()
        assert stage == Stage(name, (name,), config.schedule)


def test_a_step_belongs_to_the_phase_that_it_falls_into() -> None:
    schedule = Schedule(phases=(Phase(3, 8, 16), Phase(2, 4)))
    assert [schedule.phase(step).batch for step in range(5)] == [8, 8, 8, 4, 4]


@pytest.mark.parametrize("steps", [75, 1000, 9001])
def test_another_number_of_steps_shortens_all_phases_alike(steps: int) -> None:
    schedule = CONFIGS["reference"].schedule
    shorter = schedule.with_steps(steps)
    assert shorter.steps == steps
    for old, new in zip(schedule.phases, shorter.phases, strict=True):
        assert new.steps == pytest.approx(old.steps * steps / schedule.steps, abs=1)
    assert CONFIGS["reference"].with_steps(steps).schedule == shorter


def test_phases_that_are_left_without_a_step_are_dropped() -> None:
    schedule = Schedule(phases=(Phase(6, 8, 16), Phase(1, 4)))
    assert schedule.with_steps(2).phases == (Phase(2, 8, 16),)
    assert schedule.with_steps(7) == schedule


def test_the_learning_rate_rises_falls_and_falls_anew_where_a_phase_says_so() -> None:
    phases = (Phase(60, 1), Phase(40, 1), Phase(100, 1, learning_rate=0.5), Phase(100, 1))
    schedule = Schedule(phases=phases, learning_rate=1.0, warm_up=10)
    rates = [schedule.learning_rate_at(step) for step in range(schedule.steps)]
    assert rates[:2] == pytest.approx([0.1, 0.2], abs=1e-3)
    assert rates[50] == pytest.approx(0.5)
    assert rates[99] < 1e-3
    assert rates[100] == pytest.approx(0.05)
    assert rates[200] == pytest.approx(0.25)
    assert rates[299] < 1e-3
    assert max(rates[:100]) < 1.0
    assert max(rates[100:]) < 0.5


def test_a_name_that_no_card_can_hold_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="UTF-8"):
        TrainingConfig(name="a\udcff")
