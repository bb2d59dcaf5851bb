"""The suites, counted independently of how they are made."""

from itertools import combinations

import pytest

from sunset.errors import ScenarioError
from sunset.scenarios import load_scenario, parse_scenario, scenario_names, suite, suite_names

OUTAGES = {
    "camera_driver_issue",
    "hardware_disconnect",
    "sync_issue",
    "memory_leakage",
    "cuda_out_of_memory",
    "gpu_failure",
}
OTHERS = {"image_degradation", "unneeded_enhancement", "image_shift", "depth_degradation", "autofocus_needed"}
PAIRS = {frozenset(pair) for pair in combinations(OTHERS, 2)} - {
    frozenset({"image_degradation", "unneeded_enhancement"})
}


def fault_sets(name: str) -> list[frozenset[str]]:
    return [frozenset(fault.name for fault in scenario.faults) for scenario in suite(name)]


def test_the_papers_suite_is_every_outage_with_every_possible_pair() -> None:
    sets = fault_sets("paper")
    assert len(sets) == 54
    assert set(sets) == {frozenset({outage}) | pair for outage in OUTAGES for pair in PAIRS}


def test_the_artifacts_suite_is_the_published_files() -> None:
    sets = fault_sets("artifact")
    assert len(sets) == 18
    degradations = ("image_degradation", "depth_degradation", "image_shift")
    assert set(sets) == {
        frozenset({outage, one, "autofocus_needed"}) for outage in OUTAGES for one in degradations
    }


def test_the_degraded_suite_is_the_pairs_without_an_outage() -> None:
    sets = fault_sets("degraded")
    assert len(sets) == 9
    assert set(sets) == PAIRS


def test_the_healthy_suite_has_one_run_without_faults() -> None:
    assert fault_sets("nofault") == [frozenset()]


def test_names_tell_suite_and_faults() -> None:
    assert suite("paper")[0].name == "paper/camera_driver_issue+image_degradation+image_shift"
    assert load_scenario("paper/camera_driver_issue+image_shift+autofocus_needed").faults[1].value == 10


def test_names_are_unique_and_each_is_found() -> None:
    names = scenario_names()
    assert len(set(names)) == len(names) == 54 + 18 + 1 + 9
    assert [load_scenario(name).name for name in names] == list(names)


def test_every_scenario_round_trips_through_yaml() -> None:
    for name in suite_names():
        for scenario in suite(name):
            assert parse_scenario(scenario.to_yaml(), "there") == scenario


def test_an_unknown_suite_is_answered_with_the_known_ones() -> None:
    with pytest.raises(
        ScenarioError, match="no suite 'papers': did you mean 'paper', or name paper, artifact"
    ):
        suite("papers")
