"""Scenarios: which faults a run injects, the paper's suites, and the node that injects them."""

from sunset.scenarios.executor import ScenarioExecutor
from sunset.scenarios.loading import generate, load_scenario, load_suite, parse_scenario
from sunset.scenarios.schema import Scenario, ScenarioFault
from sunset.scenarios.suites import scenario_names, suite, suite_names, suite_of

__all__ = [
    "Scenario",
    "ScenarioExecutor",
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
