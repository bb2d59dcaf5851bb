"""Scenarios whose faults come, grow, go and follow each other in time."""

import re
from pathlib import Path

import pytest

from sunset.errors import ScenarioError
from sunset.scenarios import After, Profile, Scenario, ScenarioFault, onsets, parse_scenario

TIMED = """\
name: evening
duration: 60
flight: {town: 8, height: 50, angle: 60, time: evening, weather: hazy, seed: 3}
faults:
  - {name: image_degradation, severity: 3, at: 4.0, profile: {kind: ramp, rise: 5.0}}
  - {name: sync_issue, at: 12.0, until: 18.5}
  - {name: sync_issue, at: 30}
  - {name: depth_degradation, value: 0.3, profile: {kind: intermittent, on: 2.0, off: 3.0}}
  - {name: cuda_out_of_memory, at: 20}
  - {name: gpu_failure, after: {fault: cuda_out_of_memory, delay: 6.0}}
"""


def test_a_scenario_says_when_its_faults_come_and_go() -> None:
    scenario = parse_scenario(TIMED, "there")

    assert scenario.duration == 60
    assert scenario.flight is not None
    assert scenario.flight.town == 8
    growing, first, again, flickering, _, following = scenario.faults
    assert (growing.value, growing.severity, growing.profile) == (None, 3, Profile(kind="ramp", rise=5.0))
    assert (first.at, first.until, again.at, again.until) == (12.0, 18.5, 30.0, None)
    assert flickering.profile == Profile(kind="intermittent", on=2.0, off=3.0)
    assert following.after == After(fault="cuda_out_of_memory", delay=6.0)
    assert onsets(scenario.faults) == (4.0, 12.0, 30.0, 0.0, 20.0, 26.0)
    assert parse_scenario(scenario.to_yaml(), "again") == scenario


def test_a_scenario_without_times_is_written_as_before() -> None:
    scenario = Scenario("plain", (ScenarioFault("gpu_failure"),))
    assert scenario.to_yaml() == "name: plain\nfaults:\n- name: gpu_failure\n  value: true\n"


@pytest.mark.parametrize(
    ("faults", "said"),
    [
        (
            "{name: gpu_failure, at: -1}",
            "line 3: The onset (at) of a fault [s] must be a number from 0 to 3600, got -1.",
        ),
        (
            "{name: gpu_failure, at: soon}",
            "line 3: The onset (at) of a fault [s] must be a number from 0 to 3600, got 'soon'",
        ),
        ("{name: gpu_failure, at: .nan}", "line 3: The onset (at) of a fault [s] must be a number"),
        (
            "{name: gpu_failure, at: 20}",
            "line 3: The fault gpu_failure comes at 20 s, and the run ends at 20 s",
        ),
        (
            "{name: gpu_failure, at: 5, until: 5}",
            "line 3: The fault gpu_failure ends (until) at 5 s and comes at 5 s",
        ),
        (
            "{name: gpu_failure, when: 5}",
            "line 3: the key 'when' is not known here; there are name, value, at",
        ),
        (
            "{name: image_shift, profile: {kind: rmp}}",
            "line 3: There is no profile 'rmp': did you mean 'ramp'",
        ),
        ("{name: image_shift, profile: ramp}", "line 3: The profile ramp needs rise, got none"),
        (
            "{name: image_shift, profile: {kind: ramp, rise: -2}}",
            "line 3: The rise must be a number from 0.1 to 3600, got -2.",
        ),
        (
            "{name: image_shift, profile: {kind: ramp, rise: 2, on: 1}}",
            "line 3: The profile ramp needs rise, got rise, on",
        ),
        (
            "{name: gpu_failure, profile: {kind: ramp, rise: 2}}",
            "line 3: The fault gpu_failure has no strength that",
        ),
        (
            "{name: image_shift, severity: 2, value: 5}",
            "line 3: The fault image_shift has a severity and a value",
        ),
        (
            "{name: image_shift, severity: 6}",
            "line 3: The severity of a fault must be a whole number from 1 to 5, got 6.",
        ),
        (
            "{name: gpu_failure, severity: 1}",
            "line 3: The fault gpu_failure has no strength, and so no severity",
        ),
        (
            "{name: gpu_failure, at: 2, until: 6}\n- {name: gpu_failure, at: 5}",
            "line 4: The fault gpu_failure comes at 5 s, and is there from 2 s to 6 s",
        ),
        (
            "{name: gpu_failure, at: 2, until: 6}\n- {name: gpu_failure, at: 6}",
            "line 4: The fault gpu_failure comes at 6 s, and is there from 2 s to 6 s",
        ),
        (
            "{name: gpu_failure, after: {fault: sync_issue, delay: 2}}",
            "line 3: The fault gpu_failure comes after sync_issue, which is not in the scenario",
        ),
        (
            (
                "{name: sync_issue, after: {fault: gpu_failure, delay: 2}}\n"
                "- {name: gpu_failure, after: {fault: sync_issue, delay: 2}}"
            ),
            "line 3: The fault sync_issue comes after itself, by way of gpu_failure",
        ),
        (
            "{name: gpu_failure, after: {fault: gpu_failure, delay: 2}}",
            "line 3: The fault gpu_failure comes after itself: one",
        ),
        (
            "{name: gpu_failure, after: {fault: sync_issue, delay: 0}}\n- sync_issue",
            "line 3: The delay must be a number from 0.1 to 3600, got 0.",
        ),
        (
            "{name: sync_issue, until: 3}\n- {name: gpu_failure, after: {fault: sync_issue, delay: 4}}",
            "line 4: The fault gpu_failure never comes: sync_issue, which it follows after 4 s, heals at 3 s already",
        ),
        (
            "{name: sync_issue, at: 3}\n- {name: gpu_failure, at: 2, after: {fault: sync_issue, delay: 4}}",
            "line 4: The fault gpu_failure has an onset (at) and comes after sync_issue",
        ),
        (
            "{name: image_degradation, at: 3}\n- {name: unneeded_enhancement, at: 5}",
            "line 4: The scenario has both image_degradation and unneeded_enhancement at a time",
        ),
    ],
)
def test_faults_that_cannot_be_are_refused_with_their_line(faults: str, said: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(f"name: a\nfaults:\n- {faults}\n", "a.yaml")
    assert str(caught.value).startswith(f"a.yaml, {said}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("duration: 0.5", "line 2: The duration of a scenario [s] must be a number from 1 to 3600, got 0.5"),
        (
            "duration: long",
            "line 2: The duration of a scenario [s] must be a number from 1 to 3600, got 'long'",
        ),
        (
            "flight: town 8",
            "line 2: a mapping with bag, town, height, angle, time, weather, seed is expected for 'flight'",
        ),
        ("flight: {city: 8}", "line 2: the key 'city' is not known here; there are bag, town, height"),
        ("flight: {height: 0}", "line 2: The flight's height [m] must be a number from 20 to 300, got 0."),
        ("flight: {weather: rain}", "line 2: The flight's weather must be one of clear, hazy, overcast"),
        ("flight: {bag: 3}", "line 2: The bag must be a path, got 3."),
        (
            "flight: {bag: a, town: 8}",
            "line 2: A flight is a bag or is rendered, not both",
        ),
    ],
)
def test_a_duration_and_a_flight_that_cannot_be_are_refused_with_their_line(keys: str, said: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(f"name: a\n{keys}\nfaults: []\n", "a.yaml")
    assert str(caught.value).startswith(f"a.yaml, {said}")


def test_faults_that_exclude_each_other_may_come_one_after_the_other() -> None:
    first = ScenarioFault("image_degradation", until=5.0)
    Scenario("in turns", (first, ScenarioFault("unneeded_enhancement", at=5.0)))


def test_the_page_shows_every_key_in_an_example_that_can_be_read() -> None:
    page = (Path(__file__).parents[2] / "docs" / "scenarios.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```yaml\n(.*?)^```$", page, flags=re.MULTILINE | re.DOTALL)
    scenarios = [parse_scenario(block, "docs/scenarios.md") for block in blocks]

    texts = "".join(scenario.to_yaml() for scenario in scenarios)
    for key in (
        "duration",
        "value",
        "severity",
        "at",
        "until",
        "profile",
        "after",
        "rise",
        "'on'",
        "'off'",
        "delay",
    ):
        assert f" {key}:" in texts or f"\n{key}:" in texts
