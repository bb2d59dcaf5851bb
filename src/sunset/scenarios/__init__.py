"""Scenarios: which faults a run injects, and the suites."""

from sunset.scenarios.courses import onsets, problems
from sunset.scenarios.loading import generate, load_scenario, load_suite, parse_scenario
from sunset.scenarios.schema import Scenario, ScenarioFault
from sunset.scenarios.severity import with_strengths
from sunset.scenarios.suites import scenario_names, suite, suite_names, suite_of
from sunset.scenarios.timing import After, Profile

__all__ = [
    "After",
    "Profile",
    "Scenario",
    "ScenarioFault",
    "generate",
    "load_scenario",
    "load_suite",
    "onsets",
    "parse_scenario",
    "problems",
    "scenario_names",
    "suite",
    "suite_names",
    "suite_of",
    "with_strengths",
]
