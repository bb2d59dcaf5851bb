from dataclasses import replace
from pathlib import Path

import pytest

from sunset.evaluation.results import FIGURES, Flight, RunRow
from sunset.evaluation.summary import summarise
from sunset.recording import SETTINGS
from sunset.scenarios import scenario_names, suite, suite_size

HEALTHY: dict[str, float | None] = {
    **dict.fromkeys(FIGURES),
    "redeploys_unnecessary": 0,
    "t_down_s": 0.0,
    "availability": 1.0,
    "iou": 0.5,
    "iou_all": 0.5,
    "miou": 0.4,
    "episodes": 0,
    "episodes_resolved": 0,
    "episodes_unresolved": 0,
    "episodes_subsided": 0,
    "adaptations": 0,
}


def run(
    manager: str = "baseline",
    suite: str = "paper",
    seed: int = 1,
    *,
    scenario: str = "paper/a",
    model: str = "lite",
    middleware: str = "sim",
    version: str = "1.0.0",
    flight: Flight = Flight(20.0, bag="3c" * 32),  # noqa: B008  it cannot be changed
    thinking_s: float = 0.0,
    valid: bool = True,
    **metrics: float | None,
) -> RunRow:
    return RunRow(
        folder=Path("runs"),
        scenario=scenario,
        suite=suite,
        manager=manager,
        seed=seed,
        model=model,
        setting="0f",
        flight=flight,
        settings={**SETTINGS, "thinking_s": thinking_s},
        middleware=middleware,
        version=version,
        digest="",
        metrics=HEALTHY | metrics,
        valid=valid,
        reason="" if valid else "it cheated",
        suite_size=suite_size(suite) if scenario in scenario_names() else 0,
    )


def names(*runs: RunRow) -> list[str]:
    return [row.system for row in summarise(runs)]


def test_rows_come_in_the_papers_order_with_the_papers_names() -> None:
    runs = [
        run("zebra"),
        run("baseline"),
        run("none"),
        run("none", "degraded"),
        run("none", "nofault"),
    ]
    assert names(*runs) == ["none, no faults", "none, F4 and F5", "none", "baseline", "zebra"]


def test_other_suites_say_which_they_are() -> None:
    runs = [
        run(suite="artifact"),
        run(suite=""),
        run(suite="nofault"),
        run(suite="degraded"),
        run(suite="mine"),
    ]
    assert names(*runs) == [
        "baseline (artifact)",
        "baseline, no faults",
        "baseline, F4 and F5",
        "baseline (own scenarios)",
        "baseline (mine)",
    ]


def test_runs_of_several_versions_of_the_package_are_kept_apart() -> None:
    assert names(run(), run(seed=2)) == ["baseline"]
    assert names(run(), run(version="1.1.0"), run(version="")) == [
        "baseline [sunset unknown]",
        "baseline [sunset 1.0.0]",
        "baseline [sunset 1.1.0]",
    ]


def test_runs_of_several_models_or_middlewares_are_kept_apart() -> None:
    assert names(run(), run(model="reference")) == ["baseline [lite]", "baseline [reference]"]
    assert names(run(), run(middleware="cyclonedds")) == ["baseline [cyclonedds]", "baseline [sim]"]


def test_a_managing_system_in_a_file_is_called_by_the_files_name_unless_two_would_be() -> None:
    assert names(run("a/b/mine.py:Mine")) == ["mine.py:Mine"]
    assert names(run("a/mine.py:Mine"), run("b/mine.py:Mine")) == ["a/mine.py:Mine", "b/mine.py:Mine"]


def test_means_are_over_the_runs_and_pooled_counts_are_summed() -> None:
    (row,) = summarise(
        [
            run(seed=1, t_down_s=4.0, t_react_s=1.0, episodes=4, episodes_unresolved=1),
            run(seed=2, t_down_s=8.0, t_react_s=None, episodes=2, episodes_unresolved=2),
        ]
    )
    down, react = row.estimates["t_down_s"], row.estimates["t_react_s"]
    assert down is not None
    assert react is not None
    assert (row.runs, down.mean) == (2, 6.0)
    assert down.std == pytest.approx(8**0.5)
    assert (react.mean, react.runs) == (1.0, 1)
    assert (row.total("episodes"), row.total("episodes_unresolved"), row.unresolved_rate) == (6, 3, 0.5)


def test_intervals_end_where_a_figure_can_be_no_less_or_no_more() -> None:
    values = [(0.0, 20.0, 0.98), (0.0, 19.0, 0.99), (9.0, 20.0, 1.0)]
    (row,) = summarise(
        [
            run(seed=seed, t_react_s=react, t_down_s=down, availability=available, adaptations=seed)
            for seed, (react, down, available) in enumerate(values)
        ]
    )
    found = {name: row.estimates[name] for name in ("t_react_s", "t_down_s", "availability", "adaptations")}
    assert all(one is not None and one.low is not None and one.low < one.mean for one in found.values())
    ends = {name: (one.low, one.high) for name, one in found.items() if one is not None}
    assert (ends["t_react_s"][0], ends["adaptations"][0]) == (0.0, 0.0)
    assert (ends["t_down_s"][1], ends["availability"][1]) == (20.0, 1.0)
    assert ends["t_react_s"][1] is not None
    assert 9.0 < ends["t_react_s"][1] <= 20.0


def test_invalid_runs_take_no_part_and_are_listed() -> None:
    (row,) = summarise([run(iou=0.4), run(seed=2, iou=0.99, valid=False)])
    found = row.estimates["iou"]
    assert found is not None
    assert (row.runs, found.mean) == (1, 0.4)
    assert [one.reason for one in row.all_runs if not one.valid] == ["it cheated"]


def test_a_system_of_invalid_runs_only_still_has_a_row() -> None:
    (row,) = summarise([run(valid=False)])
    assert row.runs == 0
    assert set(row.estimates.values()) == {None}
    assert row.unresolved_rate is None


def test_reference_rows_judge_nothing_but_the_segmentation() -> None:
    (row,) = summarise([run("none", "nofault", scenario="nofault", t_down_s=1.0)])
    assert row.is_reference
    applicable = {name for name, found in row.estimates.items() if found is not None}
    assert applicable == {"iou", "iou_all", "miou"}


def test_no_managing_system_under_faults_has_its_downtime_judged() -> None:
    (row,) = summarise([run("none", t_down_s=20.0)])
    assert row.estimates["t_down_s"] is not None
    assert row.estimates["f_resolved_per_adaptation"] is None


def test_runs_that_measure_another_time_or_flight_have_rows_of_their_own() -> None:
    bag = "3c" * 32
    flights = [
        Flight(20.0, bag=bag),
        Flight(4.0, bag=bag),
        Flight(20.0, looped=True, bag=bag),
        Flight(4.5, looped=True, bag=bag),
    ]
    rows = summarise(run(flight=flight) for flight in flights)
    assert {row.system for row in rows} == {
        "baseline",
        "baseline [4 s]",
        "baseline [looped]",
        "baseline [4.5 s] [looped]",
    }
    several = summarise(run(flight=flight) for flight in (*flights[:2], Flight(20.0, bag="7e" * 32)))
    assert {row.system for row in several} == {
        "baseline [flight 3c3c3c3c]",
        "baseline [4 s] [flight 3c3c3c3c]",
        "baseline [flight 7e7e7e7e]",
    }
    assert {row.example.model for row in [*rows, *several]} == {"lite"}


def test_a_row_of_a_part_of_a_suite_says_so() -> None:
    first, second, *others = scenarios = [one.name for one in suite("paper")]
    (row,) = summarise([run(scenario=first), run(scenario=first, seed=2), run(scenario=second, valid=False)])
    assert row.system == "baseline [2 of 54 scenarios]"
    assert {one.seed for one in row.all_runs} == {1, 2}
    (whole,) = summarise([run(scenario=name) for name in scenarios])
    assert whole.system == "baseline"
    assert names(run(suite="mine", scenario="mine/a")) == ["baseline (mine)"]
    short = Flight(4.0, bag="3c" * 32)
    assert names(*(run(scenario=name, flight=short) for name in others)) == [
        "baseline [52 of 54 scenarios] [4 s]"
    ]
    assert names(run(suite="mine", scenario="mine/a", thinking_s=0.05)) == [
        "baseline (mine) [thinking 0.05 s]"
    ]


@pytest.mark.parametrize("name", SETTINGS)
def test_runs_with_other_settings_are_other_rows(name: str) -> None:
    other = replace(run(), settings={**SETTINGS, name: "diagnose" if name == "task" else 0.5})

    usual, unusual = sorted(names(run(), other))

    assert usual == "baseline"
    assert unusual.startswith("baseline [")


def test_the_order_of_runs_does_not_matter() -> None:
    runs = [run(seed=seed, iou=0.1 * seed, scenario=f"paper/{seed % 2}") for seed in range(1, 6)]
    assert summarise(runs) == summarise(reversed(runs))


def test_nothing_gives_nothing() -> None:
    assert summarise([]) == []
