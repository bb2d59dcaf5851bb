"""Scenarios and their faults, checked when they are made."""

import math

import pytest

from sunset.errors import ScenarioError
from sunset.scenarios import Scenario, ScenarioFault, parse_scenario
from sunset.system import Value, current_system

FAULTS = current_system().faults


def test_a_fault_without_a_value_has_the_strength_of_the_suite() -> None:
    for name, fault in FAULTS.items():
        assert ScenarioFault(name).value == fault.value
        assert ScenarioFault(name).injection == fault.injection


def test_a_strength_reaches_the_injection() -> None:
    assert [step.value for step in ScenarioFault("depth_degradation", 3).injection] == [3.0]


def test_strengths_have_the_type_of_the_parameter() -> None:
    assert type(ScenarioFault("image_shift", 12.0).value) is int
    assert type(ScenarioFault("image_degradation", 1).value) is float


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("image_degradation", 2.5, "above 0 and at most 1.9, got 2.5"),
        ("image_degradation", -0.1, "got -0.1"),
        ("image_degradation", 0.0, "got 0.0"),
        ("image_degradation", math.nan, "got nan"),
        ("image_degradation", math.inf, "got inf"),
        ("image_degradation", True, "got true"),
        ("image_degradation", "much", "got 'much'"),
        ("image_shift", 2.5, "a whole number"),
        ("image_shift", 1921, "at most 1920"),
        ("gpu_failure", False, "must be true or left out, got false"),
        ("gpu_failure", 1, "must be true or left out, got 1"),
        ("unneeded_enhancement", "rgb_camera", "must be 'rgb_enhanced'"),
    ],
)
def test_a_value_that_a_fault_cannot_have_is_refused(name: str, value: Value, said: str) -> None:
    with pytest.raises(ScenarioError, match=name) as caught:
        ScenarioFault(name, value)
    assert said in str(caught.value)


def test_an_unknown_fault_is_answered_with_the_known_ones() -> None:
    with pytest.raises(ScenarioError, match=r"no fault 'gremlin'.*gpu_failure"):
        ScenarioFault("gremlin")


def test_a_fault_is_there_at_most_once() -> None:
    with pytest.raises(ScenarioError, match="gpu_failure twice"):
        Scenario("twice", (ScenarioFault("gpu_failure"), ScenarioFault("gpu_failure")))


def test_faults_that_cure_each_other_exclude_each_other() -> None:
    pair = (ScenarioFault("unneeded_enhancement"), ScenarioFault("image_degradation", 1.0))
    with pytest.raises(ScenarioError, match="image_degradation and unneeded_enhancement"):
        Scenario("both", pair)


@pytest.mark.parametrize("name", ["", "  ", "a\nb"])
def test_a_scenario_needs_a_name(name: str) -> None:
    with pytest.raises(ScenarioError, match="needs a name"):
        Scenario(name)


def test_yaml_round_trips() -> None:
    scenario = Scenario(
        "mine: with # signs",
        (
            ScenarioFault("image_shift", 7),
            ScenarioFault("gpu_failure"),
            ScenarioFault("image_degradation", 0.25),
        ),
        "Ünïcode, and a 'quote'.",
    )
    assert parse_scenario(scenario.to_yaml(), "there") == scenario


def test_a_name_that_looks_like_a_number_round_trips() -> None:
    assert parse_scenario(Scenario("12").to_yaml(), "there") == Scenario("12")
