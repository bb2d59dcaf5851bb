"""The suites, counted independently of how they are made."""

from collections import Counter
from dataclasses import replace
from itertools import combinations

import pytest

from sunset.errors import ScenarioError
from sunset.scenarios import (
    load_scenario,
    onsets,
    parse_scenario,
    scenario_names,
    suite,
    suite_names,
    suite_of,
)
from sunset.system import get_fault

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


def test_single_has_each_fault_alone() -> None:
    assert sorted(fault_sets("single"), key=min) == [frozenset({name}) for name in sorted(OUTAGES | OTHERS)]


def test_outages_are_every_two_and_three_of_different_nodes() -> None:
    sets = fault_sets("outages")
    possible = [frozenset(some) for count in (2, 3) for some in combinations(sorted(OUTAGES), count)]
    nodes = {name: get_fault(name).node for name in OUTAGES}
    assert len(sets) == 12 + 8
    assert set(sets) == {some for some in possible if len({nodes[name] for name in some}) == len(some)}


def test_timed_has_each_outage_three_times_and_each_pair_twice_with_onsets_of_their_own() -> None:
    sets = Counter(fault_sets("timed"))
    assert max(sets.values()) == 1
    assert Counter(outage for some in sets for outage in some & OUTAGES) == dict.fromkeys(OUTAGES, 3)
    assert Counter(some - OUTAGES for some in sets) == dict.fromkeys(PAIRS, 2)
    onsets = [fault.at for scenario in suite("timed") for fault in scenario.faults]
    assert len(onsets) == 54
    assert 0 < min(onsets) < 1
    assert 12 < max(onsets) <= 13
    assert len(set(onsets)) > 40


def test_every_scenario_of_transient_has_a_fault_that_ends_grows_or_comes_and_goes() -> None:
    faults = [fault for scenario in suite("transient") for fault in scenario.faults]
    assert all(fault.until is not None or fault.profile.kind != "step" for fault in faults)
    assert {fault.name for fault in faults} == OUTAGES | OTHERS
    assert {fault.profile.kind for fault in faults} == {"step", "ramp", "intermittent"}


def test_every_scenario_of_cascade_has_one_fault_that_brings_the_others() -> None:
    for scenario in suite("cascade"):
        assert [fault.after is None for fault in scenario.faults].count(True) == 1
        assert max(onsets(scenario.faults)) < 12


def test_long_lasts_two_minutes_in_which_faults_come_until_the_end() -> None:
    for scenario in suite("long"):
        begun = sorted(onsets(scenario.faults))
        assert scenario.duration == 120
        assert len(begun) >= 8
        assert begun[0] < 20
        assert begun[-1] > 60


def test_a_scenario_is_of_its_suite_only_while_it_is_the_same() -> None:
    late = load_scenario("timed/gpu_failure+image_shift+depth_degradation")
    assert suite_of(late) == "timed"
    assert suite_of(replace(late, description="other words")) == "timed"
    assert suite_of(replace(late, duration=30.0)) == "timed"
    assert suite_of(replace(late, faults=late.faults[:2])) == ""
    assert suite_of(replace(late, name="mine/late")) == ""


def test_names_tell_suite_and_faults() -> None:
    assert suite("paper")[0].name == "paper/camera_driver_issue+image_degradation+image_shift"
    assert load_scenario("paper/camera_driver_issue+image_shift+autofocus_needed").faults[1].value == 10


def test_names_are_unique_and_each_is_found() -> None:
    names = scenario_names()
    assert len(set(names)) == len(names) == 54 + 18 + 1 + 9 + 11 + 20 + 18 + 14 + 7 + 6 + 4 + 9
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
