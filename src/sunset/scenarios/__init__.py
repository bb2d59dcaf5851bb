"""Scenarios: which faults a run injects, and the suites."""

from sunset.scenarios.loading import generate, load_scenario, load_suite, parse_scenario
from sunset.scenarios.schema import Scenario, ScenarioFault
from sunset.scenarios.suites import scenario_names, suite, suite_names, suite_of

__all__ = [
    "Scenario",
    "ScenarioFault",
    "generate",
    "load_scenario",
    "load_suite",
    "parse_scenario",
    "scenario_names",
    "suite",
    "suite_names",
    "suite_of",
]
