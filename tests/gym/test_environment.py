"""The environment keeps Gymnasium's rules, and pays what a run of the same decisions is worth."""

import pickle
import re
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env

import sunset
from sunset.errors import InvalidInputError
from sunset.gym import Policy, RepairEnv
from sunset.system import current_system, extended_system

SCENARIO = "camera_driver_issue+image_degradation"
pytestmark = pytest.mark.usefixtures("flight")


def made(**options: Any) -> RepairEnv:
    chosen: dict[str, Any] = {"scenarios": [SCENARIO], "seeds": [1], "duration": 5.0} | options
    env = gymnasium.make("sunset/Repair-v0", disable_env_checker=True, **chosen).unwrapped
    assert isinstance(env, RepairEnv)
    return env


def drawn_actions(env: RepairEnv, seed: int = 1) -> tuple[list[int], list[float], dict[str, Any]]:
    """Play an episode at random; return its actions, its rewards and its last info."""
    _, info = env.reset(seed=seed)
    rng, actions, rewards, over = np.random.default_rng(seed), [], [], False
    while not over:
        usual = rng.random() < 0.7
        actions.append(0 if usual else int(rng.choice(np.flatnonzero(info["action_mask"]))))
        _, reward, _, over, info = env.step(actions[-1])
        rewards.append(reward)
    return actions, rewards, info


def replayed(actions: list[int]) -> type[Policy]:
    class Replayed(Policy):
        def act(self, observation: object, action_mask: object) -> int:
            del observation, action_mask
            return left.pop(0) if left else 0

    left = list(actions)
    return Replayed


@pytest.mark.parametrize("observation", ["arrays", "graph", "text"])
def test_the_environment_keeps_the_rules_of_gymnasium(observation: str) -> None:
    env = made(observation=observation, render_mode="rgb_array")

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env, skip_render_check=True)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_rewards_add_up_to_the_utility_of_a_confined_run_of_the_same_decisions(seed: int) -> None:
    actions, rewards, info = drawn_actions(made(), seed)

    run = sunset.run(SCENARIO, replayed(actions), seed=1, duration=5.0)

    assert run.metrics.utility is not None
    assert sum(rewards) == pytest.approx(run.metrics.utility, abs=1e-9)
    assert info["utility"] == run.metrics.utility
    assert run.metrics.cost_frames > 0


def test_a_scenario_with_an_unlisted_fault_pays_as_its_run_does_and_adds_no_action() -> None:
    env = made(scenarios="wild")
    observation, _ = env.reset(options={"scenario": "wild/glare"})
    assert env.observation_space.contains(observation)
    total, info = env.play(lambda *_: 0)
    run = sunset.run("wild/glare", "none", seed=1, duration=5.0)

    assert total == pytest.approx(run.metrics.utility, abs=1e-9)
    assert info["scenario"] == "wild/glare"
    assert env.action_names == made().action_names


def test_cures_are_paid_for_when_they_are_there() -> None:
    env, paying = made(), made(cure_reward=0.5)
    number = env.action_names.index("restart camera")
    camera = list(current_system().topics).index("rgb_camera")

    def repair(observation: dict[str, Any], mask: object) -> int:
        del mask
        stopped = observation["frequencies"][camera] == 0 and not observation["frequencies_missing"][camera]
        return number if stopped and observation["since"][number - 1] > 2 else 0

    env.reset()
    paying.reset()
    plain, _ = env.play(repair)
    paid, _ = paying.play(repair)

    assert paid == pytest.approx(plain + 0.5)


def test_processes_with_the_same_seed_give_the_same_trajectories(tmp_path: Path) -> None:
    script = (
        "import pickle, sys; from tests.gym.test_environment import *\n"
        "pickle.dump(trajectory(), open(sys.argv[1], 'wb'))"
    )
    for name in "ab":
        subprocess.run(
            [sys.executable, "-c", script, str(tmp_path / name)], check=True, cwd=Path(__file__).parents[2]
        )

    first, second = (pickle.loads((tmp_path / name).read_bytes()) for name in "ab")  # noqa: S301  our own
    assert first == second


def trajectory() -> list[bytes]:
    env = made(seeds=[], duration=2.0)
    env.reset(seed=7)
    steps = [env.step(number % 5 == 4) for number in range(30)]
    return [pickle.dumps(step) for step in steps]


def test_a_fork_does_not_change_the_episode_that_it_is_of() -> None:
    env = made()
    env.reset()
    for _ in range(20):
        env.step(0)
    repair = env.action_names.index("restart camera, or redeploy it")
    idle = env.fork(lambda copy: copy.play(lambda *_: 0))
    repaired = env.fork(lambda copy: copy.step(repair)[1] + copy.play(lambda *_: 0)[0])

    total, info = env.play(lambda *_: 0)

    assert idle == [total, info]
    assert repaired > total


def test_observations_and_masks_are_new_each_time_and_show_what_was_done() -> None:
    env = made()
    before, _ = env.reset()
    enhance = env.action_names.index("activate image_enhancement")
    after, *_, info = env.step(enhance)
    later, *_, info = env.step(0)

    assert not np.shares_memory(before["signals"], after["signals"])
    assert before["since"][enhance - 1] == 60
    assert after["since"][enhance - 1] == pytest.approx(0.2, abs=0.01)
    assert later["states"][2].tolist() == [0, 0, 1, 0, 0]
    assert not info["action_mask"][enhance]
    assert env.action_masks().tolist() == info["action_mask"].astype(bool).tolist()
    chosen = env.action_names.index("set sensor_fusion.modality to 1")
    modalities = slice(2, 5)
    assert later["settings"][modalities].tolist() == [1, 0, 0]
    assert env.step(chosen)[0]["settings"][modalities].tolist() == [0, 1, 0]


def test_other_forms_say_the_same() -> None:
    graph, _ = made(observation="graph").reset()
    text, _ = made(observation="text").reset()

    assert graph.nodes.shape == (5, 5 + 2 + 4 + 7 + 19)
    assert graph.edge_links.tolist() == [[0, 2], [1, 3], [0, 3], [2, 3], [3, 4]]
    assert "camera_lc_state: active\n" in text


def test_patience_waits_until_the_situation_changes_and_loses_no_reward() -> None:
    env, waiting = made(), made(patience=20)
    env.reset()
    plain, _ = env.play(lambda *_: 0)
    waiting.reset()
    total, over, situations = 0.0, False, []
    while not over:
        _, reward, _, over, _ = waiting.step(0)
        total += reward
        situations.append(waiting.situation)

    assert total == pytest.approx(plain, abs=1e-12)
    assert len(situations) < 15
    assert ("rgb_camera has stopped", "sensors_fused has stopped", "segmentation has stopped") in situations


def test_a_patient_policy_decides_as_a_patient_agent_does() -> None:
    env, chosen, over = made(patience=7), [], False
    env.reset()
    while not over:
        repair = "restart camera, or redeploy it" if env.situation else "nothing"
        chosen.append((repair, env.situation))
        _, _, _, over, info = env.step(env.action_names.index(repair))

    class Patient(Policy):
        patience = 7

        def act(self, observation: object, action_mask: object) -> int:
            del observation, action_mask
            repair, situation = left.pop(0)
            assert self.situation == situation
            return self.actions.names.index(repair)

    left = chosen[:]
    run = sunset.run(SCENARIO, Patient, seed=1, duration=5.0)

    assert run.metrics.utility == info["utility"]
    assert run.record.manager_failed is None
    assert len({situation for _, situation in chosen}) > 1


@pytest.mark.parametrize("kind", ["sync", "async"])
def test_vectors_of_environments_step(kind: str) -> None:
    vector = gymnasium.make_vec("sunset/Repair-v0", 2, kind, scenarios=[SCENARIO], duration=2.0)
    observations, infos = vector.reset(seed=3)
    observations, rewards, *_ = vector.step(np.zeros(2, int))

    assert observations["signals"].shape == (2, 2)
    assert infos["seed"][0] != infos["seed"][1]
    assert rewards.shape == (2,)
    vector.close()


def test_a_frame_is_drawn_under_its_segmentation() -> None:
    env = made(render_mode="rgb_array")
    env.reset()
    frame = env.render()

    assert frame is not None
    assert (frame.shape, frame.dtype) == ((144, 256, 3), np.dtype(np.uint8))
    assert frame.std() > 10
    assert made().render() is None


def test_extensions_add_their_nodes_and_adaptations_to_the_environment(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "extending.md").read_text(encoding="utf-8")
    source, *_ = (
        block
        for block in re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
        if "EXTENSION" in block
    )
    extension = tmp_path / "mine.py"
    extension.write_text(source, encoding="utf-8")
    with extended_system([extension]):
        system = current_system()
    new = set(system.adaptations) - set(current_system().adaptations)
    env = made(extensions=extension)
    check_env(env, skip_render_check=True)
    _, rewards, info = drawn_actions(env)

    assert {str(adaptation) for adaptation in new} < set(env.action_names)
    assert sum(rewards) == pytest.approx(info["utility"])
    assert made().action_names != env.action_names


def test_the_splits_scenarios_are_drawn() -> None:
    env = made(scenarios=(), count=3, split_seed=5)

    assert [scenario.name for scenario in env.scenarios] == ["train-0001", "train-0002", "train-0003"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"observation": "pixels"}, "There is no observation 'pixels'"),
        ({"scenarios": (), "split": "exam"}, "There is no split 'exam'"),
    ],
)
def test_arguments_are_checked(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        RepairEnv(**options)


def test_steps_out_of_turn_are_refused() -> None:
    env = made(duration=1.0)
    with pytest.raises(ResetNeeded):
        env.step(0)
    env.reset()
    with pytest.raises(InvalidInputError, match="must be a whole number from 0 to 25, got 26"):
        env.step(26)
    env.play(lambda *_: 0)
    with pytest.raises(ResetNeeded):
        env.step(0)
