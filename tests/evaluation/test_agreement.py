import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from sunset.errors import RecordError
from sunset.evaluation.agreement import Agreement, Pair, agrees, compare
from sunset.evaluation.differences import Difference
from sunset.evaluation.intervals import Estimate
from sunset.evaluation.results import FIGURES
from sunset.metrics import Episode, ExecutedAdaptation, RunMetrics, Timeline, score

Store = Callable[..., Path]
Edit = Callable[..., None]

REDEPLOY = ExecutedAdaptation(1.0, "camera", "redeploy")
RECALIBRATION = ExecutedAdaptation(
    2.0, "sensor_fusion", "set_parameter", "", ("do_recalibration",), ("true",)
)


@pytest.fixture
def fly(store: Store) -> Store:
    """Return a function that stores a simulated or a live run; the redeploy at `command_s` ends an outage."""

    def write(where: str, scenario: str = "paper/a", seed: int = 1, **options: Any) -> Path:
        manager = options.setdefault("manager", "baseline")
        folder = f"{where}/runs/{manager}/{scenario}/seed-{seed}"
        middleware = "sim" if where == "sim" else "cyclonedds"
        return store(folder, scenario=scenario, seed=seed, middleware=middleware, **options)

    return write


@pytest.fixture
def compared(tmp_path: Path) -> Callable[[], list[Agreement]]:
    return lambda: compare(tmp_path / "sim", tmp_path / "live")


def figure(agreement: Agreement, name: str) -> Difference:
    (found,) = [one for one in agreement.differences if one.figure == name]
    return found


def flown(*adaptations: ExecutedAdaptation, failures: str = "") -> RunMetrics:
    """Return the figures of a run with these adaptations, and an episode of each of these failures."""
    nothing = score(Timeline(thresholds={"entropy_threshold": 0.1, "sharpness_threshold": 1.0}))
    episodes = tuple(Episode(failure, 0.0, 1.0, None, True, None) for failure in failures.split())
    return RunMetrics(**nothing.to_json(), failures=episodes, executed=adaptations)  # type: ignore[arg-type]


def pair(sim: RunMetrics, live: RunMetrics) -> Pair:
    return Pair(scenario="paper/a", seed=1, sim=sim, live=live)


def test_runs_of_other_durations_are_compared_by_themselves(
    fly: Store, compared: Callable[[], list[Agreement]]
) -> None:
    for scenario, duration_s in (("paper/a", 20.0), ("paper/b", 21.0)):
        for where in ("sim", "live"):
            fly(where, scenario, duration_s=duration_s)
    found = {one.flight.duration_s: [pair.scenario for pair in one.pairs] for one in compared()}
    assert found == {20.0: ["paper/a"], 21.0: ["paper/b"]}


def test_runs_are_paired_by_scenario_and_seed(fly: Store, compared: Callable[[], list[Agreement]]) -> None:
    # a command at c resolves F1, began at 2.0, and the ripples F2 and F3, began at 1.9
    for scenario, sim_s, live_s in (("paper/a", 3.5, 3.6), ("paper/b", 4.0, 4.4), ("paper/c", 3.75, 4.0)):
        for seed in (1, 2, 3):
            fly("sim", scenario, seed, command_s=sim_s)
            fly("live", scenario, seed, command_s=live_s)
    (agreement,) = compared()
    assert (agreement.manager, agreement.suite, agreement.model) == ("baseline", "paper", "lite")
    pairs = [(one.scenario, one.seed) for one in agreement.pairs]
    assert pairs == [(f"paper/{name}", seed) for name in "abc" for seed in (1, 2, 3)]
    react = figure(agreement, "t_react_s")
    assert react.second == pytest.approx(3.75 - 5.8 / 3)
    assert react.first == pytest.approx(4.0 - 5.8 / 3)
    assert react.difference is not None
    assert react.difference.mean == pytest.approx(0.25)
    # of the differences 0.1, 0.4 and 0.25; Student's t of two degrees of freedom is 4.303
    half = 4.303 * 0.15 / math.sqrt(3)
    assert react.difference.low == pytest.approx(0.25 - half, abs=1e-3)
    assert react.difference.high == pytest.approx(0.25 + half, abs=1e-3)
    assert (react.pairs, react.one_sided) == (9, 0)


def test_every_figure_is_compared(fly: Store, compared: Callable[[], list[Agreement]]) -> None:
    fly("sim")
    fly("live")
    (agreement,) = compared()
    assert tuple(one.figure for one in agreement.differences) == FIGURES
    without = [one.figure for one in agreement.differences if one.difference is None]
    diagnosing, paying = without[:3], without[3:]
    assert diagnosing == ["t_detected_s", "t_located_s", "t_identified_s"]
    assert paying == ["tokens_in", "tokens_out", "price", "think_s"]
    compared_ones = [one for one in agreement.differences if one.figure not in without]
    assert all(agrees(one) for one in compared_ones)
    assert all(one.difference is not None and one.difference.mean == 0 for one in compared_ones)


def test_figures_are_computed_from_the_messages(
    fly: Store, edit: Edit, compared: Callable[[], list[Agreement]]
) -> None:
    fly("sim", iou=0.5)
    live = fly("live", iou=0.4)
    (honest,) = compared()
    edit(live, metrics=dict.fromkeys(FIGURES, 1) | {"faults_cured": 0})
    assert compared() == [honest]
    assert figure(honest, "iou").first == pytest.approx(0.4)


def test_a_pair_with_an_invalid_run_is_left_out_with_the_reason(
    fly: Store, compared: Callable[[], list[Agreement]]
) -> None:
    fly("sim", seed=1)
    fly("live", seed=1)
    fly("sim", seed=2)
    fly("live", seed=2, valid=False, reason="the computer was too slow", iou=0.1)
    fly("sim", seed=3, valid=False, reason="it read the truth")
    fly("live", seed=3)
    (agreement,) = compared()
    assert [one.seed for one in agreement.pairs] == [1]
    assert figure(agreement, "iou").first == pytest.approx(0.5)
    assert [(one.scenario, one.seed, one.reason) for one in agreement.left_out] == [
        ("paper/a", 2, "the live run is invalid: the computer was too slow"),
        ("paper/a", 3, "the simulated run is invalid: it read the truth"),
    ]


def test_a_run_without_a_partner_is_left_out(fly: Store, compared: Callable[[], list[Agreement]]) -> None:
    fly("sim", "paper/a")
    fly("live", "paper/b")
    (agreement,) = compared()
    assert agreement.pairs == ()
    assert [(one.scenario, one.reason) for one in agreement.left_out] == [
        ("paper/a", "there is no live run"),
        ("paper/b", "there is no simulated run"),
    ]
    assert all(agrees(one) is None for one in agreement.differences)


def test_a_figure_that_only_one_of_the_two_has_is_counted_and_takes_part_in_no_mean(
    fly: Store, compared: Callable[[], list[Agreement]]
) -> None:
    fly("sim", seed=1, command_s=3.5)
    fly("live", seed=1, command_s=3.6)
    fly("sim", seed=2, command_s=5.0)
    fly("live", seed=2, command_s=7.0)  # too late to have resolved anything
    (agreement,) = compared()
    react = figure(agreement, "t_react_s")
    assert (react.pairs, react.one_sided) == (1, 1)
    assert react.second == pytest.approx(3.5 - 5.8 / 3)
    assert figure(agreement, "t_down_s").pairs == 2


def test_managing_systems_are_kept_apart(fly: Store, compared: Callable[[], list[Agreement]]) -> None:
    for manager in ("baseline", "mine"):
        fly("sim", manager=manager)
        fly("live", manager=manager)
    assert [(one.manager, len(one.pairs)) for one in compared()] == [("baseline", 1), ("mine", 1)]


def test_repetitions_of_a_scenario_count_once(fly: Store, compared: Callable[[], list[Agreement]]) -> None:
    for scenario, live_s in (("a", 3.6), ("b", 3.8), ("c", 3.7)):
        for seed in (1, 2, 3):
            fly("sim", f"paper/{scenario}", seed)
            fly("live", f"paper/{scenario}", seed, command_s=live_s)
    (agreement,) = compared()
    difference = figure(agreement, "t_react_s").difference
    assert difference is not None
    # as of the three scenarios' means, 0.1, 0.3 and 0.2
    assert difference.high == pytest.approx(0.2 + 4.303 * 0.1 / math.sqrt(3), abs=1e-3)


@pytest.mark.parametrize(
    ("name", "sim", "difference", "expected"),
    [
        ("iou", 0.5, 0.09, True),
        ("iou", 0.5, -0.11, False),
        ("t_down_s", 1.0, 0.49, True),
        ("t_down_s", 1.0, -0.51, False),
        ("t_down_s", 5.0, 0.9, True),
        ("t_decide_s", -0.1, 0.6, False),
        ("redeploys_unnecessary", 0.0, 0.0, True),
        ("redeploys_unnecessary", 0.0, 0.1, False),
    ],
)
def test_a_figure_agrees_within_a_fifth_and_a_time_also_within_half_a_second(
    name: str, sim: float, difference: float, expected: bool
) -> None:
    found = Estimate(difference, None, None, None, 1)
    compared = Difference(figure=name, first=sim + difference, second=sim, difference=found)
    assert agrees(compared) is expected


def test_where_never_both_have_a_figure_it_agrees_only_if_none_has() -> None:
    lacking = Difference(figure="t_react_s", first=None, second=None, difference=None)
    assert agrees(lacking) is None
    assert agrees(replace(lacking, one_sided=2)) is False


def test_failures_are_the_same_however_often_they_came() -> None:
    assert pair(flown(failures="F4 F1 F4"), flown(failures="F1 F4")).same_failures
    other = pair(flown(failures="F1 F4"), flown(failures="F3 F1 F4"))
    assert not other.same_failures
    assert other.failures == (("F1", "F4"), ("F1", "F3", "F4"))


def test_adaptations_are_the_same_in_any_order_but_each_as_often() -> None:
    assert pair(flown(REDEPLOY, RECALIBRATION), flown(RECALIBRATION, REDEPLOY)).same_adaptations
    other = pair(flown(REDEPLOY, RECALIBRATION), flown(RECALIBRATION, REDEPLOY, RECALIBRATION))
    assert not other.same_adaptations
    assert other.adaptations == (
        {"redeploy camera": 1, "set_parameter sensor_fusion": 1},
        {"redeploy camera": 1, "set_parameter sensor_fusion": 2},
    )


def test_failures_and_adaptations_are_those_of_the_records(
    fly: Store, compared: Callable[[], list[Agreement]]
) -> None:
    fly("sim")
    fly("live")
    (agreement,) = compared()
    (only,) = agreement.pairs
    assert only.failures == (("F1", "F2", "F3"),) * 2
    assert only.adaptations == ({"redeploy camera": 1},) * 2


def test_a_folder_that_is_not_there(fly: Store, compared: Callable[[], list[Agreement]]) -> None:
    fly("sim")
    with pytest.raises(RecordError, match=r"no folder .*live; 'sunset agree --out' makes one"):
        compared()


def test_progress_is_by_pairs(fly: Store, tmp_path: Path) -> None:
    for seed in (1, 2):
        fly("sim", seed=seed)
        fly("live", seed=seed)
    seen: list[tuple[int, int]] = []
    compare(tmp_path / "sim", tmp_path / "live", progress=lambda *told: seen.append(told))
    assert seen == [(1, 2), (2, 2)]
