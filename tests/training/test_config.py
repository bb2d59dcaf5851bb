import pytest

from sunset.errors import InvalidInputError
from sunset.training import Schedule, TrainingConfig


def test_all_modalities_share_one_plan_that_contains_both_branches() -> None:
    config = TrainingConfig()
    names = {layer.name for layer in config.all_layers()}
    assert {"rgb.logits", "depth.logits", "fusion.logits"} <= names
    assert {layer.name for layer in config.layers("rgb")} < names


def test_one_branch_alone_can_be_trained() -> None:
    config = TrainingConfig(modalities=("depth",))
    assert config.all_layers() == config.layers("depth")


def test_an_unknown_modality_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="must be some of rgb, depth, fusion, got lidar"):
        TrainingConfig(modalities=("lidar",))


def test_no_modality_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="got none"):
        TrainingConfig(modalities=())


def test_fusion_without_its_branches_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="trained together with both branches"):
        TrainingConfig(modalities=("rgb", "fusion"))


def test_no_steps_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="at least one step and one frame a step, got 0 and 16"):
        TrainingConfig(schedule=Schedule(steps=0))
    assert TrainingConfig().with_steps(7).schedule == Schedule(steps=7)
